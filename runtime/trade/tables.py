"""Tables of a trade: for the terminal, as records, as CSV."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bgc.language.columns import name_in_si
from bgc.printing.tables import Table
from bgc.runtime.measuring.errors import Quantity
from bgc.runtime.results.files import write_rows
from bgc.runtime.trade.configurations import Variant
from bgc.runtime.trade.judge import spelled, times_real_time
from bgc.runtime.trade.measurement import FAILED, OUT_OF_BUDGET, REFUSED, Measurement
from bgc.runtime.trade.result import TradeResult

_COUNTS = (
    "steps",
    "rejected",
    "rhs",
    "jacobians",
    "factorisations",
    "solves",
    "fallbacks",
    "events",
)
_SPARE = ("LU", "J", "f", "steps", "residual", "a step")  # left out on a narrow terminal
_MOST_ROWS = 24  # on a terminal; all with `--all`, in the CSV and on the page


def records(trade: TradeResult) -> list[dict[str, Any]]:
    """Make a record for each configuration, cheapest first, unfinished ones last."""
    return [_record(trade, row) for row in ordered(trade)]


def ordered(trade: TradeResult) -> list[Measurement]:
    """Order the measurements, cheapest first, unfinished ones last."""
    return sorted(trade.measurements, key=lambda r: (not r.done, r.status == "skipped", r.cpu))


def _record(trade: TradeResult, row: Measurement) -> dict[str, Any]:
    configuration, done = row.configuration, row.done
    target, verdict = trade.target, trade.verdict
    errors = row.errors if done else (None,) * len(trade.quantities)
    record: dict[str, Any] = {
        "solver": configuration.solver,
        "rtol": configuration.rtol or None,
        "step": configuration.step or None,
        "keep": configuration.keep,
        "variant": configuration.variant,
        "status": row.status,
        "error": target.error(row) if done else None,
        "at_reference_accuracy": target.at_reference(row) if done else None,
        "cpu_per_second": row.cpu if done else None,
        "real_time_factor": row.real_time_factor if done else None,
        "mean_step": row.mean_step if done else None,
        "worst_step": row.worst_step if done else None,
        "worst_sample": row.worst_sample or None,
        "paced": row.paced or None,
        "slowest": row.slowest[0] if row.slowest else None,
        "periods": row.periods or None,
        "energy_residual": row.residual if done else None,
        "repeats": row.repeats,
        **{name: _whole(row.counts.get(name)) for name in _COUNTS},
        "accurate": target.accurate(row),
        "timely": target.timely(row) if row.certain else None,
        "samples": target.samples(row),
        "front": configuration in verdict.front,
        "recommended": configuration == trade.recommended,
    }
    for quantity, error in zip(trade.quantities, errors, strict=True):
        record[f"error of {quantity.name}"] = error
    record["message"] = row.message
    return record


def _whole(count: float | None) -> int | None:
    return None if count is None else int(count)


def write_csv(trade: TradeResult, path: str | Path) -> None:
    """Write the records; times in s, errors in SI units, empty cells if not measured."""
    rows = records(trade)
    write_rows(path, tuple(rows[0]), (tuple(row.values()) for row in rows))


# --- for people -------------------------------------------------------------------------------


def header(trade: TradeResult) -> tuple[str, ...]:
    """Return the headings of the columns for people."""
    worst = "worst sample" if _sampled(trade) else "worst step"
    error = "error/required" if trade.target.required else "error/range"
    return (
        "",
        "method",
        "setting",
        *(("variant",) if _varied(trade) else ()),
        error,
        "cpu/s",
        "x real time",
        "a step",
        worst,
        "residual",
        "steps",
        "f",
        "J",
        "LU",
    )


def cells(trade: TradeResult, row: Measurement) -> tuple[str, ...]:
    """Return the cells of one configuration; `*` is on the front, `=>` is recommended."""
    configuration, target = row.configuration, trade.target
    mark = "*" if configuration in trade.verdict.front else ""
    mark = "=>" if configuration == trade.recommended else mark
    fewer = "" if target.samples(row) else " †"
    name: tuple[str, ...] = (mark, configuration.solver, configuration.setting + fewer)
    name += (letter(trade, configuration.changes),) if _varied(trade) else ()
    if not row.done:
        return (*name, row.status, *("",) * (len(header(trade)) - len(name) - 1))
    error = f"{target.error(row):.1e}"
    counts = (row.counts.get(n, 0) for n in ("steps", "rhs", "jacobians", "factorisations"))
    return (
        *name,
        f"<{error}" if target.at_reference(row) else error,
        spelled(row.cpu),
        times_real_time(row),
        spelled(row.mean_step),
        spelled(row.worst) + _remark(trade, row),
        "" if row.residual is None else f"{row.residual:.0e}",
        *(f"{count:,.0f}" for count in counts),
    )


def _remark(trade: TradeResult, row: Measurement) -> str:
    """Mark a worst time that is too long (late) or uncertain (?)."""
    if trade.target.late(row):
        return " late"
    return "" if row.certain else " ?"


def tables(trade: TradeResult, everything: bool = False) -> list[Table]:
    """Make the tables for a terminal: the most relevant configurations, or all."""
    found = ordered(trade)
    done = [row for row in found if row.done]
    shown = done if everything else _most_relevant(trade, done)
    hidden = len(done) - len(shown)
    notes = list(legend(trade)) if done else []
    if hidden:
        notes.append(f"{hidden} more are slower or less accurate: `--all` shows them")
    title = f"{trade.scene} of {trade.model}: {spelled(trade.duration)}"
    rows = tuple(cells(trade, row) for row in shown)
    variants = variant_rows(trade)
    return [
        Table(title, (), reference_lines(trade)),
        Table("configurations, cheapest first", header(trade), rows, "\n".join(notes), _SPARE),
        Table(VARIANTS, VARIANT_HEADER, variants, VARIANT_NOTE if variants else ""),
        Table("not measured", (), unfinished([row for row in found if not row.done])),
    ]


def legend(trade: TradeResult) -> tuple[str, ...]:
    """Explain the marks and headings of a table."""
    lines = [
        "* on the Pareto front, => recommended, < no larger than the reference's own error",
        "cpu/s: processor time for a second of the scene; residual: of the energy exchanged",
    ]
    if any(not trade.target.samples(row) for row in trade.measurements):
        lines.append("† takes fewer samples of the devices than the scene has: not recommended")
    if any(row.mean_step > row.worst for row in trade.measurements if row.done):
        lines.append("a step: includes its share of writing rows, which the worst time does not")
    if any(row.slowest for row in trade.measurements):
        lines.append("worst: without the slowest thousandth, which the machine may have disturbed")
    if any(_remark(trade, row) == " ?" for row in trade.measurements if row.done):
        lines.append("? longest of one run, possibly disturbed by the machine")
    return tuple(lines)


def reference_lines(trade: TradeResult) -> tuple[tuple[str, ...], ...]:
    """Describe the reference, the scales of errors, the deadline and the machine."""
    reference = trade.reference
    one, other = reference.methods
    agree = "agree to" if reference.converged else "differ by"
    of = "of the requirement" if trade.target.required else "of the range"
    lines = [
        f"reference: {one} and {other} at rtol {reference.rtol:g} {agree} "
        f"{reference.accuracy:.1e} {of}"
    ]
    shown = [q for q in trade.quantities if q.decides]
    lines += [f"error in: {', '.join(map(_scaled, shown))}"]
    if trade.target.deadline is not None:
        what = "of the device" if _sampled(trade) else "of a step"
        lines.append(f"deadline {what}: {spelled(trade.target.deadline)}")
    lines.append(f"on: {trade.machine}")
    return tuple((line,) for line in lines)


VARIANTS = "variants, against the scene as it is"
VARIANT_HEADER = (
    "",
    "its error",
    "in",
    "cheapest that will do",
    "cpu/s",
    "of the scene's",
    "lines",
)
VARIANT_NOTE = "its error: that of its most accurate run, where the change dominates"


def variant_rows(trade: TradeResult) -> tuple[tuple[str, ...], ...]:
    """List each variant's error, and its cheapest acceptable configuration."""
    best = trade.verdict.recommended
    by_variant: dict[Variant, list[Measurement]] = {}
    for row in trade.measurements:
        if row.configuration.changes and row.done:
            by_variant.setdefault(row.configuration.changes, []).append(row)
    found = []
    for variant, rows in by_variant.items():
        finest = min(rows, key=trade.target.error)
        quantity, _ = trade.target.worst_quantity(finest)
        error = (f"{trade.target.error(finest):.1e}", quantity.name)
        fit = [row for row in rows if trade.target.fits(row)]
        cheapest = ("none", "", "")
        if fit:
            row = min(fit, key=lambda row: row.cpu)
            share = f"{row.cpu / best.cpu:.0%}" if best is not None else ""
            name = f"{row.configuration.solver} {row.configuration.setting}"
            cheapest = (name, spelled(row.cpu), share)
        lines = " ".join(change.statement for change in variant)
        found.append((letter(trade, variant), *error, *cheapest, lines))
    return tuple(found)


