"""Substitute the speeds of free motions, as the last step of the derivation.

Until here a speed is a symbol of its own. It cancels from the rates of the merged states, unless a
modulus on the motion depends on that speed; rates from which it cancels equal their values at speed
zero. The speed is that at which each designated quantity follows its condition,

    z = d/dt x_d - (x_d' - z),

where the right side depends on speeds only in the same exceptional case, and is then solved for
them. Only speeds that something reads are computed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from bgc.algebra.dag import Kind, Level
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.algebra.signs import Signs
from bgc.algebra.symbolic_systems import SingularSystemError, solve_general
from bgc.equations.loops.rates import implicit_rates
from bgc.equations.loops.substitution import Resolver
from bgc.equations.variables.definitions import Variables
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import Node
from bgc.ir.program import MassEntry, Program, ProgramState


def settle_motions(
    program: Program, variables: Variables, resolver: Resolver, numbers: Mapping[Node, int]
) -> Program:
    """Remove the speeds of free motions; `numbers` maps raw states to their indices.

    Speeds that depend on each other through a matrix that may become singular become algebraic
    states, after all other states.

    Raises
    ------
    BgError
        A speed depends on its own rate, or on the rate of a device's input.
    """
    if not variables.speeds:
        return program
    settling = _Settling(program, variables, resolver)
    states = list(program.states)
    for symbol in variables.resting:
        number = numbers[symbol]
        rate = settling.rested(states[number].derivative)
        states[number] = replace(states[number], derivative=rate)
    rested = replace(program, states=tuple(states))
    roots = nodes_of(rested)
    speeds, added = settling.speeds_in(roots, states)
    settled = dict(zip(roots, program.dag.substitute(roots, speeds), strict=True))
    return _with_states(map_nodes(rested, program.dag, settled.__getitem__), added)


def _with_states(program: Program, added: Sequence[ProgramState]) -> Program:
    """Append algebraic states, whose rows in the mass matrix are empty."""
    if not added:
        return program
    size, one = len(program.states), program.dag.one
    identity = tuple(MassEntry(row, row, one) for row in range(size))
    mass = identity if program.mass is None else program.mass
    return replace(program, states=(*program.states, *added), mass=mass)


class _Settling:
    def __init__(self, program: Program, variables: Variables, resolver: Resolver) -> None:
        self._dag = program.dag
        self._size = len(program.states)
        self._variables = variables
        self._fingerprints = variables.causal.fingerprints
        self._resolver = resolver
        self._rest = dict.fromkeys(variables.speeds, self._dag.zero)

    def _without_speeds(self, node: Node) -> Node | None:
        """A node from which speeds cancel, at speed zero; None where they do not."""
        (rested,) = self._dag.substitute([node], self._rest)
        return rested if self._fingerprints.equal(node, rested) else None

    def rested(self, node: Node) -> Node:
        """A node, without the speeds that cancel from it."""
        rested = self._without_speeds(node)
        return node if rested is None else rested

    def speeds_in(
        self, roots: Sequence[Node], states: Sequence[ProgramState]
    ) -> tuple[dict[Node, Node], list[ProgramState]]:
        """The speeds that appear in nodes, as nodes without speeds, and states added for that."""
        found: dict[Node, Node] = {}
        waiting = self._held(roots)
        for symbol in waiting:  # which grows
            if symbol not in found:
                found[symbol] = self._following(symbol, states)
                waiting += self._held([found[symbol]])
        coupled = [symbol for symbol, node in found.items() if self._held([node])]
        alone = {symbol: node for symbol, node in found.items() if symbol not in coupled}
        if not coupled:
            return alone, []
        right = self._dag.substitute([found[symbol] for symbol in coupled], alone)
        solution = self._solve(coupled, right)
        if solution is not None:
            return alone | solution, []
        stand_ins = {s: self._dag.symbol(Kind.STATE, self._size + k) for k, s in enumerate(coupled)}
        added = [
            self._algebraic(symbol, self._dag.sub(node, stand_ins[symbol]))
            for symbol, node in zip(coupled, self._dag.substitute(right, stand_ins), strict=True)
        ]
        return alone | stand_ins, added

    def _held(self, roots: Sequence[Node]) -> list[Node]:
        return [node for node in self._dag.reachable(roots) if node in self._rest]

    def _following(self, symbol: Node, states: Sequence[ProgramState]) -> Node:
        """`d/dt x_d - (x_d' - z)`, without the speeds that cancel from it."""
        dag, speed = self._dag, self._variables.speeds[symbol]
        stored = self._steady(self._resolver.resolve(speed.stored), speed.stored)
        self._resolver.rates_read.append((speed.stored, stored))
        direction = self._direction(stored, states, speed.stored)
        rate = self._resolver.resolve(speed.rate)
        (own,) = dag.substitute([rate], self._rest)
        beside = dag.sub(rate, symbol)
        if not self._fingerprints.equal(beside, own):
            own = beside
        node = dag.sub(directional_derivative(dag, stored, direction), own)
        return self.rested(node)

    def _steady(self, node: Node, symbol: Node) -> Node:
        """A node that may not depend on speeds; the raw symbol is for messages."""
        rested = self._without_speeds(node)
        if rested is None:
            raise self._variables.places.rate_in_loop([symbol])
        return rested

    def _solve(self, symbols: Sequence[Node], right: Sequence[Node]) -> dict[Node, Node] | None:
        """Solve `z = right(z)`; None where it is not linear, or a pivot may vanish."""
        dag, variables = self._dag, self._variables
        slopes = [gradient(dag, node, symbols) for node in right]
        if self._held([slope for row in slopes for slope in row]):
            return None
        signs, unsafe = Signs(dag, variables.defaults), list[Node]()
        names = [variables.places.name_of(variables.speeds[symbol].stored) for symbol in symbols]

        def note(pivot: Node, alone: bool) -> None:
            if dag.level[pivot] == Level.PARAM:
                variables.watch(pivot, f"the equation for the rate of `{names[0]}` is singular")
            elif not signs.is_certain(pivot):
                unsafe.append(pivot)

        matrix = [
            {j: dag.sub(dag.one if i == j else dag.zero, x) for j, x in enumerate(row)}
            for i, row in enumerate(slopes)
        ]
        offsets = dag.substitute(right, self._rest)
        try:
            values = solve_general(
                dag, self._fingerprints, matrix, offsets, lambda node: dag.level[node], note
            )
        except SingularSystemError:
            raise variables.places.rate_in_loop(
                [variables.speeds[symbol].stored for symbol in symbols]
            ) from None
        return None if unsafe else dict(zip(symbols, values, strict=True))

    def _algebraic(self, symbol: Node, residual: Node) -> ProgramState:
        """A speed as an algebraic state, named after the quantity that it moves."""
        places, zero = self._variables.places, self._dag.zero
        name = f"{places.name_of(self._variables.speeds[symbol].stored)}.speed"
        return ProgramState(name, "", "algebraic", zero, residual, None, self._dag.one)

    def _direction(
        self, node: Node, states: Sequence[ProgramState], symbol: Node
    ) -> dict[Node, Node]:
        """The rates of time and of the states in a node, algebraic ones included."""
        dag = self._dag
        direction = {dag.symbol(Kind.TIME): dag.one}
        unknown: dict[Node, Node] = {}  # algebraic state -> its residual
        waiting = [node]
        while waiting:
            for inner in dag.reachable([waiting.pop()]):
                leaf = dag.symbol_of(inner)
                if leaf is None or leaf.kind not in {Kind.STATE, Kind.INPUT}:
                    continue
                if leaf.kind is Kind.INPUT:
                    raise self._variables.places.no_rate(symbol, leaf)
                if inner in direction or inner in unknown:
                    continue
                rate = states[leaf.index].derivative
                if states[leaf.index].kind == "algebraic":
                    unknown[inner] = self._steady(rate, symbol)
                    waiting.append(unknown[inner])
                else:
                    direction[inner] = self.rested(rate)
        return direction | implicit_rates(dag, self._fingerprints, unknown, direction)
