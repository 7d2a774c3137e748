"""Parameters that a search within bounds has found: what an estimate and an optimum share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.public import public_class
from bgc.record_class import dataclass, field
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.html import Tabled
from bgc.values.shown_units import Shown


@public_class
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class FoundParameters(Tabled):
    """Values of parameters, SI: `found["k"]`.

    The attributes are those of `Estimate` and `Optimum`.
    """

    scene: str
    names: tuple[str, ...]
    values: Array
    start: Array
    at_bound: tuple[bool, ...]
    shown: Mapping[str, Shown]
    converged: bool
    runs: int
    failed: int
    warnings: tuple[Diagnostic, ...] = field(default=())

    def __getitem__(self, name: str) -> float:
        return self.parameters()[name]

    def _ipython_key_completions_(self) -> list[str]:
        return [*self.names]

    def parameters(self) -> dict[str, float]:
        """The values by name, SI: an argument of `Model.simulate(parameters=..)`."""
        return dict(zip(self.names, self.values.tolist(), strict=True))

    def _rows(self) -> Iterator[tuple[int, Shown, str, str, str, str]]:
        """For each parameter its number and unit; its label, value, start and note as texts."""
        for k, name in enumerate(self.names):
            shown = self.shown[name]
            value, start = (f"{shown.number(x):.6g}" for x in (self.values[k], self.start[k]))
            yield k, shown, shown.heading(name), value, start, "at its bound" * self.at_bound[k]

    def _note(self, search: str, *more: str) -> str:
        """The number of runs, and whether the search converged, as lines below a table."""
        failed = f", {self.failed} of which failed" if self.failed else ""
        ended = () if self.converged else (f"the {search} did not converge",)
        return "\n".join((f"{counted(self.runs, 'run')}{failed}", *more, *ended))
