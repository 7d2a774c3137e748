"""Tables of a reduction: for the terminal, as records, as CSV and JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from bgc.diagnostics.catalogue import counted
from bgc.printing.text_tables import Table
from bgc.runtime.reduce.reduced_scene import statements
from bgc.runtime.reduce.reduction import ReductionResult, Timed, gained
from bgc.runtime.reduce.trial import Trial
from bgc.runtime.reduce.validity import Side, Validity
from bgc.runtime.results.files import write_rows
from bgc.runtime.trade.judge import spelled
from bgc.runtime.trade.measurement import DONE


def records(found: ReductionResult) -> list[dict[str, Any]]:
    """Make a record for each trial, the whole scene first; errors are over the requirement."""
    return [_record(found, trial) for trial in found.tried]


def _record(found: ReductionResult, trial: Trial) -> dict[str, Any]:
    done = trial.status == DONE
    return {
        "changes": statements(trial.changes),
        "status": trial.status,
        "states": trial.states if done else None,
        "operations": trial.work if done else None,
        "error": trial.error if done else None,
        "worst": trial.worst,
        "accurate": trial.accurate,
        "chosen": trial.changes == found.best.changes,
        "message": trial.message,
    }


def write_csv(found: ReductionResult, path: str | Path) -> None:
    """Write the records; empty cells where a trial was not completed."""
    rows = records(found)
    write_rows(path, tuple(rows[0]), (tuple(row.values()) for row in rows))


def as_json(found: ReductionResult) -> str:
    """Write the result as JSON."""
    proof = found.proof
    value = {
        "scene": found.scene,
        "states": found.best.states,
        "of_states": found.whole.states,
        "changes": [change.statement for change in found.best.changes],
        "error": None if proof is None else proof.error,
        "method": None if proof is None else proof.method,
        "seconds": None
        if proof is None
        else {
            name: None if row is None else row.seconds
            for name, row in (
                ("reduced", proof.reduced),
                ("own", proof.own),
                ("whole", proof.whole),
            )
        },
        "valid": [_valid_record(each) for each in found.valid],
        "tried": records(found),
        "sentence": found.sentence,
    }
    return json.dumps(value, indent=2)


def tables(found: ReductionResult) -> list[Table]:
    """Make the tables: all that was tried, what was accepted, the times and the limits."""
    return [_tried(found), _accepted(found), _timed(found), _limits(found)]


def _tried(found: ReductionResult) -> Table:
    one, other = found.reference.methods
    scale = max(found.whole.work, 1.0)
    rows = tuple(_row(found, trial, scale) for trial in found.tried)
    notes = [
        "error: over the requirement, with the doubt about the reference; operations: of a run",
        f"reference: {one} and {other} at rtol {found.reference.rtol:g} agree to "
        f"{found.reference.accuracy:.0e} of the requirement",
    ]
    if len(found.cases) > 1:
        notes.append(f"the largest error of {len(found.cases)} cases, or of the first beyond it")
    title = f"{found.scene} of {found.model}: {spelled(found.duration)}"
    header = ("", "states", "operations", "error", "in", "changes")
    return Table(title, header, rows, "\n".join(notes))


def _row(found: ReductionResult, trial: Trial, scale: float) -> tuple[str, ...]:
    mark = "=>" if trial.changes == found.best.changes else ""
    lines = statements(trial.changes) or "the whole scene"
    if trial.status != DONE:
        return (mark, "", "", trial.status, "", f"{lines}  {trial.message}")
    error = f"{trial.error:.1e}{'' if trial.accurate else ' too large'}"
    return (mark, str(trial.states), f"{trial.work / scale:.3f}", error, trial.worst, lines)


def _accepted(found: ReductionResult) -> Table:
    header = ("change", "states", "operations", "costs", "error")
    rows = tuple(gained(stage) for stage in found.stages)
    note = "operations: of those before; costs: the error that it adds"
    return Table("accepted, one after the other", header, rows, note if rows else "")


def _limits(found: ReductionResult) -> Table:
    """The parameters by which the reduced scene stops being valid, and the number of others."""
    rows = tuple(
        (
            each.name,
            each.shown.text(each.own),
            _reach(each, side),
            each.shown.text(side.fails),
            f"{side.error:.1e}",
        )
        for each in found.valid
        for side in (each.below, each.above)
        if side.fails is not None
    )
    if not found.valid:
        return Table("", (), ())
    held = sum(each.below.fails is None and each.above.fails is None for each in found.valid)
    note = (
        f"{counted(held, 'other parameter')} driven to a tenth and to ten times, within the "
        "declared range: it holds"
    )
    header = ("parameter", "in the scene", "holds up to", "not at", "error")
    return Table("where the reduced scene stops being valid", header, rows, note)


def _reach(each: Validity, side: Side) -> str:
    return "" if side.holds is None else each.shown.text(side.holds)


def _valid_record(each: Validity) -> dict[str, Any]:
    sides = {"below": each.below, "above": each.above}
    return {
        "parameter": each.name,
        "value": each.own,
        **{
            name: {"holds": side.holds, "fails": side.fails, "error": side.error}
            for name, side in sides.items()
        },
    }


def _timed(found: ReductionResult) -> Table:
    if found.proof is None:
        return Table("", (), ())
    proof = found.proof
    named = (
        ("reduced", proof.reduced),
        ("whole, its own method", proof.own),
        ("whole, cheapest found", proof.whole),
    )
    rows = tuple(_time_row(name, row, proof.reduced) for name, row in named if row is not None)
    header = ("", "method", "run", "of the reduced", "error")
    return Table("times, measured in turns", header, rows, f"on: {found.machine}")


def _time_row(name: str, row: Timed, reduced: Timed) -> tuple[str, ...]:
    ratio = f"{row.seconds / reduced.seconds:.2f}" if reduced.seconds > 0 else ""
    return (name, row.label, spelled(row.seconds), ratio, f"{row.error:.1e}")
