"""BG47x, BG65x, BG78x, BG79x: observables, tables of cases, stores, estimation, optimisation."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def bad_observable(
    text: str, reason: str, suggestion: str = "", span: Span | None = None
) -> Diagnostic:
    """BG787: a text that is not an observable of a run"""
    return error(
        "BG787",
        f"`{text}` is not an observable of a run: {reason}",
        span,
        help=suggestion
        or "write for instance `max(tension)` or `quantile(tension, 0.95) from 20 s`",
    )


def no_criterion() -> Diagnostic:
    """BG787, of a study of operability: neither its call nor its scene gives a criterion."""
    return error(
        "BG787",
        "there is no criterion to examine: no `--require` is given, and the scene has no limit",
        help='give `--require "max(tension) < 300 kN"`, or add `require tension < 300 kN;` to the '
        "scene",
    )


def bad_case_table(path: str, reason: str, line: int = 0) -> Diagnostic:
    """BG788: a table of cases, of a recorded motion or of sea states that cannot be read"""
    place = f"line {line} of `{path}`" if line else f"`{path}`"
    return error(
        "BG788",
        f"{place} cannot be read: {reason}",
        help="write one line of names, `time,mass [t]`, and below it lines of as many numbers, "
        "separated by commas",
    )


def not_bounds(text: str) -> Diagnostic:
    """BG565: values of a parameter in place of its bounds"""
    return error(
        "BG565",
        f"`{text}` gives values where the bounds of a parameter are wanted",
        help='write `--vary "NAME=LOW..HIGH UNIT"`; `--starts 7` tries several starting points',
    )


def other_study(path: str, reason: str) -> Diagnostic:
    """BG789: a store of another study, or one that cannot be used"""
    return error(
        "BG789",
        f"results cannot be added to `{path}`: {reason}",
        help="give another name, or delete it",
    )


def cluster_unusable(address: str, reason: str, way_out: str = "") -> Diagnostic:
    """BG799: a scheduler or its workers cannot be used"""
    return error(
        "BG799",
        f"the scheduler at {address} cannot be used: {reason}",
        help=way_out
        or "start `dask worker ADDRESS --nthreads 1` in an environment with this version of bgc",
    )


def not_identifiable(names: Sequence[str], condition: float) -> Diagnostic:
    """BG478: parameters that the data do not determine"""
    listed = ", ".join(f"`{name}`" for name in names)
    if len(names) == 1:
        what = f"{listed} has no influence on the fitted columns"
    else:
        what = f"the data determine a combination of {listed}, not each of them"
    size = "infinite" if condition == float("inf") else f"{condition:.2g}"
    return warning(
        "BG478",
        f"{what} (condition number {size})",
        help="fix one of them, or fit a motion that depends on them separately",
    )


def cannot_fit(reason: str, way_out: str) -> Diagnostic:
    """BG479: an estimation that cannot begin"""
    return error("BG479", f"the parameters cannot be estimated: {reason}", help=way_out)


def cannot_optimise(reason: str, way_out: str) -> Diagnostic:
    """BG655: an optimisation that cannot begin"""
    return error("BG655", f"the design cannot be optimised: {reason}", help=way_out)


def limits_not_met(exceeded: Sequence[str]) -> Diagnostic:
    """BG656: no design that was tried meets all limits"""
    which = " and ".join(f"`{each}`" for each in exceeded)
    return warning(
        "BG656",
        f"no design that was tried meets {which}",
        help="widen the bounds, raise the limit, or search wider: `--starts 64`",
    )


def without_influence(names: Sequence[str]) -> Diagnostic:
    """BG657: a parameter without influence on the objective and the limits"""
    listed = ", ".join(f"`{name}`" for name in names)
    return warning(
        "BG657",
        f"{listed} has no influence on the objective and the limits at the best design",
        help="omit it from the varied parameters",
    )


def designs_failed(failed: int, runs: int, first: str) -> Diagnostic:
    """BG658: runs of an optimisation that failed"""
    return warning(
        "BG658",
        f"{failed} of {runs} runs failed and count as worse than all others; the first: {first}",
        help="narrower bounds make the search shorter",
    )
