"""One walk over a graph for all kinds of values: doubles, doubles with errors, intervals.

Each node is computed at most once, after its operands (an abstract interpretation, Cousot 1977).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Generic, TypeVar

from bgc.algebra.dag import Dag
from bgc.algebra.nodes import Node

Value = TypeVar("Value")


class Fold(ABC, Generic[Value]):
    """The values of a graph's nodes, of a kind that a subclass defines."""

    def __init__(self, dag: Dag) -> None:
        self._dag = dag
        self._known: dict[Node, Value] = {}

    def value(self, node: Node) -> Value:
        """The value of a node."""
        if node not in self._known:
            self.values([node])
        return self._known[node]

    def values(self, roots: Iterable[Node]) -> list[Value]:
        """The values of several nodes."""
        known, roots = self._known, list(roots)
        for node in self._missing(roots):
            known[node] = self._of(node)
        return [known[root] for root in roots]

    def _missing(self, roots: Iterable[Node]) -> list[Node]:
        """The nodes that the roots need and that are not known yet, in topological order."""
        dag, known = self._dag, self._known
        seen = {root for root in roots if root not in known}
        stack = list(seen)
        while stack:
            for operand in dag.operands(stack.pop()):
                if operand not in known and operand not in seen:
                    seen.add(operand)
                    stack.append(operand)
        return sorted(seen)

    @abstractmethod
    def _of(self, node: Node) -> Value:
        """The value of a node whose operands are known."""
