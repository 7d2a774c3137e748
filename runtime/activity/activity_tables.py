"""The report on activities as tables and JSON."""

from __future__ import annotations

import json
from typing import Any

from bgc.emission.operation_cost import Cost
from bgc.printing.text_tables import Table
from bgc.runtime.activity.activity import ActivityReport, Trial
from bgc.runtime.activity.powers import by_part
from bgc.runtime.running.quantity import spelled_time

_SHOWN = 0.9999  # of all activity: parts beyond it are summed up in a note


def tables(report: ActivityReport, elements: bool) -> list[Table]:
    """Tabulate shares of parts or elements, trials of changes, and lines to add to the scene."""
    return [_shares(report, elements), _trials(report), _advice(report)]


def _shares(report: ActivityReport, elements: bool) -> Table:
    if elements:
        sums = {f"{a.element} ({a.kind})": a.activity for a in report.activities}
    else:
        sums = by_part(report.activities)
    rows: list[tuple[str, ...]] = []
    reached = 0.0
    left = 0
    for name, activity in sums.items():
        if not elements and report.total > 0 and reached / report.total > _SHOWN:
            left += 1
            continue
        reached += activity
        rows.append((name, f"{activity:.4g} J", _share(activity, report), _share(reached, report)))
    length = spelled_time(report.duration)
    notes = [f"activity: the integral of |power| over {length}, of C, I and R"]
    if left:
        notes.insert(0, f"and {left} more, together {_share(report.total - reached, report)}")
    if not rows:
        notes = ["there is no C, I or R with a power to integrate"]
    if report.spread > 0.01:
        notes.append(f"rows too coarse for fast modes: the sum is uncertain by {report.spread:.0%}")
    title = f"{report.scene}: {length}, {report.method}"
    first = "element" if elements else "part"
    return Table(title, (first, "activity", "share", "up to here"), tuple(rows), "\n".join(notes))


def _share(activity: float, report: ActivityReport) -> str:
    share = activity / report.total if report.total > 0 else 0.0
    return f"{share:.2%}" if share >= 1e-4 or share == 0 else f"{share:.0e}"


def _trials(report: ActivityReport) -> Table:
    header = ("change", "share", "states", "f", "J", "LU", "time", "error", "")
    first = ("unchanged", "", *_sizes(report.cost), "1", "", "")
    rows = [first, *(_row(trial, report) for trial in report.trials)]
    scale = "the limit of `require`" if report.required else "the range"
    notes = [f"errors are relative to {scale}, against the unchanged scene; both were run"]
    if report.left:
        notes.append(f"{report.left} more were not tried: raise --budget")
    return Table(
        "changes to parts with little activity",
        header,
        tuple(rows) if report.trials else (),
        "\n".join(notes) if report.trials else "no part with little activity can be changed",
        spare=("LU", "J", "f"),
    )


def _row(trial: Trial, report: ActivityReport) -> tuple[str, ...]:
    (change,) = trial.changes
    name = change.statement.rstrip(";")
    share = _share(trial.activity, report)
    if trial.error is None or trial.cost is None or trial.time is None:
        return (name, share, "", "", "", "", "", "", trial.refused)
    verdict = "acceptable" if report.is_acceptable(trial) else f"error too large in {trial.worst}"
    return (
        name,
        share,
        *_sizes(trial.cost),
        f"{trial.time:.2f}",
        f"{trial.error:.1e}",
        verdict,
    )


def _sizes(cost: Cost) -> tuple[str, str, str, str]:
    numbers = (cost.states, cost.rhs, cost.jacobian, cost.factorisation)
    states, rhs, jacobian, factors = (f"{number:,}" for number in numbers)
    return states, rhs, jacobian, factors


def _advice(report: ActivityReport) -> Table:
    together = report.together
    if together is None or together.error is None or together.time is None:
        return Table("", (), ())
    assert together.cost is not None
    lines = tuple((change.statement,) for change in together.changes)
    saved = report.cost.states - together.cost.states
    note = (
        f"together: {saved} states less, {together.time:.2f} of the time, "
        f"error {together.error:.1e} in {together.worst}; run and compared"
    )
    return Table("lines for the scene", (), lines, note)


def as_json(report: ActivityReport) -> str:
    """Write the whole report as JSON, SI."""
    value: dict[str, Any] = {
        "scene": report.scene,
        "method": report.method,
        "duration": report.duration,
        "spread": report.spread,
        "elements": [
            {"element": a.element, "kind": a.kind, "activity": a.activity}
            for a in report.activities
        ],
        "limit": report.limit,
        "trials": [_trial(trial) for trial in report.trials],
        "together": None if report.together is None else _trial(report.together),
        "left": report.left,
    }
    return json.dumps(value, indent=2)


def _trial(trial: Trial) -> dict[str, Any]:
    return {
        "changes": [change.statement for change in trial.changes],
        "error": trial.error,
        "worst": trial.worst,
        "time": trial.time,
        "states": None if trial.cost is None else trial.cost.states,
        "refused": trial.refused,
    }
