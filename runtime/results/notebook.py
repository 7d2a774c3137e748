"""Results, ensembles, linear forms and trades as a notebook shows them."""

from __future__ import annotations

import numpy as np

from bgc.printing.text_tables import Table
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.columns import RunColumns
from bgc.runtime.results.error_estimate import largest_error
from bgc.runtime.results.html import MOST_ROWS, figure_html, table_html
from bgc.runtime.results.plot import plot_result
from bgc.runtime.results.runs import Runs

_CURVES = 12  # columns up to which a result is drawn in its cell


def result_html(result: RunColumns) -> str:
    """Return the columns with their extremes, and the plot of a result with few of them."""
    rows = []
    for name in list(result)[:MOST_ROWS]:
        shown, values = result.shown_in(name), result[name]
        found = [values.min(), values.max(), values[-1]] if len(values) else []
        off = (largest_error(result, name),) if found and result.errors else ()
        rows.append((name, shown.label, *(f"{shown.number(float(v)):.6g}" for v in found), *off))
    header: tuple[str, ...] = ("column", "unit")
    if len(result.time):
        header += ("least", "greatest", "last", *(("+-",) if result.errors else ()))
    table = table_html(Table(repr(result).strip("<>"), header, tuple(rows)))
    count = len(list(result))
    drawn = len(result.time) > 1 and (result.panels or 0 < count <= _CURVES)
    return table + (figure_html(plot_result(result, None, None, None)) if drawn else "")


def ensemble_html(ensemble: Runs, time: Array) -> str:
    """Return the instances with their parameters, their status and their last values."""
    names = ensemble.names[:_CURVES]
    header = ("instance", *ensemble.parameters, "status", *(f"{name} at the end" for name in names))
    rows = []
    for k in range(min(ensemble.count, MOST_ROWS)):
        given = (f"{values[k]:.6g}" for values in ensemble.parameters.values())
        last = ensemble.values[k, -1] if len(time) else np.empty(0)
        shown = (f"{value:.6g}" for value in last[: len(names)].tolist())
        rows.append((str(k), *given, ensemble.status[k], *shown))
    more = ensemble.count - len(rows)
    note = f"{more} instances more" if more > 0 else ""
    return table_html(Table(repr(ensemble).strip("<>"), header, tuple(rows), note))
