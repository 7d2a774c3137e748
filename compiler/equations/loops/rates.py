"""Rates of final nodes, as sums over the rates of the states and unknowns that they hold."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.derivatives import gradient
from bgc.ir.graph import Node
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class RateTerms:
    """The rate of a node as `by_time + sum weight * rate`, over raw rates."""

    by_time: Node
    weights: Mapping[Node, Node]


def rate_terms(dag: Dag, node: Node, rates: Mapping[Node, Node]) -> RateTerms:
    """The rate of a final node over the raw rates of the symbols in it, a mapping of these."""
    by_time, *slopes = gradient(dag, node, [dag.symbol(Kind.TIME), *rates])
    weights: dict[Node, Node] = {}
    for rate, slope in zip(rates.values(), slopes, strict=True):
        weights[rate] = dag.add(weights.get(rate, dag.zero), slope)
    return RateTerms(by_time, {rate: w for rate, w in weights.items() if w != dag.zero})
