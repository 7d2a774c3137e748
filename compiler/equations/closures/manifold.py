"""The configurations in which chains are closed, as numbers: the start, and others at random.

The rank of the rows that close a chain does not follow from the expressions: rows of a planar
mechanism in space, for example, depend on each other only where the chain is closed. It is
therefore found at the start and at random closed configurations, with the parameters' defaults.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from operator import mul
from typing import TypeAlias

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.dense import (
    damped_change,
    independent_in,
    independent_rows,
    solve_dense,
)
from bgc.algebra.evaluate import Evaluator, evaluate_nodes
from bgc.equations.closures.multipliers import Responses
from bgc.ir.defaults import start_values
from bgc.ir.graph import Node
from bgc.ir.program import Closures, Program
from bgc.record_class import dataclass

CLOSED = 1e-10  # m or rad: what may be left of a condition
ROUNDED = 1e-6  # m or rad: the same of redundant conditions, where directions are rounded data
RANK = 3e-6  # rows closer than this to a combination of others depend on them
_ITERATIONS = 100
_DAMPING = 1e-2  # of the normal equations at first, relative to their diagonal
_LEAST_DAMPING = 1e-4  # after a step that did not help
_SLOW = 0.99  # of the residuals that a step leaves; `_SLOW_STEPS` such steps lead nowhere
_SLOW_STEPS = 4
_AT_REST = 1e-12  # m or rad: steps of this length change nothing
_PROJECTIONS = 20  # of momenta, at most
_PROJECTED = 1e-9  # relative change of a momentum after which none follows
_POINTS = 6
_TRIES = 8  # starts from which the free states are moved until a chain is closed
_SEARCH_STARTS = 3  # starts of a search for the least residuals
_SPREAD = 1.5  # of the random configurations around the start

Point = dict[Symbol, float]
_Equations: TypeAlias = Callable[[Sequence[float]], tuple[list[float], list[list[float]]]]


@dataclass(frozen=True, slots=True)
class Conditions:
    """Conditions on the states `moved`, with their derivatives by these."""

    nodes: Sequence[Node]
    moved: Sequence[int]
    slopes: Sequence[Sequence[Node]]

    def at(self, dag: Dag, point: Mapping[Symbol, float]) -> tuple[list[float], list[list[float]]]:
        """The conditions and their derivatives at a point."""
        numbers = Evaluator(dag, point.__getitem__)
        return numbers.values(self.nodes), [numbers.values(row) for row in self.slopes]


def gap_of(residuals: Sequence[float]) -> float:
    """The largest residual."""
    return max(map(abs, residuals), default=0.0)


def closed(dag: Dag, conditions: Conditions, point: Point) -> Point | None:
    """A point near a given one that satisfies the conditions; None where none is found."""
    symbols = [Symbol(Kind.STATE, k) for k in conditions.moved]

    at = _with_states(dag, conditions, point)
    found = solve_damped(at, [point[symbol] for symbol in symbols])
    return None if found is None else point | dict(zip(symbols, found, strict=True))


def _with_states(dag: Dag, conditions: Conditions, point: Point) -> _Equations:
    """The conditions and their derivatives by the moved states, as a function of these."""
    symbols = [Symbol(Kind.STATE, k) for k in conditions.moved]
    return lambda x: conditions.at(dag, point | dict(zip(symbols, x, strict=True)))


def nearest_to_closed(
    dag: Dag, conditions: Conditions, point: Point
) -> tuple[Point, Sequence[float]]:
    """The point with the least residuals that a search from a given one and from others finds."""
    rng = random.Random("nearest")
    symbols = [Symbol(Kind.STATE, k) for k in conditions.moved]
    found: list[tuple[float, Point, Sequence[float]]] = []
    for k in range(_SEARCH_STARTS):
        first = [point[symbol] + k * 0.3 * rng.uniform(-1, 1) for symbol in symbols]
        x, residuals = _approach(_with_states(dag, conditions, point), first)
        near = point | dict(zip(symbols, x, strict=True))
        found.append((gap_of(residuals), near, residuals))
    return min(found, key=lambda one: one[0])[1:]


def solve_damped(at: _Equations, x: list[float]) -> list[float] | None:
    """Solve equations by damped steps of least length; `at` gives residuals and derivatives."""
    found, residuals = _approach(at, x)
    return found if gap_of(residuals) <= ROUNDED else None


def _approach(at: _Equations, x: list[float]) -> tuple[list[float], list[float]]:
    """Values with residuals as small as damped steps make them, and these."""
    residuals, slopes = at(x)
    damping = _DAMPING
    slow = 0
    for _ in range(_ITERATIONS):
        size = math.hypot(*residuals)
        if not math.isfinite(size):
            return x, [math.inf] * len(residuals)
        if gap_of(residuals) <= 0.1 * CLOSED:
            break
        scale = sum(a * a for row in slopes for a in row) / max(len(slopes), 1)
        change = damped_change(slopes, [-a for a in residuals], damping * scale)
        trial = [a + b for a, b in zip(x, change, strict=True)]
        found, table = at(trial)
        if math.hypot(*change) <= _AT_REST:
            break
        left = math.hypot(*found)
        slow = slow + 1 if _SLOW * size < left < size else 0
        if left < size:
            x, residuals, slopes = trial, found, table
            damping *= 0.1
            if slow == _SLOW_STEPS:
                break
        else:
            damping = max(4 * damping, _LEAST_DAMPING)
            if damping > 1e6:
                break
    return x, residuals


@dataclass(frozen=True, slots=True)
class Start:
    """Parameters that may close the start; the moved states by them, and their derivatives."""

    parameters: Sequence[Symbol]
    nodes: Sequence[Node]
    slopes: Sequence[Sequence[Node]]


def closed_start(
    program: Program, conditions: Conditions, start: Start, values: Mapping[Symbol, float]
) -> dict[Symbol, float] | None:
    """Values of the parameters that close the start, near given ones; None where there are none.

    Where the given ones lead nowhere, others at random, farther and farther away, are tried.
    """
    rng = random.Random("starts")
    for k in range(_TRIES if start.parameters else 0):
        near = dict(values)
        for symbol in start.parameters if k else ():
            near[symbol] += 0.1 * 1.5**k * rng.uniform(-1, 1)
        found = _close_start(program, conditions, start, near)
        if found is not None:
            return found
    return None


def _close_start(
    program: Program, conditions: Conditions, start: Start, values: dict[Symbol, float]
) -> dict[Symbol, float] | None:
    """Damped Gauss-Newton steps of the parameters (Levenberg, Marquardt)."""

    fixed = start_values(program, values)

    def at(x: Sequence[float]) -> tuple[list[float], list[list[float]]]:
        point = fixed | dict(zip(start.parameters, x, strict=True))
        numbers = Evaluator(program.dag, point.__getitem__)
        moved = (Symbol(Kind.STATE, k) for k in conditions.moved)
        there = point | dict(zip(moved, numbers.values(start.nodes), strict=True))
        residuals, slopes = conditions.at(program.dag, there)
        columns = list(zip(*(numbers.values(row) for row in start.slopes), strict=True))
        table = [
            [sum(a * b for a, b in zip(row, column, strict=True)) for column in columns]
            for row in slopes
        ]
        return residuals, table

    found = solve_damped(at, [values[symbol] for symbol in start.parameters])
    if found is None:
        return None
    return values | dict(zip(start.parameters, found, strict=True))


def response_at(
    dag: Dag, of: Closures | Responses, point: Point, rows: Sequence[int]
) -> tuple[list[list[float]], list[list[float]]]:
    """`S = G M^-1 G'` of some rows at a point, and the actions of their multipliers."""
    numbers = Evaluator(dag, point.__getitem__)
    actions = [numbers.values(row[k] for k in rows) for row in of.response]
    columns = list(zip(*actions, strict=True)) or [() for _ in rows]
    table = [
        [-sum(map(mul, left, column)) for column in columns]
        for left in (numbers.values(of.by_impulse[k]) for k in rows)
    ]
    return table, actions


def chosen_rows(dag: Dag, closures: Closures, point: Point) -> list[int]:
    """The kept rows with the largest pivots of S at a point, of each chain as many as its rank."""
    found = []
    for chain, rank in enumerate(closures.ranks):
        rows = [k for k, other in enumerate(closures.chain_of) if other == chain]
        if rank < len(rows):
            table, _ = response_at(dag, closures, point, rows)
            order = independent_in(table, [table[k][k] for k in range(len(rows))], 0.0)
            rows = sorted(rows[k] for k in order[:rank])
        found += rows
    return found


def selection(dag: Dag, closures: Closures, chosen: Sequence[int]) -> Point:
    """The selectors of the kept rows where some of them are chosen."""
    symbols = map(dag.symbol_of, closures.selectors)
    return {s: float(k in chosen) for k, s in enumerate(symbols) if s is not None}


def closed_flows(program: Program, point: Point) -> Point:
    """The point with its momenta moved along the multipliers until the closing rows hold.

    These are chosen for the point, and the selectors set. One step does for linear inertias; with
    other laws it is one of Newton's method.
    """
    closures = program.closures
    assert closures is not None
    chosen = chosen_rows(program.dag, closures, point)
    point = point | selection(program.dag, closures, chosen)
    flows = [closures.flows[k] for k in chosen]
    for _ in range(_PROJECTIONS):
        matrix, right = response_at(program.dag, closures, point, chosen)
        rates = [-w for w in evaluate_nodes(program.dag, flows, point)]
        weights = solve_dense(matrix, rates) or [0.0] * len(chosen)
        largest = 0.0
        for k, actions in zip(closures.impulses, right, strict=True):
            change = sum(a * x for a, x in zip(actions, weights, strict=True))
            point[Symbol(Kind.STATE, k)] += change
            moved = abs(point[Symbol(Kind.STATE, k)])
            largest = max(largest, abs(change) / moved if moved else 0.0)
        if not largest > _PROJECTED:
            break
    return point


def closed_points(dag: Dag, conditions: Conditions, start: Point) -> Iterator[Point]:
    """Random configurations; closed ones where there are conditions."""
    rng = random.Random("closed chains")
    states = [symbol for symbol in start if symbol.kind is Kind.STATE]
    tries = (
        start | {symbol: start[symbol] + _SPREAD * rng.uniform(-1, 1) for symbol in states}
        for _ in range(10 * _POINTS)
    )
    found = (closed(dag, conditions, point) if conditions.nodes else point for point in tries)
    return islice((point for point in found if point is not None), _POINTS)


def independent_conditions(table: Sequence[Sequence[float]]) -> list[int]:
    """Conditions that are independent for data in seven digits; their sizes are m, rad and 1."""
    return independent_rows(table, RANK, empty=ROUNDED)
