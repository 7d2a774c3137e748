"""Certificates that a node never vanishes, so that it may be a pivot.

Numbers have one, and expressions of parameters that are nonzero at the default values, which the
runtime checks when parameters are set. What depends on states or time has one only where asked
for: if its range is proven to exclude zero (`2 + sin(angle)`), at the parameters' default values,
of which the runtime then checks the end of the range that is nearer to zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.interpretation import Intervals, NodeIntervals
from bgc.algebra.rounding import RoundedEvaluator
from bgc.ir.defaults import default_values
from bgc.ir.graph import Node, Parameter
from bgc.ir.program import PositiveParameter


class Rank(IntEnum):
    """Rank of a divisor; smaller is better."""

    UNIT = 0  # 1 or -1
    NUMBER = 1
    PARAMETER = 2  # a product of parameters, nonzero at their defaults; checked at run time
    DOUBTFUL = 3  # any other expression of parameters (`sin(slope)`); checked at run time
    RANGED = 4  # varies, within a range without zero


_SMALL_PIVOT = 0.1  # relative to the largest entry of a row; a smaller pivot makes the others grow


@dataclass(frozen=True, slots=True, order=True)
class Size:
    """The rank of a divisor, and whether it is small beside another entry of its row."""

    rank: Rank
    is_small: bool


@dataclass(frozen=True, slots=True)
class Certificate:
    """The proof that a node never vanishes: its rank, and the parameter nodes to watch."""

    rank: Rank
    watched: tuple[Node, ...]


class Certifier:
    """Certificates of the nodes of one DAG, given the parameters' default values.

    With `ranged`, nodes that vary within a range without zero have one too. `at_defaults` are the
    intervals of nodes that vary, while the parameters have their default values.
    """

    def __init__(
        self,
        dag: Dag,
        fingerprints: Fingerprints,
        parameters: Iterable[Parameter],
        *,
        ranged: bool = False,
    ) -> None:
        self._dag = dag
        self._fingerprints = fingerprints
        self.defaults = default_values(dag, parameters)
        self._values = RoundedEvaluator(dag, self.defaults.__getitem__)
        self._known: dict[Node, Certificate | None] = {}
        self._intervals = NodeIntervals(dag) if ranged else None
        self.at_defaults = Intervals(dag, self._limits)
        self._bounds: set[Node] = set()

    def certify(self, node: Node) -> Certificate | None:
        """The certificate of a node, None if there is none."""
        if node not in self._known:
            self._known[node] = self._certify(node)
        return self._known[node]

    def check(self, node: Node, message: str) -> PositiveParameter:
        """The check of a node to watch."""
        is_bound = node in self._bounds
        return PositiveParameter(node, message, strictly_positive=False, bound=is_bound)

    def may_vanish(self, node: Node) -> bool:
        """Test whether a node is never a pivot, or one only where nothing else is left."""
        certificate = self.certify(node)
        return certificate is None or certificate.rank >= Rank.DOUBTFUL

    def size_in(self, node: Node, row: Iterable[Node]) -> Size | None:
        """The size of an entry as the pivot of its row; None if it may vanish."""
        return self.size_beside(node, lambda: self.largest_in(row))

    def size_beside(self, node: Node, largest: Callable[[], float]) -> Size | None:
        """The same, from the largest entry of the row (`largest_in`), if that is needed."""
        certificate = self.certify(node)
        if certificate is None:
            return None
        if certificate.rank is Rank.UNIT:
            return Size(certificate.rank, is_small=False)
        if self._dag.level[node] > Level.PARAM:
            return Size(certificate.rank, is_small=False)
        return Size(certificate.rank, is_small=abs(self.default(node)) / largest() < _SMALL_PIVOT)

    def largest_in(self, row: Iterable[Node]) -> float:
        """The absolute value of the largest entry of a row that does not vary."""
        level = self._dag.level
        return max(abs(self.default(x)) for x in row if level[x] <= Level.PARAM)

    def default(self, node: Node) -> float:
        """The value of a node of at most PARAM level, with parameters at their defaults."""
        return self._values.value(node).value

    def _limits(self, node: Node) -> tuple[float, float] | None:
        """The default value of a node of parameters, with its rounding errors."""
        return self._values.value(node).limits if self._dag.level[node] <= Level.PARAM else None

    def _certify(self, node: Node) -> Certificate | None:
        dag = self._dag
        if dag.op[node] == Op.NEG:
            return self.certify(dag.a[node])
        number = self._fingerprints.constant(node)
        if number is not None:
            if number == 0:
                return None
            return Certificate(Rank.UNIT if abs(number) == 1 else Rank.NUMBER, ())
        if dag.level[node] <= Level.PARAM:
            value = self._values.value(node)
            if value.is_noise or not math.isfinite(value.value):
                return None
            if dag.level[node] == Level.CONST:
                return Certificate(Rank.NUMBER, ())
            plain = self._is_product_of_parameters(node)
            return Certificate(Rank.PARAMETER if plain else Rank.DOUBTFUL, (node,))
        if dag.op[node] in {Op.MUL, Op.DIV}:
            parts = [self.certify(x) for x in dag.operands(node)]
            certain = [part for part in parts if part is not None]
            if len(certain) == len(parts):
                watched = tuple(dict.fromkeys(n for part in certain for n in part.watched))
                return Certificate(max(part.rank for part in certain), watched)
        return self._by_range(node)

    def _by_range(self, node: Node) -> Certificate | None:
        """The certificate of a node whose range excludes zero."""
        if self._intervals is None:
            return None
        dag, found = self._dag, self._intervals.value(node)
        for end in (found.low, None if found.high is None else dag.neg(found.high)):
            if end is None:
                continue
            value = self._values.value(end)
            if value.value > 0 and math.isfinite(value.value) and not value.is_noise:
                if dag.level[end] == Level.CONST:
                    return Certificate(Rank.RANGED, ())
                bound = dag.call(Op.MAX, end, dag.zero)
                self._bounds.add(bound)
                return Certificate(Rank.RANGED, (bound,))
        return None

    def _is_product_of_parameters(self, node: Node) -> bool:
        """Test whether a node of PARAM level vanishes only if one of its parameters does."""
        dag = self._dag
        if dag.symbol_of(node) is not None or dag.level[node] == Level.CONST:
            return True
        products = {Op.MUL, Op.DIV, Op.NEG, Op.SQRT}
        return dag.op[node] in products and all(
            map(self._is_product_of_parameters, dag.operands(node))
        )
