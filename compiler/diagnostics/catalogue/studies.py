"""Diagnostics: sweeps, estimation, optimisation and their stores."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, quoted, warning
from bgc.diagnostics.source import Span


@error(
    "BG787: `{text}` is not an observable of a run: {reason}",
    "write for instance `max(tension)` or `quantile(tension, 0.95) from 20 s`",
)
def bad_observable(text: str, reason: str, help: str = "", span: Span | None = None) -> None: ...
# BG787, of a study of operability: neither its call nor its scene gives a criterion.
@error(
    "BG787: there is no criterion to examine: no `--require` is given, and the scene has no limit",
    'give `--require "max(tension) < 300 kN"`, or add `require tension < 300 kN;` to the scene',
)
def no_criterion() -> None: ...
@error(
    "BG788: {place} cannot be read: {reason}",
    "write one line of names, `time,mass [t]`, and below it lines of as many numbers, "
    "separated by commas",
)
def bad_case_table(path: str, reason: str, line: int = 0) -> Values:
    return {"place": f"line {line} of `{path}`" if line else f"`{path}`"}


@error(
    "BG565: `{text}` gives values where the bounds of a parameter are wanted",
    'write `--vary "NAME=LOW..HIGH UNIT"`; `--starts 7` tries several starting points',
)
def not_bounds(text: str) -> None: ...
@error("BG789: results cannot be added to `{path}`: {reason}", "give another name, or delete it")
def other_study(path: str, reason: str) -> None: ...
@error(
    "BG799: the scheduler at {address} cannot be used: {reason}",
    "start `dask worker ADDRESS --nthreads 1` in an environment with this version of bgc",
)
def cluster_unusable(address: str, reason: str, help: str = "") -> None: ...
@warning(
    "BG478: {what} (condition number {size})",
    "fix one of them, or fit a motion that depends on them separately",
)
def not_identifiable(names: Sequence[str], condition: float) -> Values:
    what = f"the data determine a combination of {quoted(names)}, not each of them"
    if len(names) == 1:
        what = f"{quoted(names)} has no influence on the fitted columns"
    return {"what": what, "size": "infinite" if condition == float("inf") else f"{condition:.2g}"}


@error("BG479: the parameters cannot be estimated: {reason}", "{way_out}")
def cannot_fit(reason: str, way_out: str) -> None: ...
@error("BG655: the design cannot be optimised: {reason}", "{way_out}")
def cannot_optimise(reason: str, way_out: str) -> None: ...
@warning(
    "BG656: no design that was tried meets {which}",
    "widen the bounds, raise the limit, or search wider: `--starts 64`",
)
def limits_not_met(exceeded: Sequence[str]) -> Values:
    return {"which": " and ".join(f"`{each}`" for each in exceeded)}


@warning(
    "BG657: {names:quoted} has no influence on the objective and the limits at the best design",
    "omit it from the varied parameters",
)
def without_influence(names: Sequence[str]) -> None: ...
@warning(
    "BG658: {failed} of {runs} runs failed and count as worse than all others; the first: {first}",
    "narrower bounds make the search shorter",
)
def designs_failed(failed: int, runs: int, first: str) -> None: ...


@error(
    "BG661: nothing says how accurate {scene:scene} must be",
    'give `--within "NAME: VALUE"`, or add `require NAME within VALUE;` to the scene',
)
def nothing_required(scene: str) -> None: ...
@error(
    "BG665: `{part}` cannot be reduced: {reason}",
    "reduce a part with ports, whose laws are those of C, I, R, TF and GY in their own variables",
)
def part_not_reduced(part: str, reason: str) -> None: ...
