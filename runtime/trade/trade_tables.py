"""Tables of a trade: for the terminal, as records, as CSV."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from bgc.language.column_names import name_in_si
from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.runtime.measuring.judging import Quantity
from bgc.runtime.results.files import write_rows
from bgc.runtime.trade.configurations import Variant
from bgc.runtime.trade.judge import spelled, times_real_time
from bgc.runtime.trade.measurement import FAILED, OUT_OF_BUDGET, REFUSED, Measurement
from bgc.runtime.trade.trade_result import TradeResult

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
        **{name: int(row.counts[name]) if name in row.counts else None for name in _COUNTS},
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


def write_csv(trade: TradeResult, path: str | Path) -> None:
    """Write the records; times in s, errors in SI units, empty cells if not measured."""
    rows = records(trade)
    write_rows(path, tuple(rows[0]), (tuple(row.values()) for row in rows))


# --- for people -------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Column:
    """A column for people: its heading, its cells, and the numbers by which a page sorts them."""

    heading: str
    text: Callable[[Measurement], str]
    worth: Callable[[Measurement], float] | None = None


def columns(trade: TradeResult) -> tuple[Column, ...]:
    """Return the columns of completed configurations; `*` is on the front, `=>` is recommended."""
    target = trade.target
    varied = any(row.configuration.changes for row in trade.measurements)
    variant = Column("variant", lambda row: letter(trade, row.configuration.changes))
    counts = {"steps": "steps", "f": "rhs", "J": "jacobians", "LU": "factorisations"}
    return (
        Column("", lambda row: _mark(trade, row)),
        Column("method", lambda row: row.configuration.solver),
        Column("setting", lambda row: row.configuration.setting + _dagger(trade, row)),
        *((variant,) if varied else ()),
        Column(
            "error/required" if target.required else "error/range",
            lambda row: f"{'<' * target.at_reference(row)}{target.error(row):.1e}",
            target.error,
        ),
        Column("cpu/s", lambda row: spelled(row.cpu), lambda row: row.cpu),
        Column("x real time", times_real_time, lambda row: row.real_time_factor),
        Column("a step", lambda row: spelled(row.mean_step), lambda row: row.mean_step),
        Column(
            "worst sample" if _sampled(trade) else "worst step",
            lambda row: spelled(row.worst) + _remark(trade, row),
            lambda row: row.worst,
        ),
        Column("residual", lambda row: "" if row.residual is None else f"{row.residual:.0e}"),
        *(_counts(heading, name) for heading, name in counts.items()),
    )


def _counts(heading: str, name: str) -> Column:
    return Column(
        heading,
        lambda row: f"{row.counts.get(name, 0):,.0f}",
        lambda row: row.counts.get(name, 0.0),
    )


def _mark(trade: TradeResult, row: Measurement) -> str:
    if row.configuration == trade.recommended:
        return "=>"
    return "*" if row.configuration in trade.verdict.front else ""


def _dagger(trade: TradeResult, row: Measurement) -> str:
    return "" if trade.target.samples(row) else " †"


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
    every = columns(trade)
    rows = tuple(tuple(column.text(row) for column in every) for row in shown)
    header = tuple(column.heading for column in every)
    variants = variant_rows(trade)
    return [
        Table(title, (), reference_lines(trade)),
        Table("configurations, cheapest first", header, rows, "\n".join(notes), _SPARE),
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
    lines = [
        f"reference: {one} and {other} at rtol {reference.rtol:g} {agree} "
        f"{reference.accuracy:.1e} of {trade.target.scale}"
    ]
    instants = reference.instants
    count, rows = len(instants.times), len(instants.rows)
    lines.append(f"compared at {count:,} instants, {rows:,} of them rows")
    shown = [q for q in trade.quantities if q.decides]
    lines += [f"error in: {', '.join(map(_scaled, shown))}"]
    if trade.target.deadline is not None:
        what = "of the device" if _sampled(trade) else "of a step"
        lines.append(f"deadline {what}: {spelled(trade.target.deadline)}")
    if trade.target.faster_than:
        lines.append(f"at least {trade.target.faster_than:g} x real time")
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
