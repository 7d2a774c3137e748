"""The measurement of one configuration, as a value that can be stored."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.record_class import dataclass, field
from bgc.runtime.trade.configurations import Configuration

DONE, FAILED, REFUSED, SKIPPED = "done", "failed", "refused", "skipped"
OUT_OF_BUDGET = "not run: the budget was spent; the same command continues"


@dataclass(frozen=True, slots=True)
class Measurement:
    """The error and the cost of one configuration.

    Attributes
    ----------
    configuration
        The measured configuration.
    status, message
        `done`; or `failed`, `stopped` (it took too long), `refused` (nothing was run) or
        `skipped`, with the reason. All other attributes are for `done` only.
    errors
        Largest absolute error of each quantity, in its unit.
    residual
        Largest energy residual over the energy exchanged; None if it is not known.
    cpu
        Processor time for a second of the scene, s.
    mean_step, worst_step, worst_sample
        Mean and longest time of a step, and longest time of all steps between two samples of the
        devices (0 without devices); s of wall time.
    paced
        As `worst_sample`, or `worst_step` for a fixed step, but without disturbances by the
        machine, and without the slowest thousandth: see `Paced`. 0 if not measured.
    slowest, periods
        The slowest of them, s, in descending order down to `paced`, and the number of all.
    repeats
        The number of runs of which these times are medians.
    counts
        Steps, evaluations and other counts of one run.
    """

    configuration: Configuration
    status: str
    message: str = ""
    errors: tuple[float, ...] = ()
    residual: float | None = None
    cpu: float = 0.0
    mean_step: float = 0.0
    worst_step: float = 0.0
    worst_sample: float = 0.0
    paced: float = 0.0
    slowest: tuple[float, ...] = ()
    periods: int = 0
    repeats: int = 0
    counts: Mapping[str, float] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        """True if the run was completed."""
        return self.status == DONE

    @property
    def worst(self) -> float:
        """The worst time of the work with a deadline, s: the steps of a sample, or one step.

        The smallest of the measured values, since disturbances only lengthen them.
        """
        longest = self.worst_sample or self.worst_step
        return min(self.paced, longest) if self.paced and longest else self.paced or longest

    def late(self, deadline: float) -> int:
        """The number of periods that took longer than a deadline, s, as far as `slowest` goes."""
        return sum(seconds > deadline for seconds in self.slowest)

    @property
    def certain(self) -> bool:
        """True if `worst` is the method's, and not a disturbance by the machine in a single run.

        Adaptive steps of a scene without devices cannot be repeated one by one; there the median
        of several runs is taken.
        """
        adaptive = not self.configuration.fixed and not self.worst_sample
        return self.paced > 0 or (adaptive and self.repeats > 1)

    @property
    def real_time_factor(self) -> float:
        """Seconds of the scene for a second of processor time."""
        return 1.0 / self.cpu if self.cpu > 0 else float("inf")
