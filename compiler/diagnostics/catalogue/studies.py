"""BG47x, BG78x, BG79x: observables of runs, tables of cases."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def bad_observable(text: str, reason: str, suggestion: str = "") -> Diagnostic:
    """BG787: a text that is not an observable of a run

    What: an observable is a function of one observed column over a run, such as `max(tension)`, and
    a criterion compares one with a number, such as `max(tension) < 300 kN`.

    Why: the text has another form, an unknown function, or an argument that the function does not
    have.

    Example: `--observe "largest(tension)"`.

    Way out: write one of max, min, mean, rms, sd, range, peak, first, last, quantile(x, 0.95),
    crossings(x, level) and above(x, level); `from 20 s to 60 s` behind it takes a part of the run.
    """
    return error(
        "BG787",
        f"`{text}` is not an observable of a run: {reason}",
        help=suggestion
        or "write for instance `max(tension)` or `quantile(tension, 0.95) from 20 s`",
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
    return error("BG788", f"{place} cannot be read: {reason}", help="see `bgc doc BG788`")
