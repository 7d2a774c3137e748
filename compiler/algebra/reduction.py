"""Gauss-Jordan elimination of sparse rows of nodes, whose pivots the caller chooses."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Generic, TypeVar

from bgc.algebra.dag import Dag
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.nodes import Node

Column = TypeVar("Column", bound=Hashable)


class Reduction(Generic[Column]):
    """Rows, and for each column the rows that hold it. Entries that are zero are left out."""

    def __init__(
        self, dag: Dag, fingerprints: Fingerprints, rows: Sequence[Mapping[Column, Node]]
    ) -> None:
        self._dag = dag
        self._is_zero = fingerprints.is_zero
        self.rows: list[dict[Column, Node]] = [{} for _ in rows]
        self.holding: dict[Column, set[int]] = {}
        for i, row in enumerate(rows):
            for column, node in row.items():
                self._put(i, column, node)

    def eliminate(self, i: int, column: Column) -> None:
        """Divide a row by its entry of a column, and take the column from all other rows."""
        dag, row = self._dag, self.rows[i]
        pivot = row[column]
        for other in sorted(self.holding[column] - {i}):
            factor = dag.div(self.rows[other][column], pivot)
            for c, node in row.items():
                left = dag.sub(self.rows[other].get(c, dag.zero), dag.mul(factor, node))
                self._put(other, c, left)
        row |= {c: dag.div(node, pivot) for c, node in row.items()}

    def _put(self, i: int, column: Column, node: Node) -> None:
        holding = self.holding.setdefault(column, set())
        if self._is_zero(node):
            self.rows[i].pop(column, None)
            holding.discard(i)
        else:
            self.rows[i][column] = node
            holding.add(i)
