"""The method that `bgc trade` recommended for a scene: what `solver auto` runs.

An answer belongs to a scene as it is compiled, with its parameters, its duration and rows, on this
machine, and to the accuracy and deadline that it requires. `bgc trade` keeps its measurements in
the same folder of the cache (`measuring.measured_store`).
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from bgc.building.backends import BACKENDS
from bgc.building.cache import digest_of, write_aside
from bgc.building.recall import machine_identity
from bgc.building.record_json import from_json, to_json
from bgc.building.user_folder import safe_cache_directory
from bgc.language.solver import Solver
from bgc.runtime.running.identity import scene_identity
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import ParameterValue

FOLDER = "trades"  # of the cache


def study_folder(model: LoadedModel, parameters: Mapping[str, float], *facts: object) -> Path:
    """The folder, relative to the cache, of measurements of a scene, which depend on the facts.

    `parameters` are values besides those that are set in the model, SI. Those of `bgc trade` depend
    on the duration and the interval of the rows, s.
    """
    identity = scene_identity(model, parameters)
    return Path(FOLDER, digest_of((*identity, *map(repr, facts), machine_identity())))


def recommended_method(
    model: LoadedModel, parameters: Mapping[str, ParameterValue]
) -> Solver | None:
    """The stored recommendation for the whole of a scene; None if there is none or it cannot run.

    `parameters` are values for this run alone.
    """
    facts = model.facts
    values = model.parameters.given(parameters)
    if facts.duration is None:
        return None
    try:
        root = safe_cache_directory()
    except (OSError, RuntimeError):  # no cache, or one that others may write to
        return None
    method = _read(_answer(root / study_folder(model, values, facts.duration, facts.every), model))
    known = (*model.solvers, *BACKENDS)
    return method if method is not None and method.name in known else None


def keep_recommendation(folder: Path, model: LoadedModel, method: Solver | None) -> None:
    """Store in a scene's folder the method that is recommended, or that none is.

    Raises OSError where the disk is full or may not be written.
    """
    path = _answer(folder, model)
    if method is None:
        path.unlink(missing_ok=True)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    write_aside(path, json.dumps(to_json(method)))


def _read(path: Path) -> Solver | None:
    with suppress(OSError, KeyError, ValueError, TypeError):  # nothing stored, or damaged
        value = json.loads(path.read_text(encoding="utf-8"))
        os.utime(path.parent)  # the last use, by which the cache is pruned
        found: Solver = from_json(Solver, value)
        return found
    return None


def _answer(folder: Path, model: LoadedModel) -> Path:
    """The file of an answer: other requirements or deadlines have another one."""
    facts = model.facts
    requested = digest_of((repr(facts.requirements), repr(facts.deadline)))
    return folder / f"answer-{requested}.json"
