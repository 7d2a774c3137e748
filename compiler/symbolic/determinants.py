"""Determinants of sparse matrices of integer polynomials, without a division.

The strongly connected components of its pattern split a matrix into blocks; their determinants are
factors of that of the matrix. The determinant of a block is expanded row by row into minors on the
columns used so far, each computed once (Gentleman and Johnson 1976). A sparse block in a good order
of rows has few such minors, and since the entries of a model are mostly different letters, few
terms cancel.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from sympy.polys.rings import PolyElement, PolyRing

from bgc.algebra.matching import match
from bgc.algebra.strong_components import all_components
from bgc.record_class import dataclass

Row: TypeAlias = Mapping[int, PolyElement]
"""Column -> entry, the zero ones left out."""


@dataclass
class Budget:
    """Multiplications of terms that may still be made; `refuse` raises when they are used up.

    A count, not a time: the same model is refused on every machine.
    """

    left: int
    most_terms: int
    refuse: Callable[[], Exception]

    def product(self, a: PolyElement, b: PolyElement) -> PolyElement:
        """The product of two polynomials."""
        self.spend(len(a) * len(b))
        return a * b

    def spend(self, products: int) -> None:
        """Count some work."""
        self.left -= products
        if self.left < 0:
            raise self.refuse()

    def check(self, terms: int) -> None:
        """Refuse a polynomial, or several, of too many terms."""
        if terms > self.most_terms:
            raise self.refuse()


def determinant_factors(
    rows: Sequence[Row], ring: PolyRing, budget: Budget
) -> list[PolyElement] | None:
    """Polynomials whose product is the determinant of a square matrix; None where it is zero.

    The sign is in the first; the matrix without rows has the determinant 1.
    """
    column_of = match([sorted(row) for row in rows], {})
    if len(column_of) < len(rows):
        return None
    row_of = {column: row for row, column in column_of.items()}
    parts = all_components(range(len(rows)), lambda r: [row_of[c] for c in rows[r]])
    sign = _parity([column_of[r] for r in range(len(rows))])
    factors = [ring.one * sign]
    for part in parts:
        columns = {column_of[r]: k for k, r in enumerate(part)}
        inner = [{columns[c]: e for c, e in rows[r].items() if c in columns} for r in part]
        factor = _determinant(inner, ring, budget)
        if not factor:
            return None
        factors.append(factor)
    return factors


def _determinant(rows: Sequence[Row], ring: PolyRing, budget: Budget) -> PolyElement:
    order = _row_order(rows)
    columns: dict[int, int] = {}
    for r in order:
        for c in sorted(rows[r]):
            columns.setdefault(c, len(columns))
    last = {columns[c]: k for k, r in enumerate(order) for c in rows[r]}
    minors: dict[int, PolyElement] = {0: ring.one}
    closed = 0  # columns that no later row has: every minor must use them
    for k, r in enumerate(order):
        closed |= sum(1 << c for c, final in last.items() if final == k)
        grown: dict[int, PolyElement] = {}
        for used, minor in minors.items():
            for column, entry in rows[r].items():
                bit = 1 << columns[column]
                if used & bit or (used | bit) & closed != closed:
                    continue
                term = budget.product(minor, entry)
                behind = (used >> columns[column]).bit_count()
                known = grown.get(used | bit, ring.zero)
                grown[used | bit] = known - term if behind % 2 else known + term
        minors = {used: minor for used, minor in grown.items() if minor}
        budget.check(sum(map(len, minors.values())))
    (whole,) = minors.values() or (ring.zero,)
    sign = _parity(order) * _parity([columns[c] for c in range(len(rows))])
    return whole if sign > 0 else -whole


def _row_order(rows: Sequence[Row]) -> list[int]:
    """The rows in an order in which few columns are open at a time."""
    left = set(range(len(rows)))
    uses = [0] * len(rows)
    for row in rows:
        for c in row:
            uses[c] += 1
    opened: set[int] = set()
    order: list[int] = []
    while left:
        best = min(
            left,
            key=lambda r: (
                sum(c not in opened for c in rows[r]) - sum(uses[c] == 1 for c in rows[r]),
                len(rows[r]),
                r,
            ),
        )
        left.remove(best)
        order.append(best)
        opened.update(rows[best])
        for c in rows[best]:
            uses[c] -= 1
    return order


def _parity(permutation: Sequence[int]) -> int:
    """1 of an even permutation of 0, 1, .., -1 of an odd one."""
    seen: set[int] = set()
    sign = 1
    for start in range(len(permutation)):
        place, length = start, 0
        while place not in seen:
            seen.add(place)
            place = permutation[place]
            length += 1
        if length and length % 2 == 0:
            sign = -sign
    return sign
