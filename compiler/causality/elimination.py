"""Find the independent through variables by elimination with certified pivots.

The rows of the junction structure are solved for one class of bonds after the other. The pivot is
always a coefficient that is certain not to vanish (`certificates`); a modulus that depends on the
state is never a pivot. The order in which classes become dependent:

1. by element: classes without an element first, then those with effort sources, compliances,
   resistances, inertias; those with flow sources never. Pivots that are expressions of parameters
   and may vanish come last, whatever the class.
2. by size: rows in which the pivot is not small beside another coefficient, which bounds N.
3. by sparsity: the class in the fewest rows, solved ones included, so that few variables depend
   on it and N stays sparse.

Before an inertia becomes dependent, blocks of rows of a transformer with a known inverse are
inverted if that keeps the inertia independent, or makes the far side of a joint follow from the
near side. Otherwise a single joint with exchanged ends would appear to be a closed chain.

This order takes single rows of a rotation where their coefficients are constant, and the rows
left of the same rotation may then have no certified pivot, or one of 5e-12 where a quarter turn is
written in eleven digits. The rows are then solved once more in the order of `sequential`, which
takes rotations whole.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection
from functools import partial
from typing import TypeAlias

from bgc.algebra.dag import Dag
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.certificates import Certifier, Rank, Size
from bgc.causality.regions import Structure
from bgc.causality.sequential import eliminate_in_sequence
from bgc.causality.working_rows import FLOW_SOURCE, INERTIA, READ, Elimination, WorkingRows

_LAST = FLOW_SOURCE + 1  # added to the level for a pivot that may vanish: when nothing else is left
_SPARED = (INERTIA, READ, FLOW_SOURCE)  # levels below which an inverted block is solved
_HUB = 64  # rows with a class, from which on it waits by a lower bound of its key
_WEAK = 1e-3  # beside the largest entry of its row: a pivot below it is avoided if possible

_Key: TypeAlias = tuple[int, Size, int]  # level of a class, size of its best pivot, rows with it


def eliminate(
    dag: Dag,
    fingerprints: Fingerprints,
    certifier: Certifier,
    structure: Structure,
    carrying: Collection[int] = (),
    following: Collection[int] = (),
    *,
    whole: bool = False,
) -> Elimination:
    """Solve the rows for as many classes as certified pivots allow, in the order above.

    With `whole` they are solved in the order of `sequential`.

    Classes without an element that are in `carrying` are kept independent where a compliance or a
    resistance can depend on them. Where some independent ones are in `following`, the closing rows
    are taken in last, and solved for these.
    """
    if whole:
        rows = eliminate_in_sequence(dag, fingerprints, certifier, structure)
    else:
        rows = _best(dag, fingerprints, certifier, structure, carrying)
    if following:
        rows.close(structure.closing, following)
    return rows.result()


def _best(
    dag: Dag,
    fingerprints: Fingerprints,
    certifier: Certifier,
    structure: Structure,
    carrying: Collection[int],
) -> WorkingRows:
    """The rows solved in one order, or in sequence where that is better."""
    rows = _Work(dag, fingerprints, certifier, structure, carrying).run()
    sparse = rows.result()
    if not sparse.unsolved and sparse.weakest > _WEAK:
        return rows
    in_sequence = eliminate_in_sequence(dag, fingerprints, certifier, structure)
    whole = in_sequence.result()
    better = min(sparse, whole, key=lambda e: (e.unsolved, -min(e.weakest, _WEAK)))
    return rows if better is sparse else in_sequence


class _Work:
    def __init__(
        self,
        dag: Dag,
        fingerprints: Fingerprints,
        certifier: Certifier,
        structure: Structure,
        carrying: Collection[int],
    ) -> None:
        self._certifier = certifier
        self._rows = WorkingRows(dag, fingerprints, certifier, structure, carrying)
        self._followers = [0] * len(structure.classes)  # steps whose working row has a class
        self._blocks = [block for block in structure.blocks if block.varies]
        # Rows of blocks that cannot be inverted as they are, by the level that was asked for.
        self._refused: dict[int, set[int]] = {level: set() for level in _SPARED}
        self._queue: list[tuple[_Key, int]] = []
        self._largest: dict[int, float] = {}  # row -> its largest entry that does not vary
        for number in range(len(structure.classes)):
            self._enqueue(number)

    def run(self) -> WorkingRows:
        """Eliminate by the best pivot until there is none; invert blocks to spare inertias."""
        while True:
            pivot = self._next_pivot()
            if pivot is None:
                if not any(map(self._invert_block, _SPARED)):
                    return self._rows
                continue
            level, number, row = pivot
            spared = [limit for limit in _SPARED if INERTIA <= level >= limit - 1]
            if any(map(self._invert_block, spared)):
                self._enqueue(number)
            else:
                self._solve(number, row)

    def _candidate(self, number: int) -> tuple[_Key, int] | None:
        """The key of a class in the queue, and the row of its best pivot."""
        level = self._rows.levels[number]
        if level == FLOW_SOURCE:
            return None
        best = None
        for row in self._rows.rows_with(number):
            entries = self._rows.entries(row)
            size = self._certifier.size_beside(entries[number], partial(self._largest_in, row))
            if size is not None:
                key = (size, len(entries), row)
                best = key if best is None else min(best, key)
        if best is None:
            return None
        if best[0].rank is Rank.DOUBTFUL:
            level += _LAST
        count = len(self._rows.rows_with(number)) + self._followers[number]
        return (level, best[0], count), best[2]

    def _largest_in(self, row: int) -> float:
        """The largest steady entry of a row, which many classes may share."""
        if row not in self._largest:
            entries = self._rows.entries(row).values()
            self._largest[row] = self._certifier.largest_in(entries)
        return self._largest[row]

    def _forget_changed(self) -> None:
        for row in self._rows.changed:
            self._largest.pop(row, None)

    def _enqueue(self, number: int) -> None:
        candidate = self._candidate(number)
        if candidate is not None:
            heapq.heappush(self._queue, (candidate[0], number))

    def _enqueue_changed(self, number: int) -> None:
        """Enqueue a class; one in many rows by a lower bound, whose pivot is looked for later."""
        rows, level = len(self._rows.rows_with(number)), self._rows.levels[number]
        if rows <= _HUB or level == FLOW_SOURCE:
            self._enqueue(number)
            return
        key = (level, Size(Rank.UNIT, is_small=False), rows + self._followers[number])
        heapq.heappush(self._queue, (key, number))

    def _next_pivot(self) -> tuple[int, int, int] | None:
        """The level of the best class, the class and its row; queued keys may be out of date."""
        while self._queue:
            key, number = heapq.heappop(self._queue)
            candidate = self._candidate(number)
            if candidate is None:
                continue
            (level, size, _), row = candidate
            if candidate[0] > key or (size.is_small and self._has_better(row, candidate[0])):
                heapq.heappush(self._queue, (candidate[0], number))
                continue
            return level, number, row
        return None

    def _has_better(self, row: int, key: _Key) -> bool:
        """Test whether, with keys brought up to date, another class of the row comes first."""
        for number in self._rows.entries(row):
            self._enqueue(number)
        return self._queue[0][0] < key

    def _solve(self, number: int, row: int) -> None:
        """Make a class dependent by a row, and bring the queue up to date."""
        self._rows.changed.clear()
        self._rows.solve(number, row)
        self._forget_changed()
        for refused in self._refused.values():
            refused -= self._rows.changed
        for other in self._rows.entries(row):
            if other != number:
                self._followers[other] += 1
                self._enqueue_changed(other)

    def _invert_block(self, below: int) -> bool:
        """Invert the first block that can then be solved for classes below a level."""
        refused = self._refused[below]
        for block in self._blocks:
            if refused.issuperset(block.rows):
                continue
            refused.update(block.rows)
            numbers = self._rows.invert(block, below)
            self._forget_changed()
            if numbers is not None:
                for number in numbers:
                    self._enqueue(number)
                return True
        return False
