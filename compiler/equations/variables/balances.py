"""Across variables: those that elements give, and those that follow from the balances.

N' across = 0 is never written out: the multipliers of the elimination's rows carry the across
variables from class to class, one product for each entry of the working rows.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from enum import Enum

from bgc.equations.variables.raw_symbols import Symbols
from bgc.equations.variables.variable_names import Places
from bgc.ir.causal import CausalGraph, Role
from bgc.ir.graph import Junction, Node


class CausalIndex:
    """A causal graph's ports, rows and steps, by what they meet."""

    def __init__(self, causal: CausalGraph) -> None:
        self.ports_of_element: dict[int, list[int]] = {}
        self.port_at: dict[tuple[int, int], int] = {}  # (bond, sign) -> element port
        for k, port in enumerate(causal.ports):
            self.ports_of_element.setdefault(port.element, []).append(k)
            self.port_at[port.bond, port.sign] = k
        self.row_ends: dict[tuple[int, int], list[tuple[int, Node]]] = {}
        for index, row in enumerate(causal.rows):
            for end in row.ends:
                self.row_ends.setdefault((end.bond, end.sign), []).append((index, end.coefficient))
        self.junction_at = {
            (port.bond, port.sign): index
            for index, element in enumerate(causal.graph.elements)
            if isinstance(element, Junction)
            for port in element.ports
        }
        self.kind_of = {b.bond_class: b.kind for b in causal.basis}
        self.step_of = {step.dependent: k for k, step in enumerate(causal.steps)}
        self.steps_with: list[list[tuple[int, Node]]] = [[] for _ in causal.classes]
        for k, step in enumerate(causal.steps):
            for number, entry in step.working:
                self.steps_with[number].append((k, entry))


class _Share(Enum):
    """A contribution to a balance."""

    REST = "all but inertias and flow sources"
    TURNING = "the same, and the forces of moduli that turn momenta"
    REACTIONS = "all"


