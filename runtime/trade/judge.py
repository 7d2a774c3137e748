"""Judgement of measurements: the Pareto front, and the cheapest acceptable configuration."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import listed
from bgc.language.column_names import name_in_si, vector_of
from bgc.record_class import dataclass
from bgc.runtime.measuring.agreement import AT_THE_REFERENCE
from bgc.runtime.measuring.judging import Quantity, combined, worst_error
from bgc.runtime.results.requirements import spelled_ratio
from bgc.runtime.running.quantity import spelled_time
from bgc.runtime.trade.configurations import Configuration
from bgc.runtime.trade.measurement import OUT_OF_BUDGET, Measurement

DEFAULT_ACCURACY = 1e-3  # of the range, if a scene has no requirements
_USELESS = 1e3  # times the limit: larger errors carry no information
_BETTER = 0.95  # times an error: an error must be below it to count as smaller


@dataclass(frozen=True, slots=True)
class Target:
    """The demands on a configuration.

    With `required`, errors are relative to the required accuracies and the limit is 1; otherwise
    they are relative to the range. `required_by` names what gave these accuracies: `require` of the
    scene, `--within` of the command, or both. `deadline` is in s, None if there is none.
    `faster_than` is the least number of seconds of the scene for a second of processor time.
    `sample` is the period of the scene's devices, s, None without devices: a longer step takes
    fewer samples than the scene specifies. `floor` is the accuracy of the reference; `verified`
    says that it is well below the limit. `settle` is the scene's option of that name, Hz.
    """

    quantities: tuple[Quantity, ...]
    required: bool
    deadline: float | None = None
    faster_than: float = 0.0
    sample: float | None = None
    floor: float = 0.0
    verified: bool = True
    settle: float = 0.0
    required_by: tuple[str, ...] = ("require",)

    @property
    def limit(self) -> float:
        """The largest acceptable combined error."""
        return 1.0 if self.required else DEFAULT_ACCURACY

    @property
    def scale(self) -> str:
        """What errors are relative to."""
        return "the requirement" if self.required else "the range"

    def error(self, row: Measurement) -> float:
        """Compute the combined error of a measurement; infinite for an incomplete run."""
        return combined(row.errors, self.quantities) if row.done else float("inf")

    def at_reference(self, row: Measurement) -> bool:
        """Return whether an error may be the reference's own."""
        return row.done and self.error(row) <= AT_THE_REFERENCE * self.floor

    def accurate(self, row: Measurement) -> bool:
        """Return whether the error is acceptable."""
        return self.error(row) <= self.limit

    @property
    def speed(self) -> float:
        """The least number of seconds of the scene in a second; 1 with a deadline."""
        return max(self.faster_than, 0.0 if self.deadline is None else 1.0)

    def timely(self, row: Measurement) -> bool:
        """Return whether it is done, fast enough and keeps the deadline, if there is one."""
        fast = row.done and row.real_time_factor >= self.speed
        return fast and (self.deadline is None or row.worst <= self.deadline)

    def late(self, row: Measurement) -> bool:
        """Return whether it is too slow or misses the deadline for certain."""
        slow = row.real_time_factor < self.speed
        return row.done and not self.timely(row) and (row.certain or slow)

    def margins(self, row: Measurement) -> dict[str, float]:
        """How many times the error fits in its limit, the worst time in the deadline, and so on.

        Errors below the reference's accuracy count as that.
        """
        error = max(self.error(row), self.floor)
        found = {"error": self.limit / error if error > 0 else math.inf}
        if self.deadline is not None:
            found["time"] = self.deadline / row.worst if row.worst > 0 else math.inf
        if self.faster_than:
            found["speed"] = row.real_time_factor / self.faster_than
        return found

    def samples(self, row: Measurement) -> bool:
        """Return whether devices are sampled as often as the scene specifies."""
        return self.sample is None or row.configuration.step <= self.sample * (1 + 1e-9)

    def is_informative(self, row: Measurement) -> bool:
        """Return whether its error carries any information."""
        return self.error(row) <= _USELESS * self.limit

    def fits(self, row: Measurement) -> bool:
        """Return whether it is acceptable: accurate, in time, and with all samples."""
        return self.accurate(row) and self.timely(row) and self.samples(row)

    def worst_quantity(self, row: Measurement) -> tuple[Quantity, float]:
        """Find the quantity with the combined error; return it and its error."""
        return worst_error(row.errors, self.quantities)


