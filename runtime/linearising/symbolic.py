"""Formulas of a scene, with numbers for an operating point that the runtime finds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, TypeAlias

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.python_warnings import announce
from bgc.options import Options
from bgc.runtime.linearising.operating_point import OpenedModel, OperatingPoint
from bgc.symbolic.symbolic_model import SymbolicModel
from bgc.symbolic.system import Value
from bgc.symbolic.transfer import TransferFunction

Point: TypeAlias = "float | Literal['steady'] | None"


def symbolic_model(
    path: Path,
    options: Options,
    inputs: Sequence[str],
    outputs: Sequence[str],
    at: Point | Literal["start"] | Mapping[str, Value],
    values: Mapping[str, float],
) -> SymbolicModel:
    """A scene in letters, linearised as `bgc.Model.symbolic` says."""
    model = SymbolicModel(path, options, inputs, outputs, values)
    if at is None:
        return model
    if isinstance(at, Mapping):
        return model.at(at)
    if at == "start":
        return model.at({symbol.name: e for symbol, e in model.start.items()})
    names = [symbol.name for symbol in model.inputs]
    opened = OpenedModel(path, options, names, outputs, values)
    if at == "steady":
        near = _states(opened, opened.operating_point(at))
        return model.at({symbol.name: e for symbol, e in model.equilibrium(near).items()})
    reached = opened.operating_point(at)
    announce(reached.warnings)
    point: dict[str, Value] = {**_states(opened, reached), "time": float(at)}
    return model.at(point)


def transfer_at(
    path: Path, options: Options, output: str, input_: str, at: Point
) -> tuple[TransferFunction, dict[str, float], tuple[Diagnostic, ...]]:
    """A transfer function with states as letters, and their numbers at an operating point.

    The warnings are the compiler's, and those about the run to that point.
    """
    model = SymbolicModel(path, options, [input_], [output])
    function = model.transfer_function(output, input_)
    letters = {symbol.name for symbol in function.ratio.symbols}
    if not letters & {x.name for x in (*model.states, model.time)}:
        return function, {}, model.warnings
    opened = OpenedModel(path, options, [input_], [output])
    point = opened.operating_point(at)
    numbers = {name: x for name, x in _states(opened, point).items() if name in letters}
    if isinstance(at, float):
        numbers["time"] = at
    return function, numbers, (*model.warnings, *point.warnings)


def _states(opened: OpenedModel, point: OperatingPoint) -> dict[str, float]:
    names = (state.name for state in opened.opened.program.states)
    return dict(zip(names, point.state.tolist(), strict=True))