def letter(trade: TradeResult, variant: Variant) -> str:
    """Return a short name for a variant, by the order of requests; empty for the scene."""
    if not variant:
        return ""
    variants = dict.fromkeys(row.configuration.changes for row in trade.measurements)
    rounds, place = divmod([one for one in variants if one].index(variant), 26)
    return f"{chr(ord('A') + place)}{rounds or ''}"


def _scaled(quantity: Quantity) -> str:
    of = "within" if quantity.required else "range"
    return f"{name_in_si(quantity.name)} ({of} {quantity.shown.text(quantity.scale, 3)})"


def _most_relevant(trade: TradeResult, done: Sequence[Measurement]) -> list[Measurement]:
    """Choose the front, the recommended one, and of the others those nearest in time."""
    front = trade.verdict.front
    chosen = [r for r in done if r.configuration in front or r.configuration == trade.recommended]
    others = (row for row in done if row not in chosen)
    ranked = sorted(others, key=lambda row: _excess(trade, row, chosen))
    chosen += ranked[: max(_MOST_ROWS - len(chosen), 0)]
    return [row for row in done if row in chosen]


def _excess(trade: TradeResult, row: Measurement, front: Sequence[Measurement]) -> float:
    """Compute its time over that of the cheapest configuration of the same accuracy."""
    if not trade.target.is_informative(row):
        return float("inf")
    error = max(trade.target.error(row), trade.reference.accuracy)
    better = [other.cpu for other in front if trade.target.error(other) <= error and other.cpu > 0]
    return row.cpu / min(better) if better else float("inf")


