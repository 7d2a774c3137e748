"""The rows of a junction structure while they are solved for one class after the other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from bgc.algebra.dag import Dag, Level
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.certificates import Certifier, Size
from bgc.causality.regions import Block, Structure
from bgc.causality.rotations import Inverse, known_inverse
from bgc.causality.sizes import typical_sizes
from bgc.ir.causal import BondClass, ElementPort, Role, Row, RowEnd, Step
from bgc.ir.graph import Node
from bgc.record_class import dataclass

_LEVELS = {
    Role.EFFORT_SOURCE: 1,
    Role.COMPLIANCE: 2,
    Role.RESISTANCE: 3,
    Role.INERTIA: 5,
    Role.FLOW_SOURCE: 7,
}
BARE = 0  # level of classes without an element
CARRYING = 4  # of those that move an inertia, by a modulus that may vanish, where asked for
READ = 6  # of inertias that a modulus reads: it is known where their states are
EFFORT_SOURCE, COMPLIANCE, RESISTANCE, INERTIA, FLOW_SOURCE = _LEVELS.values()


@dataclass(frozen=True, slots=True)
class Elimination:
    """The result of an elimination.

    `rows` are the rows of the structure, inverted blocks replaced. `remaining` are the rows without
    a certified pivot at a class that may be dependent, with their remaining entries; one without
    entries is redundant. `origins[r]` are the rows that the working row of row r combines.
    `weakest` is the smallest pivot beside the largest constant entry of its row, each times the
    typical size of its class: its inverse bounds how far an entry of N can grow by one step.
    """

    rows: tuple[Row, ...]
    steps: tuple[Step, ...]
    remaining: tuple[tuple[int, tuple[tuple[int, Node], ...]], ...]
    origins: tuple[frozenset[int], ...]
    watched: tuple[tuple[Node, int], ...]  # node of PARAM level used as pivot, row
    weakest: float

    @property
    def unsolved(self) -> int:
        """The number of remaining rows that are not redundant."""
        return sum(bool(left) for _, left in self.remaining)


def level_of(members: BondClass, ports: Sequence[ElementPort]) -> int:
    """The level of a class in the order of elimination, by its elements."""
    return max((_LEVELS[ports[k].role] for k in members.ports), default=BARE)


@dataclass(slots=True)
class _Form:
    """A linear form in the through variables of classes; each row sets one to zero."""

    entries: dict[int, Node]
    factors: dict[int, Node]  # row -> multiple of its working row that was subtracted


class WorkingRows:
    """Rows with the solved classes eliminated, and the steps that solved them.

    `levels` are those of the classes, `open` the rows not solved yet, `changed` the open rows that
    changed since the caller emptied the set.
    """

    def __init__(
        self,
        dag: Dag,
        fingerprints: Fingerprints,
        certifier: Certifier,
        structure: Structure,
        carrying: Collection[int] = (),
    ) -> None:
        self._dag = dag
        self._fingerprints = fingerprints
        self._certifier = certifier
        self._class_of = structure.class_of
        self.levels = [level_of(c, structure.ports) for c in structure.classes]
        for number in carrying:
            self.levels[number] = max(self.levels[number], CARRYING)
        for number in structure.read:
            if self.levels[number] == INERTIA:
                self.levels[number] = READ
        self._rows: list[Row] = []
        self._forms: list[_Form] = []  # working row of each row
        self._where: list[set[int]] = [set() for _ in structure.classes]  # open rows with a class
        self.open: set[int] = set()
        self.changed: set[int] = set()
        self._steps: list[Step] = []
        self._watched: list[tuple[Node, int]] = []
        self._weakest = 1.0
        self._sizes = typical_sizes(dag, certifier, structure.class_of, structure.rows)
        for row in structure.rows:
            terms = [(self._unit_form(end.bond), end.coefficient) for end in row.ends]
            self._rows.append(row)
            self._forms.append(_Form({}, {}))
            self._set_form(len(self._rows) - 1, self._combined(terms))

    def entries(self, row: int) -> Mapping[int, Node]:
        """The entries of a working row, by class."""
        return self._forms[row].entries

    def rows_with(self, number: int) -> set[int]:
        """The open rows with a class."""
        return self._where[number]

    def close(self, rows: Sequence[Row], following: Collection[int]) -> None:
        """Add rows that close chains, and solve them for the classes in `following` if possible."""
        added = range(len(self._rows), len(self._rows) + len(rows))
        for number, row in zip(added, rows, strict=True):
            form = self._combined((self._unit_form(end.bond), end.coefficient) for end in row.ends)
            for step in self._steps:
                if step.dependent in form.entries:
                    source = self._forms[step.row]
                    pivot = source.entries[step.dependent]
                    self._subtract(form, step.dependent, step.row, source, pivot)
            self._rows.append(row)
            self._forms.append(_Form({}, {}))
            self._set_form(number, form)
        while pivots := [
            pivot
            for number in added
            if number in self.open
            for pivot in self._constant_pivots(number, following)
        ]:
            *_, solved, number = min(pivots)
            self.solve(solved, number)

    def _constant_pivots(
        self, row: int, classes: Collection[int]
    ) -> Iterator[tuple[Size, float, int, int]]:
        """The pivots of a row at some classes that do not vary, the best one least."""
        entries = self.entries(row)
        for number in sorted(entries.keys() & classes):
            if self._dag.level[entries[number]] <= Level.PARAM:
                size = self._certifier.size_in(entries[number], entries.values())
                if size is not None:
                    yield size, -abs(self._certifier.default(entries[number])), number, row

    def result(self) -> Elimination:
        """The steps so far, and the rows that are left."""
        origins: list[frozenset[int]] = [frozenset()] * len(self._rows)
        order = [step.row for step in self._steps] + sorted(self.open)
        for row in order:
            used = (origins[r] for r in self._forms[row].factors)
            origins[row] = frozenset({row}).union(*used)
        remaining = tuple((r, tuple(self._forms[r].entries.items())) for r in sorted(self.open))
        return Elimination(
            rows=tuple(self._rows),
            steps=tuple(self._steps),
            remaining=remaining,
            origins=tuple(origins),
            watched=tuple(self._watched),
            weakest=self._weakest,
        )

    # --- steps ----------------------------------------------------------------------------

    def _share(self, number: int, entries: Mapping[int, Node]) -> float:
        """The ratio of an entry to the largest of its row that does not vary.

        Each counts with the typical size of its class. The unit of a class does not matter then.
        """
        if self._dag.level[entries[number]] > Level.PARAM:
            return 1.0
        steady = (
            abs(self._certifier.default(node)) * self._sizes[other]
            for other, node in entries.items()
            if self._dag.level[node] <= Level.PARAM
        )
        return abs(self._certifier.default(entries[number])) * self._sizes[number] / max(steady)

    def solve(self, number: int, row: int) -> None:
        """Make a class dependent by a row, and eliminate it from all other rows."""
        form = self._forms[row]
        pivot = form.entries[number]
        certificate = self._certifier.certify(pivot)
        assert certificate is not None
        self._watched.extend((node, row) for node in certificate.watched)
        self._weakest = min(self._weakest, self._share(number, form.entries))
        self.open.remove(row)
        for other in form.entries:
            self._where[other].discard(row)
        for other_row in sorted(self._where[number]):
            target = self._forms[other_row]
            before = set(target.entries)
            self._subtract(target, number, row, form, pivot)
            self.changed.add(other_row)
            for changed in before - set(target.entries):
                self._where[changed].discard(other_row)
            for changed in set(target.entries) - before:
                self._where[changed].add(other_row)
        step = Step(row, number, tuple(form.entries.items()), tuple(form.factors.items()))
        self._steps.append(step)

    def invert(self, block: Block, below: int) -> set[int] | None:
        """Solve the open rows of a block for its lower bonds, if its inverse is known.

        Returns the classes of the new rows. Returns None and changes nothing if the inverse is
        unknown, or if the rows can then not be solved for classes below a level.
        """
        rows = [row for row in block.rows if row in self.open]
        inverse = self._inverse_of(block, rows)
        if inverse is None:
            return None
        weights = [list(map(self._dag.neg, line)) for line in inverse.matrix]
        solved = [
            self._combined((self._forms[row], w) for row, w in zip(rows, line, strict=True))
            for line in weights
        ]
        if not self._has_pivots([form.entries for form in solved], below):
            return None
        raw = [self._combined_row([self._rows[row] for row in rows], w) for w in weights]
        for row, line, form in zip(rows, raw, solved, strict=True):
            self._rows[row] = line
            self._set_form(row, form)
        certificates = map(self._certifier.certify, inverse.divisors)
        self._watched += [(node, rows[0]) for c in certificates if c for node in c.watched]
        return {number for form in solved for number in form.entries}

    def has_pivots(self, rows: Iterable[int], below: int) -> bool:
        """Test whether rows can be solved, one after the other, for classes below a level."""
        return self._has_pivots([self._forms[row].entries for row in rows], below)

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

    # --- rows and blocks ------------------------------------------------------------------

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
        self.open.add(row)
        self.changed.add(row)
        for number in form.entries:
            self._where[number].add(row)

    def _inverse_of(self, block: Block, rows: Sequence[int]) -> Inverse | None:
        """The factor that solves the open rows of a block for its lower bonds; None if unknown.

        Lower bonds that earlier rows were solved for are left out.
        """
        taken = {step.dependent for step in self._steps if step.row in block.rows}
        columns = [j for j, bond in enumerate(block.lower) if self._class_of[bond] not in taken]
        positions = [block.rows.index(row) for row in rows]
        if not rows or len(columns) != len(rows):
            return None
        if block.inverse and len(rows) == len(block.rows):
            return Inverse(block.inverse)
        part = tuple(tuple(block.matrix[i][j] for j in columns) for i in positions)
        inverse = known_inverse(self._dag, self._fingerprints, part)
        if inverse is None or any(map(self._certifier.may_vanish, inverse.divisors)):
            return None
        return inverse

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

    def _has_pivots(self, forms: Sequence[Mapping[int, Node]], below: int) -> bool:
        left = [dict(form) for form in forms]
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
            if self.levels[number] < below and self._certifier.certify(entry) is not None
        )
        best = min(candidates, default=None)
        return best and best[1:]
