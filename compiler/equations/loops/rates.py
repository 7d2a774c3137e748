"""Rates of final nodes; those of loops' unknowns follow since their residuals stay zero."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.algebra.dag import Kind
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.algebra.symbolic_systems import solve_general
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Node
from bgc.record_class import dataclass


def implicit_rates(
    variables: Variables,
    residuals: Mapping[Node, Node],
    direction: Mapping[Node, Node],
    divisors: set[Node],
) -> dict[Node, Node]:
    """Solve `J x' = -(dr/dz) z'` for the rates x' of unknowns, a mapping to their residuals r.

    `direction` gives the rates z' of the other symbols in the residuals. J is regular at almost all
    values since the loops are; pivots that may vanish are added to `divisors`.
    """
    dag, unknowns = variables.dag, list(residuals)

    def note(pivot: Node, _alone: bool) -> None:
        if variables.may_vanish(pivot):
            divisors.add(pivot)

    if not unknowns:
        return {}
    matrix = [
        {j: x for j, x in enumerate(gradient(dag, residual, unknowns)) if x != dag.zero}
        for residual in residuals.values()
    ]
    right = [dag.neg(directional_derivative(dag, r, direction)) for r in residuals.values()]
    fingerprints = variables.causal.fingerprints
    rates = solve_general(dag, fingerprints, matrix, right, variables.signs.rank, note)
    return dict(zip(unknowns, rates, strict=True))


@dataclass(frozen=True, slots=True)
class RateTerms:
    """The rate of a node as `by_time + sum weight * rate`, over the raw rates of states."""

    by_time: Node
    weights: Mapping[Node, Node]


def rate_terms(
    variables: Variables,
    node: Node,
    rates: Mapping[Node, Node],
    residuals: Mapping[Node, Node],
    divisors: set[Node],
) -> RateTerms:
    """The rate of a final node over the rates of its states (a mapping to raw nodes).

    `residuals` maps the unknowns of loops that it depends on to their residuals. Pivots that may
    vanish are added to `divisors`.
    """
    dag = variables.dag
    time = dag.symbol(Kind.TIME)
    inner: Sequence[Node] = (time, *rates)

    def slope(by: Node) -> Node:
        direction = {other: dag.one if other == by else dag.zero for other in inner}
        moved = implicit_rates(variables, residuals, direction, divisors)
        return directional_derivative(dag, node, direction | moved)

    weights: dict[Node, Node] = {}
    for state, rate in rates.items():
        weights[rate] = dag.add(weights.get(rate, dag.zero), slope(state))
    return RateTerms(slope(time), {rate: w for rate, w in weights.items() if w != dag.zero})
