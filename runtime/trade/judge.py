"""What the measurements say: the Pareto front, and the cheapest configuration that will do."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from bgc.runtime.measuring.errors import Quantity, combined, vector_of, worst_of
from bgc.runtime.running.quantity import spelled_time
from bgc.runtime.trade.configurations import Configuration
from bgc.runtime.trade.measurement import OUT_OF_BUDGET, Measurement

DEFAULT_ACCURACY = 1e-3  # of the range, where a scene requires nothing
_AT_THE_REFERENCE = 3.0  # times its accuracy: errors below it are not told from its own
_USELESS = 1e3  # times the limit, or all of the range: nothing is known by that
_BETTER = 0.95  # times an error: what is not below it is no gain


@dataclass(frozen=True, slots=True)
class Target:
    """What is asked of a configuration.

    `required` says whether errors are in terms of `require`, and 1 is the limit; else they are
    parts of the range. `deadline` is in s, None where there is none. `sample` is the period of the
    scene's devices, s, None without devices: a longer step would take fewer samples than the scene
    says. `floor` is the error below which the reference tells nothing, and `verified` whether that
    is well below what is asked for. `settle` is the scene's option of that name, 1/s.
    """

    quantities: tuple[Quantity, ...]
    required: bool
    deadline: float | None = None
    sample: float | None = None
    floor: float = 0.0
    verified: bool = True
    settle: float = 0.0

    @property
    def limit(self) -> float:
        """The largest combined error that will do."""
        return 1.0 if self.required else DEFAULT_ACCURACY

    def error(self, row: Measurement) -> float:
        """The combined error of a measurement; infinite where it has none."""
        return combined(row.errors, self.quantities) if row.done else float("inf")

    def at_reference(self, row: Measurement) -> bool:
        """Whether an error is no larger than the reference's own might be."""
        return row.done and self.error(row) <= _AT_THE_REFERENCE * self.floor

    def accurate(self, row: Measurement) -> bool:
        """Whether the error will do."""
        return self.error(row) <= self.limit

    def timely(self, row: Measurement) -> bool:
        """Whether it keeps the deadline, and up with time; with no deadline all that is done."""
        if not row.done or self.deadline is None:
            return row.done
        return row.worst <= self.deadline and row.cpu <= 1.0

    def late(self, row: Measurement) -> bool:
        """Whether it certainly misses the deadline."""
        return row.done and not self.timely(row) and (row.certain or row.cpu > 1.0)

    def samples(self, row: Measurement) -> bool:
        """Whether devices are sampled as often as the scene says."""
        return self.sample is None or row.configuration.step <= self.sample * (1 + 1e-9)

    def tells(self, row: Measurement) -> bool:
        """Whether something is known by it, however little."""
        return self.error(row) <= _USELESS * self.limit

    def fits(self, row: Measurement) -> bool:
        """Whether it will do: accurate, in time, and with all samples."""
        return self.accurate(row) and self.timely(row) and self.samples(row)

    def worst_quantity(self, row: Measurement) -> tuple[Quantity, float]:
        """The quantity that decides, with its error."""
        return worst_of(row.errors, self.quantities)


@dataclass(frozen=True, slots=True)
class Verdict:
    """`front`: no other is both cheaper and more accurate. `sentence`: what there is to say."""

    recommended: Measurement | None
    front: frozenset[Configuration]
    sentence: str