class Balances:
    """The across variables of a causal graph.

    `answers` are those that elements give (port -> node in the bond's sense); they have to be
    complete before a balance is asked for.
    """

    def __init__(
        self,
        causal: CausalGraph,
        index: CausalIndex,
        symbols: Symbols,
        places: Places,
        answers: Mapping[int, Node],
    ) -> None:
        self._causal = causal
        self._dag = causal.graph.dag
        self._index = index
        self._symbols = symbols
        self._places = places
        self._answers = answers
        self._forces: dict[_Share, list[Node]] = {}
        self.turning: Mapping[int, Node] = {}  # class -> force of moduli that turn momenta
        self.reacting: set[int] = set()  # ports of inertias that bear reactions of others
        self._multipliers: dict[int, Node] | None = None
        self._closing: dict[int, list[Node]] = {}  # class -> shares of closing rows
        self._closing_multipliers: dict[int, Node] = {}  # row -> its multiplier
        self._branches: dict[int, dict[int, int]] = {}  # class -> bond -> junction behind it

    def close(self, row: int, multiplier: Node) -> None:
        """Let a row that closes a chain act on the classes at its ends."""
        dag = self._dag
        self._closing_multipliers[row] = multiplier
        for end in self._causal.rows[row].ends:
            share = dag.mul(end.coefficient, multiplier)
            self._closing.setdefault(self._causal.class_of[end.bond], []).append(share)

    def across_of(self, bond: int) -> Node:
        """The across variable of a bond, from the end that determines it."""
        ends = ((bond, 1), (bond, -1))
        answer = self.answer_at(bond)
        if answer is not None:
            return answer
        for end in ends:
            answer = self._answer_beside(end)
            if answer is not None:
                return answer
        for end in ends:
            if end in self._index.port_at:
                return self.reaction(self._index.port_at[end])
        for end in ends:
            if end in self._index.row_ends:
                return self._at_row(end)
        if (bond, 1) in self._index.junction_at and (bond, -1) in self._index.junction_at:
            return self._between_junctions(bond)
        return self._dag.zero  # a side of a transformer that nothing is carried to

    def answer_at(self, bond: int) -> Node | None:
        """The across variable of a bond where an element answers with it."""
        for sign in (1, -1):
            port = self._index.port_at.get((bond, sign))
            if port is not None and port in self._answers:
                return self._answers[port]
        return None

    def _answer_beside(self, end: tuple[int, int]) -> Node | None:
        """At a summing junction, whose bonds share the across variable: that of another one."""
        for row_index, _ in self._index.row_ends.get(end, ()):
            row = self._causal.rows[row_index]
            if row.element in self._causal.cut:
                continue
            if isinstance(self._causal.graph.elements[row.element], Junction):
                for other in row.ends:
                    answer = self.answer_at(other.bond)
                    if answer is not None:
                        return answer
        return None

    def _at_row(self, end: tuple[int, int]) -> Node:
        """At a summing junction or transformer: what the rows' multipliers amount to."""
        multipliers = self._find_multipliers()
        total = self._dag.zero
        for row, coefficient in self._index.row_ends[end]:
            if row not in multipliers:
                raise self._places.undetermined(end[0], through=False)
            term = self._dag.mul(coefficient, multipliers[row])
            total = self._dag.add(total, term)
        return self._symbols.turned(total, end[1])

    def _find_multipliers(self) -> dict[int, Node]:
        """The multipliers of the raw rows: those of the working rows, elimination undone."""
        if self._multipliers is None:
            causal, dag = self._causal, self._dag
            forces = self._step_forces(_Share.REACTIONS)
            found: dict[int, Node] = dict(self._closing_multipliers)
            taken: dict[int, list[tuple[int, Node]]] = {}  # row -> later rows it was taken from
            for step in causal.steps:
                for earlier, factor in step.factors:
                    taken.setdefault(earlier, []).append((step.row, factor))
            for k in range(len(causal.steps) - 1, -1, -1):
                row = causal.steps[k].row
                parts = (dag.mul(f, found[later]) for later, f in taken.get(row, ()))
                found[row] = dag.sub(forces[k], dag.sum(parts))
            for row in causal.redundant:  # others follow from one choice of these, but are unique
                found.pop(row, None)
            self._multipliers = found
        return self._multipliers

    def balance(self, number: int) -> Node:
        """The sum on a class that reactions of inertias and flow sources balance.

        It is the sum of the signed across variables, power into the elements positive, the
        shares of transformers and junctions included.
        """
        return self._balance(number, 1, _Share.REST, without=None)

    def merged_balance(self, number: int) -> Node:
        """The rate of a merged momentum: minus the balance, the turning of moduli included."""
        return self._balance(number, -1, _Share.TURNING, without=None)

    def reaction(self, port_index: int) -> Node:
        """The across variable that a flow source, or an inertia that keeps its momentum, bears."""
        port = self._causal.ports[port_index]
        number = self._causal.class_of[port.bond]
        is_alone = port.role is Role.INERTIA and port_index not in self.reacting
        share = _Share.REST if is_alone else _Share.REACTIONS
        return self._balance(number, -port.sign, share, without=port_index)

    def _balance(self, number: int, sign: int, share: _Share, without: int | None) -> Node:
        """A sign times the sum on a class."""
        dag = self._dag
        forces = self._step_forces(share)
        total = self._own_forces(number, sign, share, without)
        for k, entry in self._index.steps_with[number]:
            total = dag.add(total, self._symbols.turned(dag.mul(entry, forces[k]), sign))
        return total

    def _own_forces(self, number: int, sign: int, share: _Share, without: int | None) -> Node:
        total = self._dag.zero
        if share is _Share.TURNING and number in self.turning:
            total = self._symbols.turned(self.turning[number], sign)
        for node in self._closing.get(number, ()):
            total = self._dag.add(total, self._symbols.turned(node, sign))
        for k in self._causal.classes[number].ports:
            port = self._causal.ports[k]
            reacts = port.role in {Role.INERTIA, Role.FLOW_SOURCE}
            if k == without or (reacts and share is not _Share.REACTIONS):
                continue
            force = self._symbols.across(port.bond) if reacts else self._answers[k]
            total = self._dag.add(total, self._symbols.turned(force, sign * port.sign))
        return total

    def _step_forces(self, share: _Share) -> list[Node]:
        """The multipliers of the steps' working rows, in order of elimination."""
        if share not in self._forces:
            dag = self._dag
            forces: list[Node] = []
            for k, step in enumerate(self._causal.steps):
                total = self._own_forces(step.dependent, -1, share, None)
                pivot = dag.one
                for other, entry in self._index.steps_with[step.dependent]:
                    if other == k:
                        pivot = entry
                    else:
                        total = dag.sub(total, dag.mul(entry, forces[other]))
                forces.append(dag.div(total, pivot))
            self._forces[share] = forces
        return self._forces[share]

    def _between_junctions(self, bond: int) -> Node:
        """The across variable of a bond between two junctions of common through variable."""
        number = self._causal.class_of[bond]
        if number not in self._branches:
            self._branches[number] = self._branches_of(number)
        junction = self._branches[number].get(bond)
        if junction is None:
            raise self._places.undetermined(bond, through=False)
        total, own = self._dag.zero, 1
        element = self._causal.graph.elements[junction]
        assert isinstance(element, Junction)
        for port in element.ports:
            if port.bond == bond:
                own = port.sign
            else:
                term = self._symbols.turned(self._symbols.across(port.bond), port.sign)
                total = self._dag.add(total, term)
        return self._symbols.turned(total, -own)

    def _branches_of(self, number: int) -> dict[int, int]:
        """The tree of junctions of a class: each inner bond, with the junction farther out.

        Empty if the junctions form a loop: what circulates there is not determined.
        """
        inner = [
            bond
            for bond in self._causal.classes[number].bonds
            if (bond, 1) in self._index.junction_at
            and (bond, -1) in self._index.junction_at
            and (bond, 1) not in self._index.row_ends
            and (bond, -1) not in self._index.row_ends
        ]
        at: dict[int, list[tuple[int, int]]] = {}
        for bond in inner:
            head, tail = self._index.junction_at[bond, 1], self._index.junction_at[bond, -1]
            at.setdefault(head, []).append((bond, tail))
            at.setdefault(tail, []).append((bond, head))
        branches: dict[int, int] = {}
        root = self._index.junction_at[inner[0], 1]
        seen, queue = {root}, deque([root])
        while queue:
            for bond, other in at[queue.popleft()]:
                if other not in seen:
                    seen.add(other)
                    branches[bond] = other
                    queue.append(other)
        return branches if len(branches) == len(inner) else {}
