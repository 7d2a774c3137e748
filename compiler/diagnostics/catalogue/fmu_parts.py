"""Diagnostics: FMUs of other tools as sampled parts."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, nearest
from bgc.diagnostics.source import Span


@error(
    "BG273: cannot read the FMU `{file}`: {why}",
    "name a Co-Simulation FMU of FMI 2.0 or 3.0, relative to this file",
)
def fmu_unreadable(span: Span | None, file: str, why: str) -> None: ...
@error(
    "BG274: {problem}",
    'write `signal y[2] = fmu("F.fmu", ["speed", "angle"], "torque", u);` in a `sample` block: '
    "file, variables to read, then names and values of those to set",
)
def fmu_misused(span: Span, problem: str) -> None: ...
@error("BG275: `{file}` has no variable `{name}`")
def no_fmu_variable(span: Span, file: str, name: str, known: Sequence[str]) -> Values:
    return nearest(name, known) or {"help": "`bgc import` of the FMU lists its variables"}


@error("BG276: `{name}` of `{file}` {what}", "{way}")
def fmu_variable_misused(span: Span, file: str, name: str, what: str, way: str) -> None: ...


# --- running ------------------------------------------------------------------------------------


@error(
    "BG670: `{file}` has not been imported on this machine, and a run executes the program in it",
    "if you trust its maker, run `bgc import {file}`; or list its folder in {variable}",
)
def fmu_not_imported(file: str, variable: str) -> None: ...
@error(
    "BG671: `{file}` has no binary for this machine ({wanted}), only for {platforms:listed}",
    "ask its maker for one, or run on a machine of that kind",
)
def fmu_without_binary(file: str, wanted: str, platforms: Sequence[str]) -> Values:
    return {"platforms": platforms or ("none",)}


@error("BG672: cannot open the FMU `{file}`: {reason}")
def fmu_not_opened(file: str, reason: str) -> None: ...
@error(
    "BG673: at t = {time:.9g} s the FMU `{file}` of `{name}` failed{reason}",
    "the rows up to there are right; try a shorter step of the part, or other values of its inputs",
)
def fmu_failed(time: float, file: str, name: str, reason: str, span: Span | None = None) -> Values:
    return {"reason": f": {reason}" if reason else ""}


@error(
    "BG674: {what} cannot hold the FMU `{name}` of another tool",
    "{way}",
)
def fmu_left_out(what: str, name: str, way: str) -> None: ...
