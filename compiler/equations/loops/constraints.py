"""Constraints between states: equations that hold their unknowns only once differentiated.

An equation such as `x^2 + y^2 = l^2`, whose unknown is the force in the rod, has index 2 or 3. Its
derivative that holds the unknown is found here for the message that refuses the constraint.
"""

from __future__ import annotations

from collections.abc import Collection

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.algebra.expansion import expanded_text
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.loops.substitution import Resolver
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Node
from bgc.record_class import dataclass

_MOST_DIFFERENTIATIONS = 3  # differentiations


@dataclass(frozen=True, slots=True)
class Derivative:
    """The derivative of a constraint that holds an unknown: its order and its text."""

    order: int
    equation: str


def derivative_with_unknown(
    variables: Variables, resolver: Resolver, right: Node, unknowns: Collection[int]
) -> Derivative | None:
    """Differentiate `right = 0` in time until it holds an unknown; None where that is not known.

    `unknowns` are the numbers of the states that equations determine.
    """
    dag, is_zero = variables.dag, variables.causal.fingerprints.is_zero
    node = right
    for order in range(1, _MOST_DIFFERENTIATIONS + 1):
        if dag.symbols_in([node], Kind.INPUT):
            return None
        direction = {dag.symbol(Kind.TIME): dag.one}
        for state, symbol in dag.symbols_in([node], Kind.STATE).items():
            rate = _rate(resolver, symbol.index)
            if rate is None:
                return None
            direction[state] = rate
        node = directional_derivative(dag, node, direction)
        states = dag.symbols_in([node], Kind.STATE).items()
        found = [state for state, symbol in states if symbol.index in unknowns]
        if any(not is_zero(slope) for slope in gradient(dag, node, found)):
            text = expanded_text(dag, node, lambda symbol: _name(variables, resolver, symbol))
            return None if text is None else Derivative(order, f"{text} = 0")
    return None


def _rate(resolver: Resolver, number: int) -> Node | None:
    try:
        return resolver.rate_of_state(number)
    except BgError:
        return None


def _name(variables: Variables, resolver: Resolver, symbol: Symbol) -> str:
    """The name of a parameter, of the time or of a state, as the model would write it."""
    graph = variables.causal.graph
    if symbol.kind is Kind.PARAM:
        return graph.parameters[symbol.index].name
    if symbol.kind is Kind.TIME:
        return "time"
    raw = resolver.raw_state(symbol.index)
    leaf = variables.dag.leaf(raw)
    if leaf.kind is Kind.STATE:
        return graph.states[leaf.index].name
    if leaf.kind is Kind.UNKNOWN:
        return graph.unknowns[leaf.index].name
    return variables.places.name_of(raw)
