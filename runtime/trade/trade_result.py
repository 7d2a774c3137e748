"""The result of a trade study as plain data, for tables, plots and pages."""

from __future__ import annotations

from bgc.record_class import dataclass
from bgc.runtime.measuring.judging import Quantity
from bgc.runtime.trade.configurations import Configuration
from bgc.runtime.trade.judge import Target, Verdict
from bgc.runtime.trade.measurement import Measurement
from bgc.runtime.trade.reference_solution import Reference


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class TradeResult:
    """Measurements of a scene, and the configuration recommended for it.

    Attributes
    ----------
    scene, model, machine
        The scene, its model, and the machine.
    duration
        Seconds of the scene.
    measurements
        One for each configuration, including failed ones.
    quantities
        The quantities whose errors are measured, with their scales.
    target
        The demands of the scene.
    reference
        The reference solution.
    verdict
        The Pareto front and the recommendation.
    complete
        True if the whole duration was measured, so that `solver auto` uses the recommendation.
    warnings
        Limits of the measurements.
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
        """The quantities whose errors are measured, with their scales."""
        return self.target.quantities

    @property
    def recommended(self) -> Configuration | None:
        """The cheapest configuration that meets `require` and `deadline`; None if none does."""
        best = self.verdict.recommended
        return best.configuration if best is not None else None

    @property
    def margins(self) -> dict[str, float]:
        """Limit over `error`, deadline over worst `time`, and `speed` over the one demanded.

        Those of the recommended configuration, each where it was demanded; empty without one.
        """
        best = self.verdict.recommended
        return {} if best is None else self.target.margins(best)

    @property
    def sentence(self) -> str:
        """The recommendation in words, or the reason why there is none, with the nearest ones."""
        return self.verdict.sentence

    def __repr__(self) -> str:
        done = sum(row.done for row in self.measurements)
        return f"<bgc trade of {self.scene}: {done} of {len(self.measurements)}; {self.sentence}>"
