"""The model and the goal of a study: what the scene requires, and what the user asks beside it."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from pathlib import Path

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.runtime.results.observables import columns_named, in_column_unit
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.model_loading import load_model
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.quantity import Quantity, read_quantity


def loaded_model(
    model: str | Path | LoadedModel,
    scene: str | None,
    parameters: Mapping[str, ParameterValue] | None,
    uses: Mapping[str, str] | None,
) -> LoadedModel:
    """Load the model of a study: a `.bg` file with its scene, or a model as it is.

    Raises ValueError for a model with a scene, parameters or uses besides.
    """
    if isinstance(model, LoadedModel):
        if scene or parameters or uses:
            raise ValueError("give the scene, parameters and uses of a model to `bgc.compile`")
        return model
    options = Options(scene, uses=tuple((uses or {}).items()))
    return load_model(Path(model), options, parameters or {})


def with_goal(
    model: LoadedModel, within: Mapping[str, Quantity], deadline: float | None
) -> LoadedModel:
    """The model with other required accuracies and another deadline, s, where they are given.

    Raises BgError: BG065 for an unknown column, BG062, BG063 and BG066 for its accuracy.
    """
    facts, required = model.facts, dict(model.facts.requirements)
    columns = {v.name: (v.unit, v.shown) for v in model.measured}
    for name, value in within.items():
        for column in columns_named(name, columns):
            unit = "" if columns[column][0] == "1" else columns[column][0]
            required[column] = in_column_unit(str(value), f"within {name}", unit, read_quantity)
            if not required[column] > 0:
                raise BgError([bad_option(f"within {name}", value, "a positive number")])
    asked = copy(model)
    deadline = facts.deadline if deadline is None else deadline
    asked.facts = replace(facts, requirements=tuple(required.items()), deadline=deadline)
    return asked


def requirers(model: LoadedModel, asked: LoadedModel) -> tuple[str, ...]:
    """Name what gives the required accuracies of `asked`: the scene, the command, or both."""
    own, all_ = {*model.facts.requirements}, {*asked.facts.requirements}
    found = {"require": own & all_, "--within": all_ - own}
    return tuple(name for name, required in found.items() if required)
