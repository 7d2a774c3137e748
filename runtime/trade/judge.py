"""What the measurements say: the Pareto front, and the cheapest configuration that will do."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from bgc.runtime.trade.configurations import Configuration, spelled_time
from bgc.runtime.trade.errors import Quantity, combined
from bgc.runtime.trade.measurement import Measurement

DEFAULT_ACCURACY = 1e-3  # of the range, where a scene requires nothing
_AT_THE_REFERENCE = 3.0  # times its accuracy: errors below it are not told from its own
_BETTER = 0.95  # times an error: what is not below it is no gain


@dataclass(frozen=True, slots=True)
class Target:
    """What is asked of a configuration.

    `required` says whether errors are in terms of `require`, and 1 is the limit; else they are
    parts of the range. `deadline` is in s, None where there is none. `sample` is the period of the
    scene's devices, s, None without devices: a longer step would take fewer samples than the scene
    says. `floor` is the error below which the reference tells nothing. `settle` is the scene's
    option of that name, 1/s.
    """

    quantities: tuple[Quantity, ...]
    required: bool
    deadline: float | None = None
    sample: float | None = None
    floor: float = 0.0
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

    def worst_quantity(self, row: Measurement) -> tuple[Quantity, float]:
        """The quantity that decides, with its error."""
        pairs = [(q, e) for q, e in zip(self.quantities, row.errors, strict=True) if q.decides]
        return max(pairs, key=lambda pair: pair[1] / pair[0].scale)


@dataclass(frozen=True, slots=True)
class Verdict:
    """`front`: no other is both cheaper and more accurate. `sentence`: what there is to say."""

    recommended: Measurement | None
    front: frozenset[Configuration]
    sentence: str


def judge(rows: Sequence[Measurement], target: Target) -> Verdict:
    """Find the front, and the cheapest configuration that is accurate and timely."""
    found = front(rows, target)
    fit = [r for r in rows if target.accurate(r) and target.timely(r) and target.samples(r)]
    best = min((r for r in fit if not r.configuration.uses), key=lambda r: r.cpu, default=None)
    sentences = [_of_best(best, target) if best is not None else _of_none(rows, target)]
    other = min((r for r in fit if r.configuration.uses), key=lambda r: r.cpu, default=None)
    if other is not None and (best is None or other.cpu < best.cpu):
        share = f"{other.cpu / best.cpu:.0%} of that time" if best else _cost(other)
        sentences.append(f"{other.configuration.label} would do too, in {share}.")
    return Verdict(best, found, " ".join(sentences))


def front(rows: Iterable[Measurement], target: Target) -> frozenset[Configuration]:
    """The configurations that no other beats in both time and error.

    Errors at the reference's accuracy count as equal, and so do those that differ by a hair.
    """
    least, found = float("inf"), []
    done = (row for row in rows if row.done)
    for row in sorted(done, key=lambda row: (row.cpu, target.error(row))):
        error = max(target.error(row), _AT_THE_REFERENCE * target.floor)
        if error < _BETTER * least:
            least = error
            found.append(row.configuration)
    return frozenset(found)


# --- the sentence -----------------------------------------------------------------------------


def _of_best(row: Measurement, target: Target) -> str:
    asked = ["`require`"] if target.required else []
    asked += ["the deadline"] if target.deadline is not None else []
    if not target.required:
        asked.insert(0, f"{DEFAULT_ACCURACY:g} of the range (the scene has no `require`)")
    statement = row.configuration.statement(target.settle)
    text = f"The cheapest configuration within {' and '.join(asked)}: `{statement}`"
    details = [_error(row, target), _cost(row)]
    if target.deadline is not None:
        details.append(f"worst {_worst(row, target)} of {spelled(target.deadline)}")
    return f"{text} with {', '.join(details)}."


def _of_none(rows: Sequence[Measurement], target: Target) -> str:
    """Why no configuration will do, and what would: the nearest on each side."""
    done = [r for r in rows if r.done and target.samples(r) and not r.configuration.uses]
    if not done:
        return "No configuration completed the run."
    accurate = [r for r in done if target.accurate(r)]
    timely = [r for r in done if target.timely(r)]
    finest = min(timely or done, key=target.error)
    if not accurate:
        which = "within the deadline " if target.deadline is not None and timely else ""
        found = f"the most accurate {which}is {finest.configuration.label} with "
        return (
            f"No configuration meets {_limit(target)}: {found}{_error(finest, target)}. "
            f"A smaller step or tolerance might (`--steps`, `--rtols`), or a `require` "
            f"{target.error(finest) / target.limit:.2g} times as wide."
        )
    quickest = min(accurate, key=lambda r: (not r.certain, r.worst))
    text = (
        f"No configuration meets {_limit(target)} and the deadline of "
        f"{spelled(target.deadline or 0.0)}. Of those accurate enough, the quickest is "
        f"{quickest.configuration.label}: worst {_worst(quickest, target)}, {_cost(quickest)}."
    )
    if timely:
        text += (
            f" Of those in time, the most accurate is {finest.configuration.label} with "
            f"{_error(finest, target)}."
        )
    noise = (
        "" if quickest.certain else ", if it is not the machine that was busy with something else"
    )
    return f"{text} A deadline of {spelled(quickest.worst)} would do{noise}."


def _limit(target: Target) -> str:
    return "`require`" if target.required else f"{target.limit:g} of the range"


def _error(row: Measurement, target: Target) -> str:
    quantity, error = target.worst_quantity(row)
    name = f"`{quantity.name}` off by {error:.2g} {quantity.unit}".rstrip()
    if target.at_reference(row):
        name += ", which is the reference's own accuracy"
    return f"{name} of {quantity.scale:.3g}" if quantity.required else name


def _cost(row: Measurement) -> str:
    return f"{spelled(row.cpu)} of processor time a second ({row.real_time_factor:.3g} x real time)"


def _worst(row: Measurement, target: Target) -> str:
    return f"{spelled(row.worst)} {'a sample' if target.sample is not None else 'a step'}"


def spelled(seconds: float) -> str:
    """A measured time, three digits."""
    return spelled_time(float(f"{seconds:.3g}"))
