"""Substitute the speeds of free motions, as the last step of the derivation.

Until here a speed is a symbol of its own. It cancels from the rates of the merged states, which
therefore equal their values at speed zero. These rates determine how fast each designated quantity
changes, and so the speed. Only speeds that something reads are computed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from bgc.algebra.dag import Kind
from bgc.algebra.derivatives import directional_derivative
from bgc.equations.loops.rates import implicit_rates
from bgc.equations.loops.resolve import Resolver
from bgc.equations.variables.variables import Variables
from bgc.ir.graph import Node
from bgc.ir.program import Program, ProgramState
from bgc.ir.program_nodes import map_program, program_roots


def settle_motions(
    program: Program, variables: Variables, resolver: Resolver, numbers: Mapping[Node, int]
) -> Program:
    """Remove the speeds of free motions; `numbers` maps raw states to their indices.

    Raises
    ------
    BgError
        A speed that is read depends on itself, or on the rate of a device's input.
    """
    if not variables.speeds:
        return program
    settling = _Settling(program, variables, resolver)
    states = list(program.states)
    for symbol in variables.resting:
        number = numbers[symbol]
        rate = settling.at_rest(states[number].derivative, symbol)
        states[number] = replace(states[number], derivative=rate)
    rested = replace(program, states=tuple(states))
    roots = program_roots(rested)
    speeds = settling.speeds_in(roots, states)
    settled = dict(zip(roots, program.dag.substitute(roots, speeds), strict=True))
    return map_program(rested, program.dag, settled.__getitem__)


class _Settling:
    def __init__(self, program: Program, variables: Variables, resolver: Resolver) -> None:
        self._dag = program.dag
        self._variables = variables
        self._fingerprints = variables.causal.fingerprints
        self._resolver = resolver
        self._rest = dict.fromkeys(variables.speeds, self._dag.zero)

    def at_rest(self, node: Node, symbol: Node) -> Node:
        """A node from which speeds cancel, at speed zero; the raw symbol is for messages."""
        (rested,) = self._dag.substitute([node], self._rest)
        if not self._fingerprints.equal(node, rested):
            raise self._variables.places.rate_in_loop([symbol])
        return rested

    def speeds_in(self, roots: Sequence[Node], states: Sequence[ProgramState]) -> dict[Node, Node]:
        """The speeds that appear in nodes, as nodes without speeds."""
        held = [node for node in self._dag.reachable(roots) if node in self._rest]
        return {symbol: self._speed(symbol, states) for symbol in held}

    def _speed(self, symbol: Node, states: Sequence[ProgramState]) -> Node:
        """`d/dt x_d - (x_d' at rest)`."""
        dag, speed = self._dag, self._variables.speeds[symbol]
        stored = self.at_rest(self._resolver.resolve(speed.stored), speed.stored)
        (own,) = dag.substitute([self._resolver.resolve(speed.rate)], self._rest)
        direction = self._direction(stored, states, speed.stored)
        return dag.sub(directional_derivative(dag, stored, direction), own)

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
                    raise self._variables.places.no_rate(symbol)
                if inner in direction or inner in unknown:
                    continue
                rate = self.at_rest(states[leaf.index].derivative, symbol)
                if states[leaf.index].kind == "algebraic":
                    unknown[inner] = rate
                    waiting.append(rate)
                else:
                    direction[inner] = rate
        return direction | implicit_rates(dag, self._fingerprints, unknown, direction)
