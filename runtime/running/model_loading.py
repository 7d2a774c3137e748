"""From a `.bg` file to a loaded model: taken from the cache, or compiled."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TypeAlias, TypeVar

import numpy as np

from bgc.building.build_result import Built
from bgc.building.recall import recall
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import NOTHING, ParameterValue

_Model = TypeVar("_Model", bound=LoadedModel)

Watch: TypeAlias = Callable[[str], None]
"""Called with the name of each stage of a compilation as it begins."""


def load_or_compile(
    path: Path,
    options: Options,
    seconds: dict[str, float] | None = None,
    watch: Watch | None = None,
) -> Built:
    """Take the build of an equal, earlier request from the cache, or compile.

    `seconds` is filled with the time that each stage took; `watch` is called with each stage as
    it begins.
    """
    seconds = {} if seconds is None else seconds
    start = perf_counter()
    if (found := recall(path, options)) is not None:
        seconds["from the cache"] = perf_counter() - start
        return found
    # The compiler takes longer to load than most runs take, and a recalled build needs none of it.
    from bgc.driver import compile_scene

    stages = compile_scene(path, options, watch=watch)
    seconds.update(stages.seconds)
    return stages.built


def load_model(
    path: Path, options: Options, parameters: Mapping[str, ParameterValue] = NOTHING
) -> LoadedModel:
    """Load a model from the cache, or compile it, with values of its parameters.

    Values that decide the model's structure (a `const`, a parameter of a part that the scene
    replaces) are compiled in; all others are set in the model's `parameters`.
    """
    return load_as(LoadedModel, path, options, parameters)


def load_as(
    kind: type[_Model],
    path: Path,
    options: Options,
    parameters: Mapping[str, ParameterValue],
    watch: Watch | None = None,
) -> _Model:
    """Load a model as `load_model` does, as an object of the class `kind`."""
    try:
        model = _load(kind, path, options, watch)
        known = model.parameters
        structural = {n: value for n, value in parameters.items() if not known.can_set(n, value)}
    except BgError:
        if not parameters:
            raise
        # A parameter without a default cannot be compiled without its value.
        structural = dict(parameters)
    if structural:
        texts = {name: _as_source(value) for name, value in structural.items()}
        overrides = {**dict(options.overrides), **texts}
        model = _load(kind, path, replace(options, overrides=tuple(overrides.items())), watch)
    for name, value in parameters.items():
        if name not in structural:
            model.parameters[name] = value
    return model


def _load(kind: type[_Model], path: Path, options: Options, watch: Watch | None) -> _Model:
    built = load_or_compile(path, options, watch=watch)
    return kind(built, path.absolute().parent, (path, options))


def _as_source(value: ParameterValue) -> str:
    """Write a value in the language."""
    if isinstance(value, str):
        return value
    if isinstance(value, (int, float)) or np.ndim(value) == 0:
        return repr(float(value))  # type: ignore[arg-type]
    return f"[{', '.join(_as_source(item) for item in value)}]"
