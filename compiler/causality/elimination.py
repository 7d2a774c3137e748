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
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from bgc.algebra.dag import Dag
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.certificates import Certifier, Rank, Size
from bgc.causality.regions import Block, Structure
from bgc.causality.rotations import known_inverse
from bgc.ir.causal import BondClass, ElementPort, Role, Row, RowEnd, Step
from bgc.ir.graph import Matrix, Node

_LEVELS = {
    Role.EFFORT_SOURCE: 1,
    Role.COMPLIANCE: 2,
    Role.RESISTANCE: 3,
    Role.INERTIA: 4,
    Role.FLOW_SOURCE: 5,
}
_SPARED = 4  # level of inertias, which become dependent only when nothing else can
_NEVER = 5  # level of flow sources
_LAST = 6  # added to the level for a pivot that may vanish: used when nothing else is left

_Key: TypeAlias = tuple[int, Size, int]  # level of a class, size of its best pivot, rows with it


@dataclass(frozen=True, slots=True)
class Elimination:
    """The result of the elimination.

    `rows` are the rows of the structure, inverted blocks replaced. `remaining` are the rows without
    a certified pivot at a class that may be dependent, with their remaining entries; one without
    entries is redundant. `origins[r]` are the rows that the working row of row r combines.
    """

    rows: tuple[Row, ...]
    steps: tuple[Step, ...]
    remaining: tuple[tuple[int, tuple[tuple[int, Node], ...]], ...]
    origins: tuple[frozenset[int], ...]
    watched: tuple[tuple[Node, int], ...]  # node of PARAM level used as pivot, row


def level_of(members: BondClass, ports: Sequence[ElementPort]) -> int:
    """The level of a class in the order of elimination, by its elements."""
    return max((_LEVELS[ports[k].role] for k in members.ports), default=0)


def eliminate(
    dag: Dag, fingerprints: Fingerprints, certifier: Certifier, structure: Structure
) -> Elimination:
    """Solve the rows for as many classes as certified pivots allow, in the order above."""
    work = _Work(dag, fingerprints, certifier, structure)
    work.run()
    return work.result()


@dataclass(slots=True)
class _Form:
    """A linear form in the through variables of classes; each row sets one to zero."""

    entries: dict[int, Node]
    factors: dict[int, Node]  # row -> multiple of its working row that was subtracted


