"""The result of a trade study, as plain data: what tables, plots and pages show."""

from __future__ import annotations

from dataclasses import dataclass

from bgc.runtime.measuring.errors import Quantity
from bgc.runtime.trade.configurations import Configuration
from bgc.runtime.trade.judge import Target, Verdict
from bgc.runtime.trade.measurement import Measurement
from bgc.runtime.trade.reference import Reference


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class TradeResult:
    """Measurements of a scene, and the configuration recommended for it.

    Attributes
    ----------
    scene, model, machine
        What was run, and where.
    duration
        Seconds of the scene.
    measurements
        One for each configuration, those that failed among them.
    quantities
        What errors are measured in, with their scales.
    target
        What the scene requires.
    reference
        The solution that errors are measured against.
    verdict
        The Pareto front and the recommendation.
    complete
        Whether the scene's whole duration was measured, so that `solver auto` takes the answer.
    warnings
        What is to be known before the numbers are believed.
    """

    scene: str
    model: str
    machine: str
    duration: float
    measurements: tuple[Measurement, ...]
    target: Target
    reference: Reference
    verdict: Verdict
    complete: bool
    warnings: tuple[str, ...] = ()

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What errors are measured in, with their scales."""
        return self.target.quantities

    @property
    def recommended(self) -> Configuration | None:
        """The cheapest configuration that meets `require` and `deadline`; None if none does."""
        best = self.verdict.recommended
        return best.configuration if best is not None else None

    @property
    def sentence(self) -> str:
        """The recommendation in words, or why there is none and what would do."""
        return self.verdict.sentence

    def __repr__(self) -> str:
        done = sum(row.done for row in self.measurements)
        return f"<bgc trade of {self.scene}: {done} of {len(self.measurements)}; {self.sentence}>"
