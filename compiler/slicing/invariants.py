"""Invariant states: states that provably keep their initial value.

Assume that a set of states keeps its initial values; substitute them everywhere and fold. A
state whose derivative is then not identically zero leaves the set, which may make others leave,
until the set no longer changes. It is the greatest set consistent with its own assumption, and
the uniqueness of solutions makes the reduction exact. A crane that luffs in its own plane becomes
planar in this way, because nothing pushes it out of that plane.

A node is zero if it folds to zero, or else if its fingerprints at two random points are zero
(`algebra.fingerprint`), which covers identities such as `sin^2 + cos^2 = 1`. Device inputs, time
and run-time parameters count as arbitrary.

Each round examines only states that depend on a state that left in the round before, so a chain
that is pulled at one end takes time in proportion to its length.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from bgc.algebra.dag import Kind, Level, Op
from bgc.algebra.fingerprint import Fingerprints
from bgc.ir.graph import Node
from bgc.ir.program import Program
from bgc.slicing.clamps import Clamps
from bgc.slicing.keep_patterns import is_kept
from bgc.slicing.zero_starts import zero_starts


def invariant_states(program: Program) -> dict[int, Node]:
    """Find the states that never change, each with its value, a node of CONST or PARAM level.

    States that `keep` names are excluded. A state is invariant only if its row of the mass matrix
    has no rate of a state that moves, so the reduced equations stay regular where the whole was.
    """
    search = _Search(program)
    suspects: Iterable[int] = tuple(search.values)
    while suspects:
        suspects = search.release(search.moving(suspects))
    return search.values


class _Search:
    """The rounds over one program, folding into a DAG of their own.

    `values` are the states still assumed to be invariant, each with its initial value.
    """

    def __init__(self, program: Program) -> None:
        dag = program.dag
        started = {number for number, _ in program.start.values} if program.start else set()
        started -= zero_starts(program)
        started |= {reset.state for jump in program.jumps for reset in jump.resets}
        self.values = {
            index: state.initial
            for index, state in enumerate(program.states)
            if dag.level[state.initial] <= Level.PARAM
            and index not in started
            and not is_kept(state.name, program.kept)
        }
        self._program = program
        self._dag = dag.copy()
        self._fingerprints = Fingerprints(self._dag)
        self._clamps = Clamps(self._dag, program.parameters)
        self._columns: dict[int, list[int]] = {}
        for entry in program.mass or ():
            self._columns.setdefault(entry.row, []).append(entry.column)
        self._changes = changes_by_projection(program)
        self._reads = _states_read(program)
        self._staying = _bits(self.values)
        self._readers: list[list[int]] = [[] for _ in program.states]
        for index, state in enumerate(program.states):
            bits = self._reads[state.derivative] | _bits(self._columns.get(index, ()))
            if state.projection is not None:
                bits |= self._reads[state.projection]
            for node in self._changes.get(index, ()):
                bits |= self._reads[node]
            for read in _places(bits):
                self._readers[read].append(index)

    def release(self, moving: Iterable[int]) -> list[int]:
        """Remove states from the set; return those that depend on them, to be examined again."""
        affected: set[int] = set()
        for index in moving:
            del self.values[index]
            self._staying ^= 1 << index
            affected.update(self._readers[index])
        return sorted(affected & self.values.keys())

    def moving(self, suspects: Iterable[int]) -> list[int]:
        """The suspects whose derivative is not zero if all states with values are invariant."""
        states = [(index, self._program.states[index]) for index in suspects]
        roots = [state.derivative for _, state in states]
        roots += [state.projection for _, state in states if state.projection is not None]
        roots += [node for index, _ in states for node in self._changes.get(index, ())]
        new = self._folded(roots)

        def stays(index: int, derivative: Node, projection: Node | None) -> bool:
            changes = self._changes.get(index, ())
            if not all(self._fingerprints.is_zero(new.get(node, node)) for node in changes):
                return False
            if not self._fingerprints.is_zero(new.get(derivative, derivative)):
                return False
            if any(column not in self.values for column in self._columns.get(index, ())):
                return False
            return projection is None or self._fingerprints.equal(
                new.get(projection, projection), self.values[index]
            )

        return [k for k, state in states if not stays(k, state.derivative, state.projection)]

    def _folded(self, roots: Iterable[Node]) -> dict[Node, Node]:
        """Substitute the values for their states; return the new nodes of those that change."""
        dag = self._dag
        new: dict[Node, Node] = {}
        for node in self._affected(roots):
            symbol = dag.symbol_of(node)
            if symbol is not None:
                new[node] = self.values[symbol.index]
                continue
            operands = tuple(new.get(x, x) for x in dag.operands(node))
            new[node] = self._clamps.folded(dag.rebuild(node, operands))
        return new

    def _affected(self, roots: Iterable[Node]) -> list[Node]:
        """The nodes under the roots that depend on a state with a value, operands first."""
        reads, staying, operands = self._reads, self._staying, self._dag.operands
        seen = {root for root in roots if reads[root] & staying}
        stack = list(seen)
        while stack:
            for operand in operands(stack.pop()):
                if operand not in seen and reads[operand] & staying:
                    seen.add(operand)
                    stack.append(operand)
        return sorted(seen)


def changes_by_projection(program: Program) -> dict[int, tuple[Node, ...]]:
    """The nodes by which the projection of closed chains changes a state; zero: it does not."""
    closures = program.closures
    if closures is None:
        return {}
    columns = zip(*closures.by_place, strict=True) if closures.by_place else ()
    changes = dict(zip(closures.moved, columns, strict=False))
    return changes | dict(zip(closures.impulses, closures.response, strict=True))


def put_in(program: Program, roots: Sequence[Node], values: Mapping[int, Node]) -> dict[Node, Node]:
    """Substitute the values into the roots, in the program's own DAG.

    Clamps with a certain outcome are folded too.
    """
    dag = program.dag
    clamps = Clamps(dag, program.parameters)
    new = {dag.symbol(Kind.STATE, index): value for index, value in values.items()}
    for node in dag.reachable(roots):
        if node not in new:
            operands = dag.operands(node)
            folded = tuple(new[x] for x in operands)
            new[node] = clamps.folded(node if folded == operands else dag.rebuild(node, folded))
    return new


def _states_read(program: Program) -> dict[Node, int]:
    """For each node of derivatives and projections, the states it depends on, as a bit mask."""
    dag = program.dag
    roots = [state.derivative for state in program.states]
    roots += [state.projection for state in program.states if state.projection is not None]
    roots += [node for nodes in changes_by_projection(program).values() for node in nodes]
    reads: dict[Node, int] = {}
    for node in dag.reachable(roots):
        bits = 0
        if dag.op[node] == Op.SYMBOL:
            symbol = dag.symbols[dag.a[node]]
            bits = 1 << symbol.index if symbol.kind is Kind.STATE else 0
        else:
            for operand in dag.operands(node):
                bits |= reads[operand]
        reads[node] = bits
    return reads


def _bits(indices: Iterable[int]) -> int:
    bits = 0
    for index in indices:
        bits |= 1 << index
    return bits


def _places(bits: int) -> Iterator[int]:
    while bits:
        lowest = bits & -bits
        yield lowest.bit_length() - 1
        bits ^= lowest
