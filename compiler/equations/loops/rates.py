"""The rates of the unknowns of algebraic loops, from the condition that residuals stay zero."""

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
    """Solve `J x' = -(dr/dz) z'` for the rates x' of unknowns, a mapping to their residuals r.

    `direction` gives the rates z' of the other symbols in the residuals. J is regular since the
    loops are.
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
