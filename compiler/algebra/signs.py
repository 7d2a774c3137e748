"""Signs of nodes estimated from their values at random points, and where all that varies is zero.

This is not a proof; it only chooses between equally valid ways to solve a system.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping

from bgc.algebra.dag import Dag, Level, Symbol
from bgc.algebra.evaluate import Evaluator
from bgc.algebra.nodes import Node
from bgc.algebra.rounding import RoundedEvaluator

_POINTS = 12


class Signs:
    """Signs of nodes, with parameters at their defaults and all other symbols at random values.

    At zero, where a run often starts, `x^2` vanishes as nowhere else; there the values have error
    bounds, so that a rounding error is not taken for a number.
    """

    def __init__(self, dag: Dag, defaults: Mapping[Symbol, float]) -> None:
        self._levels = dag.level
        self._points = [Evaluator(dag, _anywhere(defaults, seed)) for seed in range(_POINTS)]
        self._zero = RoundedEvaluator(dag, lambda symbol: defaults.get(symbol, 0.0))

    def is_certain(self, node: Node) -> bool:
        """Test whether a node is finite, nonzero and of one sign at all points."""
        at_zero = self._zero.value(node)
        points = self._points if self._levels[node] > Level.PARAM else ()
        values = [at_zero.value, *(point.value(node) for point in points)]
        return not at_zero.is_noise and all(math.isfinite(v) and v * values[0] > 0 for v in values)

    def rank(self, pivot: Node) -> int:
        """Rank pivots: constants first, then parameters, then nodes of constant sign."""
        level = self._levels[pivot]
        if level == Level.CONST:
            return 0
        if not self.is_certain(pivot):
            return 3
        return 1 if level == Level.PARAM else 2


def _anywhere(defaults: Mapping[Symbol, float], seed: int) -> Callable[[Symbol], float]:
    """Values of symbols: defaults of parameters, others of size 0.01 to 100 and either sign."""
    rng = random.Random(seed)

    def leaf(symbol: Symbol) -> float:
        known = defaults.get(symbol)
        return known if known is not None else rng.choice((-1, 1)) * 10 ** rng.uniform(-2, 2)

    return leaf