@dataclass(frozen=True, slots=True)
class Verdict:
    """The recommendation, the Pareto front (cost against error), and both in a sentence."""

    recommended: Measurement | None
    front: frozenset[Configuration]
    sentence: str


def judge(rows: Sequence[Measurement], target: Target) -> Verdict:
    """Find the front, and the cheapest configuration that is accurate and in time.

    Without a verified reference nothing is recommended.
    """
    found = front(rows, target)
    if not target.verified:
        return Verdict(None, found, _UNVERIFIED)
    fit = [row for row in rows if target.fits(row)]
    best = min((r for r in fit if not r.configuration.changes), key=lambda r: r.cpu, default=None)
    sentences = [_of_best(best, target) if best is not None else _of_none(rows, target)]
    other = min((r for r in fit if r.configuration.changes), key=lambda r: r.cpu, default=None)
    if other is not None and (best is None or other.cpu < best.cpu):
        sentences.append(_of_variant(other, best, target))
    return Verdict(best, found, " ".join(sentences))


def front(rows: Iterable[Measurement], target: Target) -> frozenset[Configuration]:
    """Find the configurations that no other beats in both time and error.

    Errors at the reference's accuracy count as equal, and so do errors within 5 %. Configurations
    with uninformative errors are not on the front.
    """
    least, found = float("inf"), []
    done = (row for row in rows if target.is_informative(row))
    for row in sorted(done, key=lambda row: (row.cpu, target.error(row))):
        error = max(target.error(row), AT_THE_REFERENCE * target.floor)
        if error < _BETTER * least:
            least = error
            found.append(row.configuration)
    return frozenset(found)


# --- the sentence -----------------------------------------------------------------------------

_UNVERIFIED = (
    "Nothing is recommended: the two methods of the reference do not agree well enough to measure "
    "errors against it."
)


def _of_best(row: Measurement, target: Target) -> str:
    demands = [_limit(target), *(name.partition(" of ")[0] for name in _demands_on_time(target))]
    statement = row.configuration.statement(target.settle)
    text = f"The cheapest configuration within {' and '.join(demands)}: `{statement}`"
    details = [_error(row, target), _cost(row)]
    if target.deadline is not None:
        details.append(f"worst {_worst(row, target)} of {spelled(target.deadline)}")
        details += _lateness(row, target.deadline, target)
    margins = (f"{spelled_ratio(value)} in {name}" for name, value in target.margins(row).items())
    return f"{text} with {', '.join(details)}. Margin: {', '.join(margins)}."


def _demands_on_time(target: Target) -> list[str]:
    """Name the demands on time: the deadline, and the speed."""
    found = [] if target.deadline is None else [f"the deadline of {spelled(target.deadline)}"]
    return found + ([f"{target.faster_than:g} x real time"] if target.faster_than else [])


def _lateness(row: Measurement, deadline: float, target: Target) -> list[str]:
    """Say how many samples or steps were late, if any were: the slowest do not decide."""
    late = row.late(deadline)
    if not late:
        return []
    what = "samples" if target.sample is not None else "steps"
    return [f"{late} of {row.periods:,} {what} late (slowest {spelled(row.slowest[0])})"]


def _of_variant(row: Measurement, best: Measurement | None, target: Target) -> str:
    configuration = row.configuration
    lines = " ".join(change.statement for change in configuration.changes)
    share = "is acceptable"
    if best:
        share += f" too, in {row.cpu / best.cpu:.0%} of that time"
    return (
        f"With `{lines}`, `{configuration.statement(target.settle)}` {share}: "
        f"{_error(row, target)}, {_cost(row)}."
    )


