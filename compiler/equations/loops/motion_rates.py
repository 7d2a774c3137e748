"""Substitute the speeds of free motions, as the last step of the derivation.

Until here a speed is a symbol of its own. It cancels from the rates of the merged states, unless a
modulus on the motion depends on that speed; rates from which it cancels equal their values at speed
zero. The speed is that at which each designated quantity follows its condition,

    z = d/dt x_d - (x_d' - z),

where the right side depends on speeds only in the same exceptional case. The speeds are then
resolved like all other variables. Only those that something reads are computed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from bgc.algebra.dag import Kind
from bgc.algebra.derivatives import directional_derivative
from bgc.equations.loops.substitution import Resolver
from bgc.equations.variables.definitions import Explicit, Variables
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import Node
from bgc.ir.program import Program, ProgramState


def settle_motions(
    program: Program, variables: Variables, resolver: Resolver, numbers: Mapping[Node, int]
) -> tuple[Program, Resolver]:
    """Remove the speeds of free motions; `numbers` maps raw states to their indices.

    Speeds that depend on each other are an algebraic loop. The second result holds those loops and
    their unknowns, which are states behind all others.

    Raises
    ------
    BgError
        A speed depends on its own rate, or on the rate of a device's input.
    """
    settled = resolver.of_final_nodes(len(program.states), variables.multipliers)
    if not variables.speeds:
        return program, settled
    settling = _Settling(program, variables, resolver, settled)
    states = list(program.states)
    for symbol in variables.resting:
        number = numbers[symbol]
        rate = settling.rested(states[number].derivative)
        states[number] = replace(states[number], derivative=rate)
    rested = replace(program, states=tuple(states))
    roots = nodes_of(rested)
    speeds = settling.speeds_in(roots, states)
    variables.definitions |= {symbol: Explicit(node) for symbol, node in speeds.items()}
    values = {symbol: settled.resolve(symbol) for symbol in speeds}
    final = dict(zip(roots, program.dag.substitute(roots, values), strict=True))
    return map_nodes(rested, program.dag, final.__getitem__), settled


class _Settling:
    def __init__(
        self, program: Program, variables: Variables, resolver: Resolver, settled: Resolver
    ) -> None:
        self._dag = program.dag
        self._variables = variables
        self._fingerprints = variables.causal.fingerprints
        self._resolver = resolver
        self._settled = settled
        self._rest = dict.fromkeys(variables.speeds, self._dag.zero)

    def _without_speeds(self, node: Node) -> Node | None:
        """A node from which speeds cancel, at speed zero; None where they do not."""
        (rested,) = self._dag.substitute([node], self._rest)
        return rested if self._fingerprints.equal(node, rested) else None

    def rested(self, node: Node) -> Node:
        """A node, without the speeds that cancel from it."""
        rested = self._without_speeds(node)
        return node if rested is None else rested

    def speeds_in(self, roots: Sequence[Node], states: Sequence[ProgramState]) -> dict[Node, Node]:
        """The speeds that nodes need, each as a node that may hold speeds."""
        found: dict[Node, Node] = {}
        waiting = self._held(roots)
        for symbol in waiting:  # which grows
            if symbol not in found:
                found[symbol] = self._following(symbol, states)
                waiting += self._held([found[symbol], *self._settled.rates.values()])
        return found

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

    def _direction(
        self, node: Node, states: Sequence[ProgramState], symbol: Node
    ) -> dict[Node, Node]:
        """The rates of time and of the states in a node, algebraic ones included."""
        dag, settled = self._dag, self._settled
        direction = {dag.symbol(Kind.TIME): dag.one}
        waiting = [node]
        while waiting:
            for inner, leaf in dag.symbols_in([waiting.pop()], Kind.STATE, Kind.INPUT).items():
                if leaf.kind is Kind.INPUT:
                    raise self._variables.places.no_rate(symbol, leaf)
                if inner in direction:
                    continue
                rate = states[leaf.index].derivative
                if states[leaf.index].kind == "algebraic":
                    settled.residuals[inner] = self._steady(rate, symbol)
                    direction[inner] = settled.rate_of_unknown(inner, symbol)
                    waiting.append(settled.residuals[inner])
                else:
                    direction[inner] = settled.rates[leaf.index] = self.rested(rate)
        return direction
