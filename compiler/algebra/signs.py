"""Whether a node keeps away from zero, by its values at random points.

No proof: it decides only which of several right ways to solve a system is taken.
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
    """Signs of nodes with parameters at their defaults and all else of any size and sign."""

    def __init__(self, dag: Dag, defaults: Mapping[Symbol, float]) -> None:
        self._points = [Evaluator(dag, _anywhere(defaults, seed)) for seed in range(_POINTS)]

    def is_certain(self, node: Node) -> bool:
        """Whether a node has the same sign at all points, and is finite and not zero there."""
        values = [point.value(node) for point in self._points]
        return all(math.isfinite(v) and v * values[0] > 0 for v in values)


def _anywhere(defaults: Mapping[Symbol, float], seed: int) -> Callable[[Symbol], float]:
    """Parameters at their defaults, the rest between 0.01 and 100 or their negatives."""
    rng = random.Random(seed)

    def leaf(symbol: Symbol) -> float:
        known = defaults.get(symbol)
        return known if known is not None else rng.choice((-1, 1)) * 10 ** rng.uniform(-2, 2)

    return leaf