def _of_none(rows: Sequence[Measurement], target: Target) -> str:
    """Say why no configuration is acceptable, and which come nearest in accuracy and time."""
    ours = [row for row in rows if not row.configuration.changes]
    done = [row for row in ours if row.done and target.samples(row)]
    if not done:
        if any(row.message == OUT_OF_BUDGET for row in ours):
            return "The budget was spent before anything was measured: the same command continues."
        return "No configuration completed the run."
    accurate = [row for row in done if target.accurate(row)]
    timely = [row for row in done if target.timely(row)]
    demands = [_limit(target)] if not accurate or timely else []
    if accurate or not timely:
        demands += _demands_on_time(target)
    sentences = [f"No configuration is within {' and '.join(demands)}."]
    if accurate:
        sentences.append(_of_quickest(accurate, "Of those accurate enough, the quickest", target))
        if timely:
            sentences.append(_of_finest(timely, "Of those in time, the most accurate", target))
        return " ".join(sentences)
    sentences.append(_of_finest(timely or done, "The most accurate", target))
    if not timely:
        sentences.append(_of_quickest(done, "None is in time; the quickest", target))
    sentences.append("A smaller step or tolerance may be accurate enough (`--steps`, `--rtols`).")
    return " ".join(sentences)


def _of_finest(rows: Sequence[Measurement], what: str, target: Target) -> str:
    """Name the most accurate configuration, and the `require` that it would meet."""
    row = min(rows, key=target.error)
    text = f"{what} is {row.configuration.label} with {_error(row, target)}"
    short: dict[str, tuple[float, str]] = {}
    for quantity, error in zip(target.quantities, row.errors, strict=True):
        if quantity.required and error > quantity.scale:
            name = _as_required(quantity, target)
            shown = quantity.shown
            short[name] = max(short.get(name, (0.0, "")), (shown.number(error), shown.label))
    if not short:
        return f"{text}."
    lines = (
        f"`require {name} within {_above(error)} {unit}".rstrip() + ";`"
        for name, (error, unit) in short.items()
    )
    return f"{text}: {' and '.join(lines)} would be met."


def _as_required(quantity: Quantity, target: Target) -> str:
    """Return the vector's name if all its components have the same requirement, else the name."""
    vector = vector_of(quantity.name)
    alike = [q for q in target.quantities if vector and vector_of(q.name) == vector]
    whole = alike and all(q.required and q.scale == quantity.scale for q in alike)
    return name_in_si(vector if whole else quantity.name)


def _of_quickest(rows: Sequence[Measurement], what: str, target: Target) -> str:
    """Name the configuration with the least worst time, and the deadline that it would keep."""
    row = min(rows, key=lambda row: (not row.certain, row.worst))
    text = f"{what} is {row.configuration.label}: worst {_worst(row, target)}, {_cost(row)}."
    if row.real_time_factor < target.speed:
        slow = "real time" if target.speed <= 1 else f"{target.speed:g} x real time"
        return f"{text} It is slower than {slow}."
    busy = "" if row.certain else ", unless the machine was busy with other work"
    return f"{text} A deadline of {spelled_time(float(_above(row.worst)))} would be kept{busy}."


def _above(value: float) -> str:
    """Write two digits, rounded up."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1) if value > 0 else 1.0
    return f"{math.ceil(value / unit * (1 - 1e-12)) * unit:.12g}"


def _limit(target: Target) -> str:
    of_range = f"{DEFAULT_ACCURACY:g} of the range (the scene has no `require`)"
    return listed(target.required_by) if target.required else of_range


def _error(row: Measurement, target: Target) -> str:
    quantity, error = target.worst_quantity(row)
    name = f"`{name_in_si(quantity.name)}` off by {quantity.shown.text(error, 2)}"
    if target.at_reference(row):
        name += ", which is the reference's own accuracy"
    return f"{name} of {quantity.shown.number(quantity.scale):.3g}" if quantity.required else name


def _cost(row: Measurement) -> str:
    factor = times_real_time(row)
    return f"{spelled(row.cpu)} of processor time a second ({factor} x real time)"


def _worst(row: Measurement, target: Target) -> str:
    return f"{spelled(row.worst)} {'a sample' if target.sample is not None else 'a step'}"


def times_real_time(row: Measurement) -> str:
    """Write how many times faster than real time it runs, with three digits."""
    return f"{float(f'{row.real_time_factor:.3g}'):,.15g}"


def spelled(seconds: float) -> str:
    """Write a measured time with three digits."""
    return spelled_time(float(f"{seconds:.3g}"))