def judge(rows: Sequence[Measurement], target: Target) -> Verdict:
    """Find the front, and the cheapest configuration that is accurate and timely.

    Nothing is recommended on a reference that is not verified.
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
    """The configurations that no other beats in both time and error.

    Errors at the reference's accuracy count as equal, and so do those that differ by a hair. What
    is beyond all use is not on it.
    """
    least, found = float("inf"), []
    done = (row for row in rows if target.tells(row))
    for row in sorted(done, key=lambda row: (row.cpu, target.error(row))):
        error = max(target.error(row), _AT_THE_REFERENCE * target.floor)
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
    asked = [_limit(target), *(["the deadline"] if target.deadline is not None else [])]
    statement = row.configuration.statement(target.settle)
    text = f"The cheapest configuration within {' and '.join(asked)}: `{statement}`"
    details = [_error(row, target), _cost(row)]
    if target.deadline is not None:
        details.append(f"worst {_worst(row, target)} of {spelled(target.deadline)}")
    return f"{text} with {', '.join(details)}."


def _of_variant(row: Measurement, best: Measurement | None, target: Target) -> str:
    configuration = row.configuration
    lines = " ".join(change.statement for change in configuration.changes)
    share = f"would do too, in {row.cpu / best.cpu:.0%} of that time" if best else "would do"
    return (
        f"With `{lines}`, `{configuration.statement(target.settle)}` {share}: "
        f"{_error(row, target)}, {_cost(row)}."
    )


def _of_none(rows: Sequence[Measurement], target: Target) -> str:
    """Why no configuration will do, and what would: the nearest on each side."""
    ours = [row for row in rows if not row.configuration.changes]
    done = [row for row in ours if row.done and target.samples(row)]
    if not done:
        if any(row.message == OUT_OF_BUDGET for row in ours):
            return "The budget was spent before anything was measured: the same command goes on."
        return "No configuration completed the run."
    accurate = [row for row in done if target.accurate(row)]
    timely = [row for row in done if target.timely(row)]
    asked = [_limit(target)] if not accurate or timely else []
    if target.deadline is not None and (accurate or not timely):
        asked.append(f"the deadline of {spelled(target.deadline)}")
    sentences = [f"No configuration is within {' and '.join(asked)}."]
    if accurate:
        sentences.append(_of_quickest(accurate, "Of those accurate enough, the quickest", target))
        if timely:
            sentences.append(_of_finest(timely, "Of those in time, the most accurate", target))
        return " ".join(sentences)
    sentences.append(_of_finest(timely or done, "The most accurate", target))
    if target.deadline is not None and not timely:
        sentences.append(_of_quickest(done, "None is in time; the quickest", target))
    sentences.append("A smaller step or tolerance may be accurate enough (`--steps`, `--rtols`).")
    return " ".join(sentences)


def _of_finest(rows: Sequence[Measurement], what: str, target: Target) -> str:
    """The most accurate, and the `require` that it would meet."""
    row = min(rows, key=target.error)
    text = f"{what} is {row.configuration.label} with {_error(row, target)}"
    short: dict[str, tuple[float, str]] = {}
    for quantity, error in zip(target.quantities, row.errors, strict=True):
        if quantity.required and error > quantity.scale:
            name = _as_required(quantity, target)
            short[name] = max(short.get(name, (0.0, "")), (error, quantity.unit))
    if not short:
        return f"{text}."
    lines = (
        f"`require {name} within {_above(error)} {unit}".rstrip() + ";`"
        for name, (error, unit) in short.items()
    )
    return f"{text}: {' and '.join(lines)} would be met."


def _as_required(quantity: Quantity, target: Target) -> str:
    """The name that a scene gives it: the vector's where all components are required alike."""
    vector = vector_of(quantity.name)
    alike = [q for q in target.quantities if vector and vector_of(q.name) == vector]
    whole = alike and all(q.required and q.scale == quantity.scale for q in alike)
    return vector if whole else quantity.name


def _of_quickest(rows: Sequence[Measurement], what: str, target: Target) -> str:
    """The one with the least worst time, and the deadline that it would keep."""
    row = min(rows, key=lambda row: (not row.certain, row.worst))
    text = f"{what} is {row.configuration.label}: worst {_worst(row, target)}, {_cost(row)}."
    if row.cpu > 1.0:
        return f"{text} It does not keep up with the time of the scene."
    busy = "" if row.certain else ", if it was not the machine that was busy with something else"
    return f"{text} A deadline of {spelled_time(float(_above(row.worst)))} would be kept{busy}."


def _above(value: float) -> str:
    """Two digits, rounded up."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1) if value > 0 else 1.0
    return f"{math.ceil(value / unit * (1 - 1e-12)) * unit:.12g}"


def _limit(target: Target) -> str:
    of_range = f"{DEFAULT_ACCURACY:g} of the range (the scene has no `require`)"
    return "`require`" if target.required else of_range


def _error(row: Measurement, target: Target) -> str:
    quantity, error = target.worst_quantity(row)
    name = f"`{quantity.name}` off by {error:.2g} {quantity.unit}".rstrip()
    if target.at_reference(row):
        name += ", which is the reference's own accuracy"
    return f"{name} of {quantity.scale:.3g}" if quantity.required else name


def _cost(row: Measurement) -> str:
    factor = times_real_time(row)
    return f"{spelled(row.cpu)} of processor time a second ({factor} x real time)"


def _worst(row: Measurement, target: Target) -> str:
    return f"{spelled(row.worst)} {'a sample' if target.sample is not None else 'a step'}"


def times_real_time(row: Measurement) -> str:
    """How many times faster than time itself it runs, three digits."""
    return f"{float(f'{row.real_time_factor:.3g}'):,.15g}"


def spelled(seconds: float) -> str:
    """A measured time, three digits."""
    return spelled_time(float(f"{seconds:.3g}"))
