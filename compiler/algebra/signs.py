"""Signs of nodes estimated from their values at random points.

This is not a proof; it only chooses between equally valid ways to solve a system.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping

from bgc.algebra.dag import Dag, Symbol
from bgc.algebra.evaluate import Evaluator
from bgc.algebra.nodes import Node

_POINTS = 12


class Signs:
    """Signs of nodes, with parameters at their defaults and all other symbols at random values."""

    def __init__(self, dag: Dag, defaults: Mapping[Symbol, float]) -> None:
        self._points = [Evaluator(dag, _anywhere(defaults, seed)) for seed in range(_POINTS)]

    def is_certain(self, node: Node) -> bool:
        """Test whether a node is finite, nonzero and of one sign at all points."""
        values = [point.value(node) for point in self._points]
        return all(math.isfinite(v) and v * values[0] > 0 for v in values)


def _anywhere(defaults: Mapping[Symbol, float], seed: int) -> Callable[[Symbol], float]:
    """Values of symbols: defaults of parameters, others of size 0.01 to 100 and either sign."""
    rng = random.Random(seed)

    def leaf(symbol: Symbol) -> float:
        known = defaults.get(symbol)
        return known if known is not None else rng.choice((-1, 1)) * 10 ** rng.uniform(-2, 2)

    return leaf
