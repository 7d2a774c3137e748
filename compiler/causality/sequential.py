"""The sequential assignment of causality, with transformers solved whole.

Flows that are known make others known: a row with one unknown class is solved for it, and a
transformer with as many unknown classes as rows is solved for all of them at once, forwards or by
its inverse. Where nothing more is known, one more class becomes independent.

In an open chain of rigid joints every rotation is then solved in one direction, from the frame
that is known first, whatever entries of its matrix happen to be constant. That needs the twist of
a frame to be known as a whole, so coordinates come before the flows of bodies, and the flows of
one body before those of the next. The procedure is that of Karnopp and Rosenberg (SCAP), without
its preference for inertias.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.algebra.dag import Dag, Level
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.certificates import Certifier, Rank, Size
from bgc.causality.regions import Block, Structure
from bgc.causality.rotations import known_inverse
from bgc.causality.working_rows import (
    BARE,
    COMPLIANCE,
    EFFORT_SOURCE,
    FLOW_SOURCE,
    INERTIA,
    READ,
    RESISTANCE,
    WorkingRows,
)

_PLACES = {RESISTANCE: 0, EFFORT_SOURCE: 1, COMPLIANCE: 2, READ: 4, INERTIA: 5, BARE: 6}
_COORDINATE = 3  # place of a class without an element that a transformer spreads
_FOLLOWING = 7  # place of a class that a transformer without an inverse gives


def eliminate_in_sequence(
    dag: Dag, fingerprints: Fingerprints, certifier: Certifier, structure: Structure
) -> WorkingRows:
    """Solve the rows for all classes but those that become independent, in the order above.

    Rows that only independent classes are left in remain.
    """
    return _Sequence(dag, fingerprints, certifier, structure).run()


class _Sequence:
    def __init__(
        self, dag: Dag, fingerprints: Fingerprints, certifier: Certifier, structure: Structure
    ) -> None:
        self._certifier = certifier
        self._rows = WorkingRows(dag, fingerprints, certifier, structure)
        self._order = _order(dag, fingerprints, structure, self._rows.levels)
        self._solved: set[int] = set()
        self._blocks = [
            block for block in structure.blocks if len(block.rows) == len(block.lower) > 1
        ]

    def run(self) -> WorkingRows:
        """Propagate what is known, and make one class after the other independent."""
        self._propagate()
        for number in self._order:
            if not self._rows.open:
                break
            if number not in self._solved:
                self._rows.levels[number] = FLOW_SOURCE
                self._rows.changed |= self._rows.rows_with(number)
                self._propagate()
        return self._rows

    def _propagate(self) -> None:
        """Solve for every class that follows from those known."""
        while self._rows.changed:
            changed = sorted(self._rows.changed & self._rows.open)
            self._rows.changed.clear()
            for row in changed:
                if row in self._rows.open and len(self._unknown([row])) == 1:
                    self._solve_one_of([row])
            if not self._rows.changed:
                for block in self._blocks:
                    if not self._rows.open.isdisjoint(block.rows):
                        self._solve_block(block)

    def _unknown(self, rows: Iterable[int]) -> set[int]:
        levels = self._rows.levels
        return {n for row in rows for n in self._rows.entries(row) if levels[n] != FLOW_SOURCE}

    def _solve_block(self, block: Block) -> None:
        """Solve the open rows of a transformer if they have as many unknown classes."""
        rows = [row for row in block.rows if row in self._rows.open]
        if len(self._unknown(rows)) != len(rows):
            return
        if self._rows.invert(block, FLOW_SOURCE) or self._rows.has_pivots(rows, FLOW_SOURCE):
            while rows and self._solve_one_of(rows):
                rows = [row for row in rows if row in self._rows.open]

    def _solve_one_of(self, rows: Sequence[int]) -> bool:
        """Solve one of some rows for an unknown class by the best pivot, if there is one."""
        pivots: list[tuple[Size, int, int, int]] = []
        for row in rows:
            entries = self._rows.entries(row)
            unknown = self._unknown([row])
            for number in unknown:
                size = self._certifier.size_in(entries[number], (entries[n] for n in unknown))
                if size is not None and size.rank is not Rank.DOUBTFUL:
                    pivots.append((size, len(unknown), row, number))
        if not pivots:
            return False
        _, _, row, number = min(pivots)
        self._rows.solve(number, row)
        self._solved.add(number)
        return True


def _order(
    dag: Dag, fingerprints: Fingerprints, structure: Structure, levels: Sequence[int]
) -> list[int]:
    """The classes in the order in which they become independent where none is known."""
    places = {n: _PLACES[level] for n, level in enumerate(levels) if level != FLOW_SOURCE}
    for block in structure.blocks:
        for bond in block.lower if block.spreads else ():
            if levels[structure.class_of[bond]] == BARE:
                places[structure.class_of[bond]] = _COORDINATE
    for block in structure.blocks:
        if not _has_inverse(dag, fingerprints, block):
            for bond in block.upper:
                if levels[structure.class_of[bond]] != FLOW_SOURCE:
                    places[structure.class_of[bond]] = _FOLLOWING
    elements = [
        min((structure.ports[k].element for k in members.ports), default=len(levels))
        for members in structure.classes
    ]
    return sorted(places, key=lambda n: (places[n], elements[n], n))


def _has_inverse(dag: Dag, fingerprints: Fingerprints, block: Block) -> bool:
    """Test whether the matrix of a block is constant and square, or has a known inverse."""
    if len(block.rows) != len(block.lower):
        return False
    if block.inverse or all(dag.level[x] <= Level.PARAM for row in block.matrix for x in row):
        return True
    return known_inverse(dag, fingerprints, block.matrix) is not None