def unfinished(rows: Sequence[Measurement]) -> tuple[tuple[str, str, str, str], ...]:
    """Make lines for unfinished configurations, grouped by method and kind of reason.

    Of several reasons of one kind, which differ in their time, the first is shown.
    """
    kinds: dict[tuple[str, str, str], list[Measurement]] = {}
    for row in rows:
        kind = row.message.partition(": ")[0] if row.status == FAILED else row.message
        kinds.setdefault((_subject(row), row.status, kind), []).append(row)
    return tuple(
        (
            name or f"{len(found)} more",
            status,
            "; ".join(row.configuration.setting for row in found)
            if name and status != REFUSED
            else "",
            found[0].message,
        )
        for (name, status, _), found in kinds.items()
    )


def _subject(row: Measurement) -> str:
    """Name the method or the variant of an unfinished configuration; empty if out of budget."""
    configuration = row.configuration
    if row.message == OUT_OF_BUDGET:
        return ""
    if row.status == REFUSED and configuration.changes:
        return configuration.variant
    with_ = f" with {configuration.variant}" if configuration.changes else ""
    return f"{configuration.solver}{with_}"


def _sampled(trade: TradeResult) -> bool:
    return trade.target.sample is not None


def _varied(trade: TradeResult) -> bool:
    return any(row.configuration.changes for row in trade.measurements)
