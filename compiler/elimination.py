"""Which through variables are independent: elimination with certified pivots.

The rows of the junction structure are solved for one class of bonds after the other. A class is
made dependent only through a coefficient that is certain never to vanish (`certificates`); a
modulus that depends on the state is never divided by. Classes without an element go first, then
those with sources of effort, compliances, resistances, inertias; flow sources never. Of equals
the one in fewest rows goes first, rows solved before included: few others then follow from it,
and N stays sparse.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from bgc.causal import BondClass, ElementPort, Role, Row, Step
from bgc.certificates import Certifier
from bgc.dag import Dag
from bgc.fingerprint import Fingerprints
from bgc.graph import Node
from bgc.regions import Block, Structure

_LEVELS = {
    Role.EFFORT_SOURCE: 1,
    Role.COMPLIANCE: 2,
    Role.RESISTANCE: 3,
    Role.INERTIA: 4,
    Role.FLOW_SOURCE: 5,
}
_NEVER = 5

PivotLevel: TypeAlias = Callable[[int, Node], int]


@dataclass(frozen=True, slots=True)
class Elimination:
    """The rows (matrix blocks now written one way round), the steps, and what was left.

    `remaining` are rows without a certified coefficient at a class that may be dependent, with
    what is left of them; an empty one says nothing new. `origins[r]` are the rows that went
    into the working row of row r.
    """

    rows: tuple[Row, ...]
    steps: tuple[Step, ...]
    remaining: tuple[tuple[int, tuple[tuple[int, Node], ...]], ...]
    origins: tuple[frozenset[int], ...]
    watched: tuple[tuple[Node, int], ...]  # parameter node divided by, row


def level_of(members: BondClass, ports: Sequence[ElementPort]) -> int:
    """The place of a class in the order of elimination."""
    return max((_LEVELS[ports[k].role] for k in members.ports), default=0)


def eliminate(
    dag: Dag, fingerprints: Fingerprints, certifier: Certifier, structure: Structure
) -> Elimination:
    """Solve the rows for as many classes as certified pivots allow, the best first."""
    work = _Work(dag, fingerprints, certifier, structure)
    work.run()
    return work.result()


@dataclass(slots=True)
class _Form:
    """A linear form in the classes; a row is one that has to be zero."""

    entries: dict[int, Node]
    factors: dict[int, Node]  # of the steps' working rows that were taken from it


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
        self._forms: list[_Form] = []  # of rows
        self._where: list[set[int]] = [set() for _ in structure.classes]  # open rows with a class
        self._followers = [0] * len(structure.classes)  # steps whose working row has a class
        self._open: set[int] = set()
        self._steps: list[Step] = []
        self._watched: list[tuple[Node, int]] = []
        self._blocks: dict[int, _OpenBlock] = {
            k: _OpenBlock(block, self) for k, block in enumerate(structure.blocks)
        }
        self._queue: list[tuple[tuple[int, int, int], int]] = []
        for row in structure.rows:
            self._add_row(row)
        for number in range(len(structure.classes)):
            self._enqueue(number)

    def run(self) -> None:
        """Take the best pivot until there is none; then turn the next block, and go on."""
        while True:
            pivot = self._next_pivot()
            level = self._levels[pivot[0]] if pivot else _NEVER
            turned = self._turn_block(level)
            if turned:
                if pivot:
                    self._enqueue(pivot[0])
            elif pivot:
                self._solve(*pivot)
            else:
                return

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

    def _candidate(self, number: int) -> tuple[tuple[int, int, int], int] | None:
        """The key of a class in the order of elimination, and its best row."""
        level = self._levels[number]
        if level == _NEVER:
            return None
        best = None
        for row in self._where[number]:
            entries = self._forms[row].entries
            certificate = self._certifier.certify(entries[number])
            if certificate is not None:
                key = (certificate.rank, len(entries), row)
                best = key if best is None else min(best, key)
        if best is None:
            return None
        return (level, best[0], len(self._where[number]) + self._followers[number]), best[2]

    def _enqueue(self, number: int) -> None:
        candidate = self._candidate(number)
        if candidate is not None:
            heapq.heappush(self._queue, (candidate[0], number))

    def _next_pivot(self) -> tuple[int, int] | None:
        """The best class and its row; entries of the heap may be out of date."""
        while self._queue:
            key, number = heapq.heappop(self._queue)
            candidate = self._candidate(number)
            if candidate is None:
                continue
            if candidate[0] > key:
                heapq.heappush(self._queue, (candidate[0], number))
                continue
            return number, candidate[1]
        return None

    def _solve(self, number: int, row: int) -> None:
        """Make a class dependent by a row and take the row from all others."""
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
            for changed in before - set(target.entries):
                self._where[changed].discard(other_row)
            for changed in set(target.entries) - before:
                self._where[changed].add(other_row)
        for block in self._blocks.values():
            for target in block.forms_with(number):
                self._subtract(target, number, row, form, pivot)
                block.stale = True
        step = Step(row, number, tuple(form.entries.items()), tuple(form.factors.items()))
        self._steps.append(step)
        for other in form.entries:
            if other != number:
                self._followers[other] += 1
                self._enqueue(other)

    def _subtract(self, target: _Form, number: int, row: int, source: _Form, pivot: Node) -> None:
        dag = self._dag
        factor = dag.div(target.entries.pop(number), pivot)
        target.factors[row] = factor
        for other, entry in source.entries.items():
            if other != number:
                taken = dag.sub(target.entries.get(other, dag.zero), dag.mul(factor, entry))
                self._set(target.entries, other, taken)

    def _set(self, entries: dict[int, Node], number: int, node: Node) -> None:
        """Set an entry, or remove it where it is always zero."""
        value = self._fingerprints.constant(node)
        if value is not None:
            node = self._dag.const(value)
        if node == self._dag.zero:
            entries.pop(number, None)
        else:
            entries[number] = node

    # --- rows and blocks -------------------------------------------------------------------

    def form_of(self, terms: Iterable[tuple[_Form, Node]]) -> _Form:
        """A weighted sum of forms."""
        dag = self._dag
        entries: dict[int, Node] = {}
        factors: dict[int, Node] = {}
        for form, weight in terms:
            for number, entry in form.entries.items():
                sum_ = dag.add(entries.get(number, dag.zero), dag.mul(weight, entry))
                self._set(entries, number, sum_)
            for row, factor in form.factors.items():
                factors[row] = dag.add(factors.get(row, dag.zero), dag.mul(weight, factor))
        return _Form(entries, factors)

    def unit_form(self, bond: int) -> _Form:
        """The through variable of a bond."""
        return _Form({self._class_of[bond]: self._dag.one}, {})

    def _add_row(self, row: Row, form: _Form | None = None) -> None:
        if form is None:
            form = self.form_of((self.unit_form(e.bond), e.coefficient) for e in row.ends)
        index = len(self._rows)
        self._rows.append(row)
        self._forms.append(form)
        self._open.add(index)
        for number in form.entries:
            self._where[number].add(index)

    def _turn_block(self, level: int) -> bool:
        """Write one block as rows: the first whose one side can go at this level, or any."""
        for key, block in self._blocks.items():
            if block.stale:
                block.assess(self._pivot_level)
            if min(block.levels) <= min(level, _NEVER - 1):
                self._write(key, block.levels[1] < block.levels[0])
                return True
        if level == _NEVER and self._blocks:
            self._write(next(iter(self._blocks)), backward=False)
            return True
        return False

    def _write(self, key: int, backward: bool) -> None:
        block = self._blocks.pop(key)
        for row in block.block.backward if backward else block.block.forward:
            terms = ((block.forms[end.bond], end.coefficient) for end in row.ends)
            self._add_row(row, self.form_of(terms))
            for number in self._forms[-1].entries:
                self._enqueue(number)

    def _pivot_level(self, number: int, entry: Node) -> int:
        return self._levels[number] if self._certifier.certify(entry) is not None else _NEVER


class _OpenBlock:
    """A block not yet written as rows: a form for each of its bonds.

    `levels` says at which level the rows written forward and backward can be solved for the
    bonds on their left side alone.
    """

    def __init__(self, block: Block, work: _Work) -> None:
        self.block = block
        self.stale = True
        self.levels = (_NEVER, _NEVER)
        bonds = [end.bond for row in (*block.forward, *block.backward) for end in row.ends]
        self.forms = {bond: work.unit_form(bond) for bond in dict.fromkeys(bonds)}

    def forms_with(self, number: int) -> list[_Form]:
        """The forms that hold a class."""
        return [form for form in self.forms.values() if number in form.entries]

    def assess(self, pivot_level: PivotLevel) -> None:
        """Find the levels again after a form has changed."""
        sides = (self.block.forward, self.block.backward)
        forward, backward = (
            self._side_level([row.ends[0].bond for row in rows], pivot_level) for rows in sides
        )
        self.levels = (forward, backward)
        self.stale = False

    def _side_level(self, bonds: Sequence[int], pivot_level: PivotLevel) -> int:
        """The level at which each form of a side has a class of its own to be solved for."""
        others = {
            number
            for bond, form in self.forms.items()
            if bond not in bonds
            for number in form.entries
        }
        taken: set[int] = set()
        highest = 0
        for bond in bonds:
            entries = self.forms[bond].entries
            free = [
                (pivot_level(number, entry), number)
                for number, entry in entries.items()
                if number not in taken and number not in others
            ]
            level, number = min(free, default=(_NEVER, -1))
            taken.add(number)
            highest = max(highest, level)
        return highest
