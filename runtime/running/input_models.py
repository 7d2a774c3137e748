"""Models that are compiled again with other inputs, for one run or for each of many."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from bgc.diagnostics.catalogue.inputs import uneven_inputs
from bgc.diagnostics.diagnostic import BgError
from bgc.options import RUN_NUMBER
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.cases import Cases, Sets, count_sets, parameter_sets
from bgc.runtime.running.inputs import Inputs, drives_of
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.model_loading import load_as
from bgc.runtime.running.run_inputs import drives_of_runs

_Model = TypeVar("_Model", bound=LoadedModel)


def compiled_again(
    model: _Model,
    drives: Sequence[tuple[str, str]],
    *,
    shapes: bool = False,
    open_inputs: Sequence[str] = (),
) -> _Model:
    """Compile the same model with other drives or its shapes, or load it from the cache.

    Parameters that were set stay set where the new model has them. Each of the `open_inputs` has a
    parameter of its name, which is added to what drives it.
    """
    path, options = model.source_for("shapes and no inputs")
    changed = replace(
        options,
        shapes=options.shapes or shapes,
        drives=tuple({**dict(options.drives), **dict(drives)}.items()),
        inputs=(*options.inputs, *open_inputs),
    )
    found = load_as(type(model), path, changed, {})
    found.parameters.take(model.parameters)
    return found


def driven(model: _Model, inputs: Inputs | None, rows: Array) -> _Model:
    """Drive a model's inputs, for a run with rows at these times, s; without any, unchanged."""
    return compiled_again(model, drives_of(inputs, rows)) if inputs else model


def driven_runs(
    model: _Model, inputs: Inputs | Sequence[Inputs] | None, parameters: Sets, rows: Array
) -> tuple[_Model, Sets, bool]:
    """Drive a model's inputs in each of many runs.

    One mapping of inputs is for all runs; a list has one for each. Returns the model, the parameter
    sets, and whether the runs differ by the parameter RUN_NUMBER. One set of parameters is repeated
    for a list of inputs. Raises BG560 for another number of inputs than of runs.
    """
    if not inputs:
        return model, parameters, False
    if isinstance(inputs, Mapping):
        return driven(model, inputs, rows), parameters, False
    count = count_sets(parameters)
    if count == 1 < len(inputs):
        parameters = list(parameter_sets(parameters)) * len(inputs)
    elif count != len(inputs):
        raise BgError([uneven_inputs(f"{len(inputs)} sets of inputs for {count} runs")])
    if len(inputs) == 1:
        return driven(model, inputs[0], rows), parameters, False
    return compiled_again(model, drives_of_runs(inputs, rows)), parameters, True


def numbered(cases: Cases) -> Cases:
    """The cases with the numbers of their runs, which decide the inputs."""
    numbers = np.arange(1.0, len(cases) + 1)
    return Cases((*cases.names, RUN_NUMBER), np.column_stack((cases.values, numbers)))
