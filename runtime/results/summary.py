"""A summary of a run in a few lines."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from bgc.language.column_names import name_in_si
from bgc.printing.text_tables import Table, table_text
from bgc.runtime.results.error_estimate import largest_error, why_unknown
from bgc.runtime.results.requirements import requirement_table
from bgc.runtime.results.rest_report import described
from bgc.runtime.results.result import Result

_MOST_COLUMNS = 12
_UNKNOWN = np.array([np.nan])


def summarise(result: Result) -> str:
    """Summarise the time reached, the steps and seconds spent, and the energy residual."""
    counts = result.counts
    reached = float(result.time[-1]) if len(result.time) else 0.0
    spent = counts["run_seconds"]
    factor = f", {reached / spent:.3g} x real time" if spent > 0 and reached > 0 else ""
    ended = "" if result.status == "done" else f" ({result.status})"
    rejected = f" ({counts['rejected']:.0f} rejected)" if counts["rejected"] else ""
    events = f", {_count(counts['events'], 'event')}" if counts["events"] else ""
    lines = [
        f"{result.scene}: {_seconds(reached)} simulated in {_seconds(spent)}{factor}{ended}",
        f"  {result.solver}: {_count(counts['steps'], 'step')}{rejected}{events}, "
        f"{_count(result.row_count, 'row')}, worst step {_seconds(counts['worst_step_seconds'])}",
    ]
    if counts["method_changes"]:
        lines.append(
            f"  {counts['explicit_steps']:,.0f} of them explicit, "
            f"{_count(counts['method_changes'], 'change')} of method"
        )
    if result.at_rest is not None:
        lines += [f"  {line}" for line in described(result.at_rest)]
    if counts["subdivided"]:
        lines.append(
            f"  {_count(counts['subdivided'], 'step')} subdivided, at most "
            f"{_count(counts['most_attempts'], 'attempt')} each"
        )
    if counts["fallbacks"]:
        lines.append(f"  {counts['fallbacks']:,.0f} factorisations needed full pivoting")
    if result.faster:
        lines.append(f"  nothing in it is stiff: `--solver {result.faster}` is likely to be faster")
    if residual := _residual(result):
        lines.append(f"  {residual}")
    return "\n".join(lines)


def extremes(result: Result) -> str:
    """Make a table of the last, the least and the largest value of each observed column.

    With estimated errors, `+-` has the largest of each to one digit.
    """
    if not len(result):
        return "the scene observes nothing: add `observe NAME;`"
    if not len(result.time):
        return ""
    rows = []
    for name, column in list(result.columns.items())[:_MOST_COLUMNS]:
        shown = result.shown_in(name)
        column = column / shown.factor
        finite = column[np.isfinite(column)]
        ends = (finite.min(), finite.max()) if len(finite) else (np.nan, np.nan)
        names_its_unit = name_in_si(name) != name
        label = f"{name} [{shown.label}]" if shown.label and not names_its_unit else name
        off = (largest_error(result, name),) if result.errors else ()
        rows.append((label, *(f"{value + 0.0:.6g}" for value in (column[-1], *ends)), *off))
    more = len(result) - len(rows)
    notes = [f"and {_count(more, 'column')} more"] if more else []
    if result.errors and (why := why_unknown(result.error_estimate)):
        notes.append(f"+- {why}")
    heads = ("", "last", "least", "largest", *(("+-",) if result.errors else ()))
    return table_text(Table("", heads, tuple(rows), "\n".join(notes))).strip("\n")


def requirements(result: Result) -> str:
    """Make a table of what the scene requires; empty where it requires nothing."""
    if not result.requirements:
        return ""
    return table_text(requirement_table(result.requirements)).strip("\n")


def as_json(result: Result) -> str:
    """Write the summary as JSON, in SI units or those of the columns; null for what is not known.

    `error` is the largest estimated error of a column, or that of a required value.
    """
    value = {
        "scene": result.scene,
        "status": result.status,
        "message": result.message,
        "solver": result.solver,
        "time": float(result.time[-1]) if len(result.time) else None,
        "rows": result.row_count,
        "counts": {name: _finite(count) for name, count in result.counts.items()},
        "columns": {name: _as_json(result, name) for name in result.columns},
        "error_estimate": result.error_estimate,
        "requirements": [
            {
                "require": each.text,
                "value": _finite(each.value),
                "error": _finite(each.error),
                "limit": each.limit,
                "margin": _finite(each.margin),
                "holds": each.holds,
                "time": _finite(each.time),
            }
            for each in result.requirements
        ],
    }
    return json.dumps(value, indent=2)


def _as_json(result: Result, name: str) -> dict[str, Any]:
    column, error = result.columns[name], result.errors.get(name, _UNKNOWN)
    finite = column[np.isfinite(column)]
    return {
        "unit": result.units[name],
        "last": _finite(column[-1]) if len(column) else None,
        "least": float(finite.min()) if len(finite) else None,
        "largest": float(finite.max()) if len(finite) else None,
        "error": _finite(np.max(error)) if len(error) else None,
    }


def _finite(number: float) -> float | None:
    return float(number) if np.isfinite(number) else None


def _count(number: float, word: str) -> str:
    return f"{number:,.0f} {word}" if number == 1 else f"{number:,.0f} {word}s"


def _residual(result: Result) -> str:
    """Describe the energy residual, and its share of the largest observed account."""
    columns = {account: result.in_joules(account) for account in result.accounts}
    if "residual" not in columns or not len(result.time):
        return ""
    worst = float(np.max(np.abs(columns.pop("residual"))))
    exchanged = max((float(np.max(np.abs(column))) for column in columns.values()), default=0.0)
    share = f", {worst / exchanged:.1e} of the {exchanged:.3g} J exchanged" if exchanged else ""
    return f"energy residual {worst:.2g} J{share}"


def _seconds(value: float) -> str:
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if value >= size:
            return f"{value / size:.4g} {unit}"
    return "0 s" if value == 0 else f"{value * 1e9:.3g} ns"
