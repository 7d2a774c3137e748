"""Tables, CSV and JSON of a stress map."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from bgc.printing.text_tables import Table
from bgc.runtime.results.files import write_rows
from bgc.runtime.running.quantity import spelled_time
from bgc.runtime.stress.drives import STEP, Drive, is_extreme
from bgc.runtime.stress.stress import Point, StressMap
from bgc.runtime.stress.stress_judge import Judgement, Verdict
from bgc.values.shown_units import Shown

_NAMED = 6  # drives at most that a sentence names


def tables(found: StressMap) -> list[Table]:
    """Make a row for each stretch of a drive with one verdict, then a summary."""
    header = ("driven", "as", "from", "to", "verdict", "worst error", "")
    rows: list[tuple[str, ...]] = []
    if found.grid:
        header = ("driven", "values", "", "", "verdict", "worst error", "")
        rows = [_grid_row(point, found.drives) for point in found.points]
    for drive in () if found.grid else found.drives:
        rows += _stretches(drive, found.of_drive(drive))
    return [Table(_title(found), header, tuple(rows)), Table("in all", (), (), summary(found))]


def _title(found: StressMap) -> str:
    length = spelled_time(float(f"{found.duration:.3g}"))
    whole = spelled_time(found.scene_duration)
    part = length if found.duration == found.scene_duration else f"{length} of {whole}"
    return f"{found.scene}, {found.method}, {part}"


def _stretches(drive: Drive, points: Sequence[Point]) -> Iterator[tuple[str, ...]]:
    """Group the points of a drive, by value, into stretches with one verdict."""
    ordered = sorted(points, key=lambda point: point.settings[0][1])
    name, role = drive.name, drive.role
    for (verdict, _), group in groupby(ordered, key=_alike):
        run = list(group)
        first, last = (drive.shown.text(p.settings[0][1]) for p in (run[0], run[-1]))
        yield (
            name,
            role,
            first,
            last if len(run) > 1 else "",
            verdict.value,
            _worst(point.judgement for point in run),
            run[0].judgement.message or _shortened(run),
        )
        name = role = ""


def _shortened(points: Sequence[Point]) -> str:
    """Describe the durations of points that were shortened for short steps."""
    ends = sorted({point.duration for point in points})
    if points[0].settings[0][0] != STEP or len(ends) == 1:
        return ""
    return f"over {spelled_time(ends[0])} to {spelled_time(ends[-1])}"


def _alike(point: Point) -> tuple[Verdict, str]:
    """The verdict, and what tells failures from each other, or unstable from inaccurate runs."""
    judgement = point.judgement
    told = judgement.verdict in (Verdict.FAILS, Verdict.WARNED, Verdict.WRONG)
    return judgement.verdict, judgement.message[:5] if told else ""


def _grid_row(point: Point, drives: Sequence[Drive]) -> tuple[str, ...]:
    (across, x), (up, y) = point.settings
    shown = {drive.name: drive.shown for drive in drives}
    judgement = point.judgement
    return (
        f"{across}, {up}",
        f"{shown[across].text(x, 4)}, {shown[up].text(y, 4)}",
        "",
        "",
        judgement.verdict.value,
        _worst([judgement]),
        judgement.message,
    )


def _worst(judgements: Iterable[Judgement]) -> str:
    errors = [j.error for j in judgements if j.error is not None]
    return f"{max(errors):.1e}" if errors else ""


def summary(found: StressMap) -> str:
    """Summarise verdicts, the trusted ranges of the drives, and the points that were left out."""
    counts = found.counts()
    parts = [f"{counts[v]} {v.value}" for v in Verdict if counts.get(v)]
    allowed = "what `require` allows" if found.tolerance.required else f"{found.tolerance.within:g}"
    lines = [
        f"{len(found.points)} points: {', '.join(parts)}",
        f"holds: another method at a tight tolerance agrees within {allowed}; errors are "
        "relative to the range of each observed quantity, or to a hundredth of its size",
    ]
    if not found.grid:
        lines.append(_trusted(found))
    if missing := found.planned - len(found.points):
        names = [drive.name for drive in found.skipped]
        among = f", among them all of {_some(names)}" if names else ""
        longest = f'; the longest takes --budget "{found.needed:.0f} s"' if found.needed > 1 else ""
        lines.append(
            f"{missing} of {found.planned} points did not fit in the budget{among}: run it again "
            f"to continue{longest}"
        )
    if found.wrong:
        lines.append("WRONG NUMBERS WITHOUT A WARNING: take a smaller step or tolerance there")
    return "\n".join(lines)


def _trusted(found: StressMap) -> str:
    """Say for which values the scene holds, and where numbers are wrong without a warning."""
    whole, parts, nowhere, elsewhere = [], [], [], []
    for drive in found.drives:
        points = found.of_drive(drive)
        stretch = _stretch_of_use(drive, points)
        count = sum(point.judgement.verdict is Verdict.HOLDS for point in points)
        if count == len(points):
            whole.append(drive.name)
        elif stretch:
            parts.append(f"{drive.name} {_span(stretch, drive.shown)}")
        elif count and any(point.settings[0][1] == drive.own for point in points):
            elsewhere.append(f"{drive.name} ({count} of {len(points)} values hold)")
        elif count:
            parts.append(f"extreme values of {drive.name} alone")
        else:
            nowhere.append(drive.name)
    holds = [*parts, *([f"all tried values of {_some(whole)}"] if whole else [])]
    said = f"the scene holds for {', '.join(holds)}" if holds else "the scene holds nowhere"
    if elsewhere:
        does_not = f"the scene does not hold at its own value of {_some(elsewhere)}"
        said = f"{said}; {does_not}" if holds else does_not
    if nowhere and (holds or elsewhere):
        said += f", and nowhere for {_some(nowhere)}"
    wrong = dict.fromkeys(point.settings[0][0] for point in found.wrong)
    silent = f"for {_some([*wrong])} some are" if wrong else "no number is"
    return f"{said}; {silent} wrong without a warning"


def _span(values: Sequence[float], shown: Shown) -> str:
    low, high = shown.text(values[0]), shown.text(values[-1])
    return f"{low} to {high}" if low != high else low


def _some(names: Sequence[str]) -> str:
    """List the first few names."""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more


def _stretch_of_use(drive: Drive, points: Sequence[Point]) -> list[float]:
    """Find the values of the stretch that holds around the scene's own value.

    Where that is not among the values, the longest stretch counts. Extremes at which numbers
    overflow are left out.
    """
    found: list[float] = []
    ordered = sorted(points, key=lambda point: point.settings[0][1])
    tried = any(point.settings[0][1] == drive.own for point in points)
    for holds, group in groupby(ordered, key=lambda p: p.judgement.verdict is Verdict.HOLDS):
        values = [point.settings[0][1] for point in group]
        used = [value for value in values if drive.role == "" or not is_extreme(value)]
        if holds and ((drive.own in values) if tried else len(used) > len(found)):
            found = used
    return found


def write_csv(found: StressMap, path: str | Path) -> None:
    """Write a line for each point: its settings, SI, and its judgement."""
    width = 2 if found.grid else 1
    names = [f"{word}{k + 1 if found.grid else ''}" for k in range(width)
             for word in ("driven", "value")]  # fmt: skip
    header = (*names, "seconds", "verdict", "error", "residual", "message")
    write_rows(path, header, map(_line, found.points))


def _line(point: Point) -> tuple[object, ...]:
    judgement = point.judgement
    numbers = judgement.error, judgement.residual
    settings = (item for pair in point.settings for item in pair)
    return *settings, point.duration, judgement.verdict.value, *numbers, judgement.message


def as_json(found: StressMap) -> str:
    """Write the whole map as JSON; an infinite error is written as a text."""
    counts = found.counts()
    value: dict[str, Any] = {
        "scene": found.scene,
        "method": found.method,
        "duration": found.duration,
        "scene_duration": found.scene_duration,
        "within": None if found.tolerance.required else found.tolerance.within,
        "counts": {verdict.value: counts.get(verdict, 0) for verdict in Verdict},
        "points": [
            {
                "settings": dict(point.settings),
                "duration": point.duration,
                "verdict": point.judgement.verdict.value,
                "error": _number(point.judgement.error),
                "residual": _number(point.judgement.residual),
                "message": point.judgement.message,
            }
            for point in found.points
        ],
        "planned": found.planned,
        "skipped": [drive.name for drive in found.skipped],
    }
    return json.dumps(value, indent=2, allow_nan=False)


def _number(value: float | None) -> float | str | None:
    return "infinite" if value == float("inf") else value
