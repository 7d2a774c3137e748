"""How fast the unknowns of algebraic loops change: so that their residuals stay zero."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.algebra.dag import Dag
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.solving import solve_general
from bgc.ir.graph import Node


def implicit_rates(
    dag: Dag,
    fingerprints: Fingerprints,
    residuals: Mapping[Node, Node],
    direction: Mapping[Node, Node],
) -> dict[Node, Node]:
    """The rates of unknowns (unknown -> residual): `J x' = -(what else changes the residuals)`.

    `direction` gives the rates of everything else in the residuals. Loops are regular, so J is.
    """
    unknowns = list(residuals)
    if not unknowns:
        return {}
    matrix = [
        {j: x for j, x in enumerate(gradient(dag, residual, unknowns)) if x != dag.zero}
        for residual in residuals.values()
    ]
    right = [dag.neg(directional_derivative(dag, r, direction)) for r in residuals.values()]
    rates = solve_general(dag, fingerprints, matrix, right, lambda node: dag.level[node])
    return dict(zip(unknowns, rates, strict=True))
