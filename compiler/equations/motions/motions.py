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

from collections.abc import Mapping, Sequence
from fractions import Fraction

from bgc.algebra.dag import Dag
from bgc.algebra.disjoint_sets import groups_sharing
from bgc.algebra.modular import rank_of
from bgc.algebra.reduction import Reduction
from bgc.causality.assign import columns_in_value
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.storage.kinds import own_flow
from bgc.equations.variables.definitions import Column, Row, Variables
from bgc.equations.variables.law_nodes import gyrator_matrix
from bgc.ir.causal import BasisKind, CausalGraph, Role
from bgc.ir.graph import Form, Gyrator, Gyristor, LinearLaw, Matrix, Node, Resistor, Source
from bgc.record_class import dataclass


def part_of(motion: Mapping[Column, Node], kind: str) -> dict[int, Node]:
    """The entries of a motion in the columns of a kind, by their numbers."""
    return {k: node for (what, k), node in motion.items() if what == kind}


def free_motions(variables: Variables) -> dict[Column, Row]:
    """The free motions of a graph, those of flows that only compliances determine first.

    Each is found by the unknown that represents it in the resistive equations, and has entries
    ("flow", k) over the independent flows, ("port", k) over the ports whose law gives the through
    variable (their across variables, in the element's sense), and ("push", k): what a unit of the
    motion adds to the balance of another independent flow, as a rate of momentum.

    Raises
    ------
    BgError
        A motion could only be found by dividing by a modulus that may vanish.
    """
    search = _Search(variables)
    motions: dict[Column, Row] = {
        ("flow", k): {("flow", k): variables.dag.one}
        for k, basis in enumerate(variables.causal.basis)
        if basis.kind is BasisKind.COMPLIANCE
    }
    return motions | {c: search.motion(entries) for c, entries in search.kernel().items()}


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
        self._flows = [dict(entries) for entries in self._causal.flows]  # rows of N
        self._flow: dict[int, dict[int, Node]] = {}  # port -> its row of N, element's sense
        self._skew: list[_Block] = []
        self._still: list[Row] = []  # rows that set the flows through resistances to zero
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
            moved: Row = {}
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
            row: Row = {}
            self._take(row, self._flow[k], self._dag.one)
            self._still.append(row)

    def _take(self, row: Row, flow: Mapping[int, Node], weight: Node) -> None:
        """Add a weight times a row of N, of its resistive flows, to a row."""
        dag = self._dag
        for k, entry in flow.items():
            if k in self._resistive:
                column = ("flow", k)
                row[column] = dag.add(row.get(column, dag.zero), dag.mul(weight, entry))

    def _is_resistance(self, source: Source, port: int) -> bool:
        """Return whether the value of a source depends on its own bond's other variable."""
        causal = self._causal
        own = self._resistive.intersection(self._flow[port])
        read = columns_in_value(causal.graph, causal, causal.ports[port], self._flows)
        return source.follows or not own.isdisjoint(read)

    # --- the equations of free motion ---------------------------------------------------------

    def _rows(self) -> list[Row]:
        """The rows of `S (z, a) = 0` for the skew parts, and of zero flow through resistances."""
        dag = self._dag
        balance: dict[int, Row] = {k: {} for k in self._resistive}
        rows: list[Row] = list(self._still)
        for block in self._skew:
            for i, port in enumerate(block.ports):
                given: Row = {}  # the across variable, or the law's through variable
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

    def _add(self, row: Row, other: Row, weight: Node) -> None:
        dag = self._dag
        for column, entry in other.items():
            row[column] = dag.add(row.get(column, dag.zero), dag.mul(weight, entry))

    def motion(self, entries: Row) -> Row:
        """A motion with what it pushes."""
        dag = self._dag
        flows, efforts = part_of(entries, "flow"), part_of(entries, "port")
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
        return entries | {("push", k): node for k, node in pushes.items()}

    def _moved(self, port: int, flows: Mapping[int, Node]) -> Node:
        dag, row = self._dag, self._flow[port]
        return dag.sum(dag.mul(row[k], x) for k, x in flows.items() if k in row)

    # --- their solutions ------------------------------------------------------------------------

    def kernel(self) -> dict[Column, Row]:
        """A basis of the solutions: for each its free unknown and all its entries."""
        found: dict[Column, Row] = {}
        open_flows = set(self._resistive)
        open_ports = {k for b in self._skew if b.gives_through for k in b.ports}
        every = self._rows()
        for group in groups_sharing(every):
            rows = [every[i] for i in group]
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

    def _solve(self, rows: list[Row], columns: set[Column], rank: int) -> dict[Column, Row]:
        """Solve the rows with certified pivots, each for one unknown."""
        reduction, solved = Reduction(self._dag, self._fingerprints, rows), dict[Column, int]()
        while len(solved) < rank:
            candidates = [
                (certificate.rank, len(row), i, column)
                for i, row in enumerate(reduction.rows)
                if i not in solved.values()
                for column, entry in row.items()
                if (certificate := self._variables.certificate(entry)) is not None
            ]
            if not candidates:
                raise self._refused(columns)
            *_, i, column = min(candidates)
            pivot = reduction.rows[i][column]
            self._variables.may_divide(pivot, "the modulus of a gyrator must not be zero")
            reduction.eliminate(i, column)
            solved[column] = i
        return {
            free: {free: self._dag.one}
            | {
                column: self._dag.neg(reduction.rows[i][free])
                for column, i in solved.items()
                if free in reduction.rows[i]
            }
            for free in sorted(columns - set(solved))
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
