"""BG47x, BG65x, BG78x, BG79x: observables, tables of cases, stores, estimation, optimisation."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def bad_observable(
    text: str, reason: str, suggestion: str = "", span: Span | None = None
) -> Diagnostic:
    """BG787: a text that is not an observable of a run

    What: an observable is a function of one observed column over a run, such as `max(tension)`, and
    a criterion compares one with a number, such as `max(tension) < 300 kN`.

    Why: the text has another form, an unknown function, or an argument that the function does not
    have. In a scene, `require` without a tolerance compares an observed column, or its magnitude
    `abs(..)`, with a constant. In a sweep, the part `from .. to ..` may hold no row of the run.

    Example: `--observe "largest(tension)"`; in a scene `require 300 kN;`.

    Way out: write one of max, min, mean, rms, sd, range, peak, first, last, quantile(x, 0.95),
    crossings(x, level) and above(x, level); `from 20 s to 60 s` behind it takes a part of the run.
    """
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
    """BG788: a table of cases, of a recorded motion or of sea states that cannot be read

    What: the CSV file lacks a header or a column, or a cell is not a number.

    Why: the first line names the columns, each with an optional unit in brackets, and every other
    line has a number for each of them.

    Example: a line with two numbers below the header `mass [kg],damping,stiffness`.

    Way out: correct the line; decimal points are points, and columns are separated by commas.
    """
    place = f"line {line} of `{path}`" if line else f"`{path}`"
    return error(
        "BG788",
        f"{place} cannot be read: {reason}",
        help="write one line of names, `time,mass [t]`, and below it lines of as many numbers, "
        "separated by commas",
    )


def not_bounds(text: str) -> Diagnostic:
    """BG565: values of a parameter in place of its bounds

    What: `--vary` of `bgc fit` or `bgc optimise` gives a number of values, `log`, or a list that
    does not have two values.

    Why: an estimation or optimisation looks for the best value between two bounds, and takes its
    own values there. A sweep runs given values.

    Example: `bgc fit lift.bg --data lift.csv --vary "k=50..500 N/m:7"`

    Way out: `--vary "k=50..500 N/m"`; `--starts 7` tries several starting points.
    """
    return error(
        "BG565",
        f"`{text}` gives values where the bounds of a parameter are wanted",
        help='write `--vary "NAME=LOW..HIGH UNIT"`; `--starts 7` tries several starting points',
    )


def other_study(path: str, reason: str) -> Diagnostic:
    """BG789: a store of another study, or one that cannot be used

    What: the directory for the results exists, and what it holds does not belong to this study.

    Why: results are added to a store only if model, method, cases and observables are the same.

    Example: the same `--out study.zarr` after a parameter was changed.

    Way out: give another name, or delete the directory.
    """
    return error(
        "BG789",
        f"results cannot be added to `{path}`: {reason}",
        help="give another name, or delete it",
    )


def cluster_unusable(address: str, reason: str, way_out: str = "") -> Diagnostic:
    """BG799: a scheduler or its workers cannot be used

    What: `--scheduler` names a Dask scheduler that does not answer, that has no workers, or whose
    workers cannot build or run the model.

    Why: the workers need bgc of the same version, Python and a C compiler.

    Example: `--scheduler tcp://10.0.0.5:8786` before `dask worker` was started there.

    Way out: start `dask scheduler` and, on each machine, `dask worker ADDRESS --nworkers auto
    --nthreads 1` in an environment with `pip install bgc-lang[cluster]`.
    """
    return error(
        "BG799",
        f"the scheduler at {address} cannot be used: {reason}",
        help=way_out
        or "start `dask worker ADDRESS --nthreads 1` in an environment with this version of bgc",
    )


def not_identifiable(names: Sequence[str], condition: float) -> Diagnostic:
    """BG478: parameters that the data do not determine

    What: a change of some parameters together hardly changes the computed motion, so that the data
    determine their combination and not each of them.

    Why: the columns of the sensitivity matrix, each scaled to length 1, are almost linearly
    dependent (its condition number exceeds 10,000), or one of them is zero.

    Example: mass and stiffness from a free oscillation, which depends on their ratio alone.

    Way out: fix one of the parameters, observe another quantity, or record a motion that excites
    them differently.
    """
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
    """BG479: an estimation that cannot begin

    What: the parameters cannot be estimated from these data.

    Why: no column of the data is observed by the scene, `--match` names a column that the data or
    the scene do not have, there are fewer values than parameters, a
    start value is outside its bounds, or the run at the start values fails.

    Example: data with the columns `time` and `x` for a scene that observes `position`.

    Way out: name the columns as the scene does, or give `--match "position=x"`; give start values
    by `--set`.
    """
    return error("BG479", f"the parameters cannot be estimated: {reason}", help=way_out)


def cannot_optimise(reason: str, way_out: str) -> Diagnostic:
    """BG655: an optimisation that cannot begin

    What: no design can be compared with another one.

    Why: no parameter is varied, the bounds of one hold a single value of its range or are too far
    apart, a parameter is in `--vary` and in `--over`, the objective changes in steps and
    `--search gradient` is asked for, or the run at the start fails.

    Example: `--vary "k=5..5 N/m"`.

    Way out: widen the bounds, or begin at another design: `--set "k=100 N/m"`, `--starts 32`.
    """
    return error("BG655", f"the design cannot be optimised: {reason}", help=way_out)


def limits_not_met(exceeded: Sequence[str]) -> Diagnostic:
    """BG656: no design that was tried meets all limits

    What: the result is the design with the least excess over the limits, not one that meets them.

    Why: within the bounds of the parameters no design meets the limits, or the search ended
    before it found one.

    Example: `--require "max(force) < 1 N"` where the least force within the bounds is 3 N.

    Way out: widen the bounds, raise the limit, or search wider: `--starts 64`,
    `--search evolution`.
    """
    which = " and ".join(f"`{each}`" for each in exceeded)
    return warning(
        "BG656",
        f"no design that was tried meets {which}",
        help="widen the bounds, raise the limit, or search wider: `--starts 64`",
    )


def without_influence(names: Sequence[str]) -> Diagnostic:
    """BG657: a parameter without influence on the objective and the limits

    What: the derivatives of the objective and of all limits by this parameter are zero at the
    best design, so that its value there has no meaning.

    Why: the observed quantities do not depend on it, or the objective is the value of a quantity
    that is limited or at rest.

    Example: the stiffness of a stop that is not reached.

    Way out: omit the parameter, or observe a quantity that depends on it.
    """
    listed = ", ".join(f"`{name}`" for name in names)
    return warning(
        "BG657",
        f"{listed} has no influence on the objective and the limits at the best design",
        help="omit it from the varied parameters",
    )


def designs_failed(failed: int, runs: int, first: str) -> Diagnostic:
    """BG658: runs of an optimisation that failed

    What: some designs within the bounds cannot be simulated. The search counts them as worse than
    all others and goes on.

    Why: an assertion of the model does not hold for them, a law is undefined, or the integration
    does not proceed.

    Example: `--vary "k=1..1000 N/m"` of a model with `assert k < 900 N/m, "the spring breaks";`.

    Way out: none is needed where the best design is inside; bounds without such designs make the
    search shorter.
    """
    return warning(
        "BG658",
        f"{failed} of {runs} runs failed and count as worse than all others; the first: {first}",
        help="narrower bounds make the search shorter",
    )
