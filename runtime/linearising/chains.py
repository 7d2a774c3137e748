"""Closed chains of rigid connections at an operating point: projection, independent coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.derivatives import gradient
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.catalogue.closures import input_moves_chain
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.closures.manifold import (
    Conditions,
    chosen_rows,
    closed,
    closed_flows,
    selection,
)
from bgc.ir.graph import Node
from bgc.ir.program import Program
from bgc.runtime.results.arrays import Array


class ClosedChains:
    """The closed chains of an opened program; nothing changes in a program without any.

    `inputs` are the INPUT symbols that the program is linearised by.
    """

    def __init__(self, program: Program, inputs: Sequence[int]) -> None:
        self._program = program
        self._dag = program.dag
        self._rows: list[Node] = []
        closures = program.closures
        if closures is None:
            return
        self._rows = [*closures.flows[: closures.kept], *closures.conditions[: closures.held]]
        self._rank = sum(closures.ranks) + closures.held_rank
        self._conditions = Conditions(
            closures.conditions[: closures.held], closures.moved, closures.by_place
        )
        symbols = {self._dag.symbol(Kind.INPUT, k) for k in inputs}
        if not symbols.isdisjoint(self._dag.reachable(self._rows)):
            chain = closures.chains[0] if closures.chains else None
            raise BgError([input_moves_chain(chain.names if chain else closures.names)])
        self._columns = sorted({*closures.impulses, *closures.moved})

    def closed(self, values: Mapping[Symbol, float], state: Array) -> Array:
        """Project a state onto the chains, as after a step of a run."""
        if not self._rows:
            return state
        point = closed(self._dag, self._conditions, dict(values))
        if point is None:
            return np.full_like(state, np.nan)
        point = closed_flows(self._program, point)
        return np.array([point[Symbol(Kind.STATE, k)] for k in range(len(state))])

    def selection(self, values: Mapping[Symbol, float]) -> dict[Symbol, float]:
        """The selectors of the closing rows that a run would choose at a point."""
        closures = self._program.closures
        rows = chosen_rows(self._dag, closures, dict(values)) if closures else ()
        return selection(self._dag, closures, rows) if closures else {}

    def coordinates(
        self, values: Mapping[Symbol, float], size: int, scale: Array
    ) -> tuple[Array, NDArray[np.intp]]:
        """Choose independent states; return dx = T dz of all states by these, and their numbers.

        The dependent ones are the pivots of the rows' derivatives in the states' scales, by
        Gaussian elimination with complete pivoting.
        """
        every = np.arange(size)
        if not self._rows:
            return np.eye(size), every
        symbols = [self._dag.symbol(Kind.STATE, k) for k in self._columns]
        slopes = [gradient(self._dag, row, symbols) for row in self._rows]
        numbers = evaluate_nodes(self._dag, [x for row in slopes for x in row], values)
        table = np.array(numbers).reshape(len(self._rows), len(symbols)) * scale[self._columns]
        table /= np.maximum(np.abs(table).max(axis=1, keepdims=True), 1e-300)
        dependent = _pivots(table, self._rank)
        free = [k for k in range(len(symbols)) if k not in dependent]
        solved = -np.linalg.lstsq(table[:, dependent], table[:, free])[0]
        follow = np.eye(size)
        columns = np.array(self._columns)
        follow[np.ix_(columns[dependent], columns[free])] = (
            solved * scale[columns[dependent], None] / scale[columns[free]]
        )
        left = np.setdiff1d(every, columns[dependent])
        return follow[:, left], left


def _pivots(table: Array, rank: int) -> list[int]:
    """The columns of the largest pivots, as many as the rank."""
    work, found = table.copy(), list[int]()
    for _ in range(rank):
        row, column = np.unravel_index(int(np.argmax(np.abs(work))), work.shape)
        found.append(int(column))
        work -= np.outer(work[:, column] / work[row, column], work[row])
        work[row] = work[:, column] = 0.0
    return found