class _Work:
    def __init__(
        self, dag: Dag, fingerprints: Fingerprints, certifier: Certifier, structure: Structure
    ) -> None:
        self._dag = dag
        self._fingerprints = fingerprints
        self._certifier = certifier
        self._class_of = structure.class_of
        self._levels = [level_of(c, structure.ports) for c in structure.classes]
        self._rows: list[Row] = []
        self._forms: list[_Form] = []  # working row of each row
        self._where: list[set[int]] = [set() for _ in structure.classes]  # open rows with a class
        self._followers = [0] * len(structure.classes)  # steps whose working row has a class
        self._open: set[int] = set()
        self._steps: list[Step] = []
        self._watched: list[tuple[Node, int]] = []
        self._blocks = structure.blocks
        # Rows of blocks that cannot be inverted as they are, by the level that was asked for.
        self._refused: dict[int, set[int]] = {_SPARED: set(), _NEVER: set()}
        self._queue: list[tuple[_Key, int]] = []
        for row in structure.rows:
            terms = [(self._unit_form(end.bond), end.coefficient) for end in row.ends]
            self._rows.append(row)
            self._forms.append(_Form({}, {}))
            self._set_form(len(self._rows) - 1, self._combined(terms))
        for number in range(len(structure.classes)):
            self._enqueue(number)

    def run(self) -> None:
        """Eliminate by the best pivot until there is none; invert blocks to spare inertias."""
        while True:
            pivot = self._next_pivot()
            if pivot is None:
                if not (self._invert_block(_SPARED) or self._invert_block(_NEVER)):
                    return
                continue
            level, number, row = pivot
            if level >= _SPARED and (self._invert_block(_SPARED) or self._invert_block(_NEVER)):
                self._enqueue(number)
            else:
                self._solve(number, row)

    def result(self) -> Elimination:
        origins: list[frozenset[int]] = [frozenset()] * len(self._rows)
        order = [step.row for step in self._steps] + sorted(self._open)
        for row in order:
            used = (origins[r] for r in self._forms[row].factors)
            origins[row] = frozenset({row}).union(*used)
        remaining = tuple((r, tuple(self._forms[r].entries.items())) for r in sorted(self._open))
        return Elimination(
            tuple(self._rows), tuple(self._steps), remaining, tuple(origins), tuple(self._watched)
        )

    # --- pivots -------------------------------------------------------------------------

    def _candidate(self, number: int) -> tuple[_Key, int] | None:
        """The key of a class in the queue, and the row of its best pivot."""
        level = self._levels[number]
        if level == _NEVER:
            return None
        best = None
        for row in self._where[number]:
            entries = self._forms[row].entries
            size = self._certifier.size_in(entries[number], entries.values())
            if size is not None:
                key = (size, len(entries), row)
                best = key if best is None else min(best, key)
        if best is None:
            return None
        if best[0].rank is Rank.DOUBTFUL:
            level += _LAST
        return (level, best[0], len(self._where[number]) + self._followers[number]), best[2]

    def _enqueue(self, number: int) -> None:
        candidate = self._candidate(number)
        if candidate is not None:
            heapq.heappush(self._queue, (candidate[0], number))

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
        for number in self._forms[row].entries:
            self._enqueue(number)
        return self._queue[0][0] < key

    def _solve(self, number: int, row: int) -> None:
        """Make a class dependent by a row, and eliminate it from all other rows."""
        form = self._forms[row]
        pivot = form.entries[number]
        certificate = self._certifier.certify(pivot)
        assert certificate is not None
        self._watched.extend((node, row) for node in certificate.watched)
        self._open.remove(row)
        for other in form.entries:
            self._where[other].discard(row)
        for other_row in sorted(self._where[number]):
            target = self._forms[other_row]
            before = set(target.entries)
            self._subtract(target, number, row, form, pivot)
            for refused in self._refused.values():
                refused.discard(other_row)
            for changed in before - set(target.entries):
                self._where[changed].discard(other_row)
            for changed in set(target.entries) - before:
                self._where[changed].add(other_row)
        step = Step(row, number, tuple(form.entries.items()), tuple(form.factors.items()))
        self._steps.append(step)
        for other in form.entries:
            if other != number:
                self._followers[other] += 1
                self._enqueue(other)

    def _subtract(self, target: _Form, number: int, row: int, source: _Form, pivot: Node) -> None:
        factor = self._dag.div(target.entries.pop(number), pivot)
        target.factors[row] = factor
        rest = {other: entry for other, entry in source.entries.items() if other != number}
        self._take(target.entries, rest, factor)

    def _take(self, target: dict[int, Node], source: Mapping[int, Node], factor: Node) -> None:
        """Subtract a multiple of the entries of one row from those of another."""
        dag = self._dag
        for number, entry in source.items():
            taken = dag.sub(target.get(number, dag.zero), dag.mul(factor, entry))
            self._set(target, number, taken)

    def _set(self, entries: dict[int, Node], number: int, node: Node) -> None:
        """Set an entry, or remove it if it is always zero."""
        node = self._fingerprints.simplified(node)
        if node == self._dag.zero:
            entries.pop(number, None)
        else:
            entries[number] = node

    # --- rows and blocks -------------------------------------------------------------------

    def _unit_form(self, bond: int) -> _Form:
        """The through variable of a bond as a form."""
        return _Form({self._class_of[bond]: self._dag.one}, {})

    def _combined(self, terms: Iterable[tuple[_Form, Node]]) -> _Form:
        """A weighted sum of forms."""
        dag = self._dag
        entries: dict[int, Node] = {}
        factors: dict[int, Node] = {}
        for form, weight in terms:
            for number, entry in form.entries.items():
                total = dag.add(entries.get(number, dag.zero), dag.mul(weight, entry))
                self._set(entries, number, total)
            for row, factor in form.factors.items():
                factors[row] = dag.add(factors.get(row, dag.zero), dag.mul(weight, factor))
        return _Form(entries, factors)

    def _set_form(self, row: int, form: _Form) -> None:
        """Set the working row of an open row."""
        for number in self._forms[row].entries:
            self._where[number].discard(row)
        self._forms[row] = form
        self._open.add(row)
        for number in form.entries:
            self._where[number].add(row)

    def _invert_block(self, below: int) -> bool:
        """Invert the first block that can then be solved for classes below a level."""
        refused = self._refused[below]
        for block in self._blocks:
            if refused.issuperset(block.rows):
                continue
            refused.update(block.rows)
            rows = [row for row in block.rows if row in self._open]
            weights = self._inverse_of(block, rows)
            if weights is None:
                continue
            inverted = [
                self._combined((self._forms[row], w) for row, w in zip(rows, line, strict=True))
                for line in weights
            ]
            if self._has_pivots(inverted, below):
                raw = [self._combined_row([self._rows[row] for row in rows], w) for w in weights]
                for row, line, form in zip(rows, raw, inverted, strict=True):
                    self._rows[row] = line
                    self._set_form(row, form)
                for number in {n for form in inverted for n in form.entries}:
                    self._enqueue(number)
                return True
        return False

    def _inverse_of(self, block: Block, rows: Sequence[int]) -> Matrix | None:
        """The factor that solves the open rows of a block for its lower bonds; None if unknown.

        Lower bonds that earlier rows were solved for are left out.
        """
        taken = {step.dependent for step in self._steps if step.row in block.rows}
        columns = [j for j, bond in enumerate(block.lower) if self._class_of[bond] not in taken]
        positions = [block.rows.index(row) for row in rows]
        if not rows or len(columns) != len(rows):
            return None
        part = tuple(tuple(block.matrix[i][j] for j in columns) for i in positions)
        whole = block.inverse if len(rows) == len(block.rows) else None
        inverse = whole or known_inverse(self._dag, self._fingerprints, part)
        if inverse is None:
            return None
        return tuple(tuple(map(self._dag.neg, line)) for line in inverse)

    def _combined_row(self, rows: Sequence[Row], weights: Sequence[Node]) -> Row:
        """A weighted sum of rows of one element, in terms of bonds."""
        dag = self._dag
        totals: dict[tuple[int, int], Node] = {}
        for row, weight in zip(rows, weights, strict=True):
            for end in row.ends:
                place = (end.bond, end.sign)
                term = dag.mul(weight, end.coefficient)
                totals[place] = dag.add(totals.get(place, dag.zero), term)
        simplified = self._fingerprints.simplified
        ends = (RowEnd(bond, sign, simplified(node)) for (bond, sign), node in totals.items())
        kept = tuple(end for end in ends if end.coefficient != dag.zero)
        return Row(rows[0].element, kept)

    def _has_pivots(self, forms: Sequence[_Form], below: int) -> bool:
        """Test whether the forms can be solved, one after the other, for classes below a level."""
        left = [dict(form.entries) for form in forms]
        while left:
            found = self._pivot_among(left, below)
            if found is None:
                return False
            index, number = found
            source = left.pop(index)
            pivot = source.pop(number)
            for target in left:
                if number in target:
                    factor = self._dag.div(target.pop(number), pivot)
                    self._take(target, source, factor)
        return True

    def _pivot_among(self, forms: Sequence[dict[int, Node]], below: int) -> tuple[int, int] | None:
        """A form and a class it can be solved for, a class that is in few forms."""
        held = Counter(number for form in forms for number in form)
        candidates = (
            (held[number], index, number)
            for index, form in enumerate(forms)
            for number, entry in form.items()
            if self._levels[number] < below and self._certifier.certify(entry) is not None
        )
        best = min(candidates, default=None)
        return best and best[1:]
