"""What was measured of one configuration, as a value that can be stored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from bgc.elaboration.scenes.variants import Change
from bgc.runtime.trade.configurations import Configuration

DONE, FAILED, REFUSED = "done", "failed", "refused"
OUT_OF_BUDGET = "not run: the budget was spent; the same command goes on"


@dataclass(frozen=True, slots=True)
class Measurement:
    """One configuration: how far from the reference, and at what cost.

    Attributes
    ----------
    configuration
        What was run.
    status, message
        `done`; or `failed`, `stopped` (it took too long), `refused` (nothing was run) or
        `skipped`, with the reason. All that follows is of the first only.
    errors
        Largest absolute error of each quantity, in its unit.
    residual
        Largest energy residual over the energy exchanged; None if it is not known.
    cpu
        Processor time for a second of the scene, s.
    mean_step, worst_step, worst_sample
        Time that a step takes; that the longest one takes; and that all steps between two samples
        of the devices take at the longest, 0 where there are none; s, by the wall clock.
    paced
        The same as `worst_sample`, or as `worst_step` of a fixed step, without what the machine
        did meanwhile: see `paced_worst`. 0 where it was not looked at.
    repeats
        Runs of which these times are medians.
    counts
        Steps, evaluations and so on of one run.
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
    repeats: int = 0
    counts: Mapping[str, float] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        """Whether the run was completed."""
        return self.status == DONE

    @property
    def worst(self) -> float:
        """What has to be done by a deadline, s: the steps of a sample, or one step.

        The least of what is known of it: neither the machine nor the clock makes it shorter.
        """
        longest = self.worst_sample or self.worst_step
        return min(self.paced, longest) if self.paced and longest else self.paced or longest

    @property
    def certain(self) -> bool:
        """Whether the worst is the method's, and not what else the machine did in a single run.

        Adaptive steps of a scene without devices are not repeated one by one; there the median of
        several runs counts.
        """
        adaptive = not self.configuration.fixed and not self.worst_sample
        return self.paced > 0 or (adaptive and self.repeats > 1)

    @property
    def real_time_factor(self) -> float:
        """Seconds of the scene for a second of processor time."""
        return 1.0 / self.cpu if self.cpu > 0 else float("inf")

    def as_json(self) -> dict[str, Any]:
        """The value for a JSON file."""
        return asdict(self)


def measurement_from_json(value: Any) -> Measurement:
    """Read what `as_json` made; KeyError, TypeError or ValueError where it is something else."""
    fields = dict(value)
    given = dict(fields.pop("configuration"))
    given["changes"] = tuple(Change(**change) for change in given["changes"])
    errors: Sequence[float] = fields.pop("errors")
    return Measurement(Configuration(**given), errors=tuple(map(float, errors)), **fields)
