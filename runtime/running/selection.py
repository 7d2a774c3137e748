"""The outputs in the rows of a run, in the scene's order and in the units of their columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bgc.runtime.results.arrays import Array


@dataclass(frozen=True, slots=True)
class Selection:
    """The places of the outputs in a row that C writes, and the units of the numbers there.

    An output is the number at its place divided by its factor. C writes energy accounts in J and
    all other columns in their own units, so that only accounts have a factor other than 1.
    """

    places: tuple[int, ...]
    factors: tuple[float, ...]

    def of(self, rows: Array) -> Array:
        """The outputs, (.., outputs), of rows, (.., width)."""
        if self.places == tuple(range(rows.shape[-1])) and not self._converts:
            return rows
        found = rows[..., list(self.places)]
        return found / np.array(self.factors) if self._converts else found

    def column(self, rows: Array, output: int) -> Array:
        """One output of rows, (rows, width); a view of them where it needs no conversion."""
        found = rows[:, self.places[output]]
        return found if self.factors[output] == 1.0 else found / self.factors[output]

    def fill(self, rows: Array, outputs: Array) -> None:
        """Write outputs back to their places in rows."""
        rows[..., list(self.places)] = outputs * np.array(self.factors)

    @property
    def _converts(self) -> bool:
        return any(factor != 1.0 for factor in self.factors)
