"""Free motions: directions of flow that no source, inertia or resistance determines.

Such a motion moves only compliances, and momenta that gyrators push. The power balance on it does
not contain the speed of any motion: it is a condition on the stored quantities and the sources, and
the speed of the motion follows from keeping that condition. There are two kinds of free motion. One
is an independent flow that only compliances determine. The other is a direction that the gyrators
of an odd loop, which cannot be made transformers, leave undetermined; a skew matrix of odd size
always has one.

With `u` the flows of kind resistance and `a` the efforts at ports whose law gives the flow, the
resistive equations have the matrix `S = [[N' G N, N'], [-N, Y]]`, G and Y skew plus positive
semidefinite. S and its transpose have the same kernel, and a vector in it moves no resistance. The
motions therefore follow from the skew parts, and from rows that set resistive flows to zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.disjoint_sets import DisjointSets
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.modular import rank_of
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.records import dataclass
from bgc.equations.storage.kinds import own_flow
from bgc.equations.variables.definitions import Column, Variables
from bgc.equations.variables.law_nodes import gyrator_matrix
from bgc.ir.causal import BasisKind, CausalGraph, Role
from bgc.ir.graph import Form, Gyrator, Gyristor, LinearLaw, Matrix, Node, Resistor, Source

_Row: TypeAlias = dict[Column, Node]


@dataclass(frozen=True, slots=True)
class Motion:
    """A direction of free motion.

    `flows` are its entries over the independent flows, `efforts` over the ports whose law gives
    the through variable (their across variables, in the element's sense). `pushes` are what a
    unit of the motion adds to the balance of the other independent flows, as a rate of momentum.
    """

    flows: dict[int, Node]
    efforts: dict[int, Node]
    pushes: dict[int, Node]

    def weighted(self, dag: Dag, weight: Node) -> Motion:
        """The motion times a factor."""
        parts = (self.flows, self.efforts, self.pushes)
        return Motion(*({k: dag.mul(x, weight) for k, x in part.items()} for part in parts))

    def less(self, dag: Dag, fingerprints: Fingerprints, other: Motion, weight: Node) -> Motion:
        """The motion minus a factor times another."""
        mine = (self.flows, self.efforts, self.pushes)
        theirs = (other.flows, other.efforts, other.pushes)
        found = []
        for part, taken in zip(mine, theirs, strict=True):
            entries = dict(part)
            for k, node in taken.items():
                left = dag.sub(entries.get(k, dag.zero), dag.mul(weight, node))
                entries[k] = left
            found.append({k: x for k, x in entries.items() if not fingerprints.is_zero(x)})
        return Motion(*found)


@dataclass(frozen=True, slots=True)
class FreeMotions:
    """All free motions, each with the unknown that represents it in the resistive equations."""

    motions: tuple[Motion, ...]
    dependent: tuple[Column, ...]


def free_motions(variables: Variables) -> FreeMotions:
    """The free motions of a graph, those of flows that only compliances determine first.

    Raises
    ------
    BgError
        A motion could only be found by dividing by a modulus that may vanish.
    """
    one = variables.dag.one
    motions: list[Motion] = []
    dependent: list[Column] = []
    for k, basis in enumerate(variables.causal.basis):
        if basis.kind is BasisKind.COMPLIANCE:
            motions.append(Motion({k: one}, {}, {}))
            dependent.append(("flow", k))
    search = _Search(variables)
    for column, entries in search.kernel().items():
        motions.append(search.motion(entries))
        dependent.append(column)
    return FreeMotions(tuple(motions), tuple(dependent))


@dataclass(frozen=True, slots=True)
class _Block:
    """A skew law of some ports: across = matrix * through, or the other way round."""

    ports: tuple[int, ...]
    matrix: Matrix
    gives_through: bool


class _Search:
    def __init__(self, variables: Variables) -> None:
        self._variables = variables
        self._causal: CausalGraph = variables.causal
        self._dag: Dag = variables.dag
        self._fingerprints = variables.causal.fingerprints
        self._resistive = frozenset(
            k for k, b in enumerate(self._causal.basis) if b.kind is BasisKind.RESISTANCE
        )
        self._flow: dict[int, dict[int, Node]] = {}  # port -> its row of N, element's sense
        self._skew: list[_Block] = []
        self._still: list[_Row] = []  # rows that set the flows through resistances to zero
        for index, members in variables.index.ports_of_element.items():
            self._enter(index, members)

    def _enter(self, index: int, members: Sequence[int]) -> None:
        """Split an element's law into its skew part and the directions that must be at rest."""
        causal, dag = self._causal, self._dag
        element = causal.graph.elements[index]
        for k in members:
            self._flow[k] = own_flow(causal, causal.ports[k])
        dual = causal.ports[members[0]].dual
        match element:
            case Gyrator():
                matrix = gyrator_matrix(dag, element)
                places = [causal.ports[k].position for k in members]
                part = tuple(tuple(matrix[i][j] for j in places) for i in places)
                self._skew.append(_Block(tuple(members), part, dual))
            case Gyristor(matrix=matrix):
                self._skew.append(_Block(tuple(members), matrix, dual))
            case Resistor(law=LinearLaw(form=form, matrix=matrix)):
                self._enter_resistance(members, matrix, (form is Form.FLOW) != dual)
            case Resistor():
                self._keep_still(members)
            case Source() if self._is_resistance(element, members[0]):
                self._keep_still(members)
            case _:
                pass

    def _enter_resistance(
        self, members: Sequence[int], matrix: Matrix, gives_through: bool
    ) -> None:
        """A linear resistance moves only as its symmetric part allows."""
        dag, half, size = self._dag, self._dag.const(Fraction(1, 2)), range(len(matrix))
        sums = [
            {j: x for j in size if (x := self._half_sum(matrix, i, j)) != dag.zero} for i in size
        ]
        numbers = [{j: self._residue(x) for j, x in row.items()} for row in sums]
        if rank_of(numbers) == len(matrix):
            self._keep_still(members)
            return
        skew = tuple(
            tuple(dag.mul(half, dag.sub(matrix[i][j], matrix[j][i])) for j in size) for i in size
        )
        self._skew.append(_Block(tuple(members), skew, gives_through))
        for row in sums:
            moved: _Row = {}
            for j, weight in row.items():
                if gives_through:
                    moved["port", members[j]] = weight
                else:
                    self._take(moved, self._flow[members[j]], weight)
            self._still.append(moved)

    def _half_sum(self, matrix: Matrix, i: int, j: int) -> Node:
        dag = self._dag
        return dag.mul(dag.const(Fraction(1, 2)), dag.add(matrix[i][j], matrix[j][i]))

    def _keep_still(self, members: Sequence[int]) -> None:
        """No flow through a resistance takes part in a motion, so no effort at it either."""
        for k in members:
            row: _Row = {}
            self._take(row, self._flow[k], self._dag.one)
            self._still.append(row)

    def _take(self, row: _Row, flow: Mapping[int, Node], weight: Node) -> None:
        """Add a weight times a row of N, of its resistive flows, to a row."""
        dag = self._dag
        for k, entry in flow.items():
            if k in self._resistive:
                column = ("flow", k)
                row[column] = dag.add(row.get(column, dag.zero), dag.mul(weight, entry))

    def _is_resistance(self, source: Source, port: int) -> bool:
        """Return whether the value of a source depends on its own bond's other variable."""
        causal, dag = self._causal, self._dag
        if source.follows:
            return True
        if causal.ports[port].role is not Role.EFFORT_SOURCE:
            return False
        if dag.level[source.value] < Level.STATE:
            return False
        own = self._resistive.intersection(self._flow[port])
        for symbol in map(dag.symbol_of, dag.reachable([source.value])):
            if symbol is not None and symbol.kind in {Kind.EFFORT, Kind.FLOW}:
                through = (symbol.kind is Kind.EFFORT) == causal.dual[symbol.index]
                moved = dict(causal.flows[causal.class_of[symbol.index]])
                if through and not own.isdisjoint(moved):
                    return True
        return False

    # --- the equations of free motion ---------------------------------------------------------

    def _rows(self) -> list[_Row]:
        """The rows of `S (z, a) = 0` for the skew parts, and of zero flow through resistances."""
        dag = self._dag
        balance: dict[int, _Row] = {k: {} for k in self._resistive}
        rows: list[_Row] = list(self._still)
        for block in self._skew:
            for i, port in enumerate(block.ports):
                given: _Row = {}  # the across variable, or the law's through variable
                for j, entry in enumerate(block.matrix[i]):
                    if entry != dag.zero and block.gives_through:
                        given["port", block.ports[j]] = entry
                    elif entry != dag.zero:
                        self._take(given, self._flow[block.ports[j]], entry)
                if block.gives_through:
                    self._take(given, self._flow[port], dag.const(-1))
                    rows.append(given)
                    given = {("port", port): dag.one}
                for k, weight in self._flow[port].items():
                    if k in self._resistive:
                        self._add(balance[k], given, weight)
        rows.extend(balance[k] for k in sorted(balance))
        kept = [
            {column: x for column, x in row.items() if not self._fingerprints.is_zero(x)}
            for row in rows
        ]
        return [row for row in kept if row]

    def _add(self, row: _Row, other: _Row, weight: Node) -> None:
        dag = self._dag
        for column, entry in other.items():
            row[column] = dag.add(row.get(column, dag.zero), dag.mul(weight, entry))

    def motion(self, entries: Mapping[Column, Node]) -> Motion:
        """A motion with what it pushes."""
        dag = self._dag
        flows = {k: x for (what, k), x in entries.items() if what == "flow"}
        efforts = {k: x for (what, k), x in entries.items() if what == "port"}
        pushes: dict[int, Node] = {}
        for block in self._skew:
            for i, port in enumerate(block.ports):
                if block.gives_through:
                    across = efforts.get(port, dag.zero)
                else:
                    moved = (self._moved(block.ports[j], flows) for j in range(len(block.ports)))
                    across = dag.dot(block.matrix[i], moved)
                for k, weight in self._flow[port].items():
                    if k not in self._resistive:
                        taken = dag.mul(weight, across)
                        pushes[k] = dag.sub(pushes.get(k, dag.zero), taken)
        is_zero = self._fingerprints.is_zero
        return Motion(flows, efforts, {k: x for k, x in pushes.items() if not is_zero(x)})

    def _moved(self, port: int, flows: Mapping[int, Node]) -> Node:
        dag, row = self._dag, self._flow[port]
        return dag.sum(dag.mul(row[k], x) for k, x in flows.items() if k in row)

    # --- their solutions ------------------------------------------------------------------------

    def kernel(self) -> dict[Column, _Row]:
        """A basis of the solutions: for each its free unknown and all its entries."""
        found: dict[Column, _Row] = {}
        open_flows = set(self._resistive)
        open_ports = {k for b in self._skew if b.gives_through for k in b.ports}
        for rows in _connected(self._rows()):
            columns = {column for row in rows for column in row}
            open_flows -= {k for what, k in columns if what == "flow"}
            open_ports -= {k for what, k in columns if what == "port"}
            numbers = [{c: self._residue(x) for c, x in row.items()} for row in rows]
            rank = rank_of(numbers)
            if rank < len(columns):
                found |= self._solve(rows, columns, rank)
        free = [*(("flow", k) for k in open_flows), *(("port", k) for k in open_ports)]
        return found | {column: {column: self._dag.one} for column in sorted(free)}

    def _residue(self, node: Node) -> int:
        return self._fingerprints.residue(node)

    def _solve(self, rows: list[_Row], columns: set[Column], rank: int) -> dict[Column, _Row]:
        """Solve the rows with certified pivots, each for one unknown."""
        dag, is_zero = self._dag, self._fingerprints.is_zero
        open_rows, solved = [dict(row) for row in rows], dict[Column, _Row]()
        while len(solved) < rank:
            candidates = [
                (certificate.rank, len(row), i, column)
                for i, row in enumerate(open_rows)
                for column, entry in row.items()
                if (certificate := self._variables.certificate(entry)) is not None
            ]
            if not candidates:
                raise self._refused(columns)
            _, _, i, column = min(candidates)
            row = open_rows.pop(i)
            pivot = row.pop(column)
            self._variables.may_divide(pivot, "the modulus of a gyrator must not be zero")
            solution = {c: dag.neg(dag.div(x, pivot)) for c, x in row.items()}
            for other in (*open_rows, *solved.values()):
                if column in other:
                    self._add(other, solution, other.pop(column))
                    for c in [c for c, x in other.items() if is_zero(x)]:
                        del other[c]
            open_rows = [other for other in open_rows if other]
            solved[column] = solution
        free = sorted(columns - set(solved))
        return {
            column: {column: dag.one}
            | {c: row[column] for c, row in solved.items() if column in row}
            for column in free
        }

    def _refused(self, columns: set[Column]) -> BgError:
        """An error that names the gyrators on the unknowns, or else the storage there."""
        causal = self._causal
        flows = {k for what, k in columns if what == "flow"}
        gyrators, bonds = [], []
        for block in self._skew:
            for port in block.ports:
                if ("port", port) in columns or not flows.isdisjoint(self._flow[port]):
                    gyrators.append(causal.ports[port].element)
                    bonds.append(causal.graph.bonds[causal.ports[port].bond].name)
        if not gyrators:
            return self._held_by_moduli(flows)
        return self._variables.places.odd_loop(gyrators, list(dict.fromkeys(bonds)))

    def _held_by_moduli(self, flows: set[int]) -> BgError:
        """An error that names the compliances, or whatever there is, on some flows."""
        causal = self._causal
        on_flows = [port for port in causal.ports if not flows.isdisjoint(own_flow(causal, port))]
        compliances = [port for port in on_flows if port.role is Role.COMPLIANCE]
        found = {port.element for port in compliances or on_flows}
        first, *others = (causal.graph.elements[k] for k in sorted(found))
        why = "the modulus that joins them may become zero"
        names = [element.name for element in others]
        return BgError([storage_messages.dependent_storage(first.span, first.name, names, why)])


def _connected(rows: Sequence[_Row]) -> Iterator[list[_Row]]:
    """Rows in groups that share no column."""
    numbers: dict[Column, int] = {}
    for row in rows:
        for column in row:
            numbers.setdefault(column, len(numbers))
    sets = DisjointSets(len(numbers))
    for row in rows:
        sets.join(numbers[column] for column in row)
    groups: dict[int, list[_Row]] = {}
    for row in rows:
        groups.setdefault(sets.find(numbers[next(iter(row))]), []).append(row)
    yield from groups.values()
