"""The power balance of the derived equations, asserted for every program at a random state.

The rate of the stored energy along the equations has to equal the power of the sources less the
power of the resistors. Any wrong sign between the graph and the equations breaks the balance.
"""

from __future__ import annotations

import math
import random
import sys
from collections.abc import Mapping

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.derivatives import gradient
from bgc.algebra.evaluate import Evaluator, evaluate_nodes
from bgc.algebra.newton import Rows
from bgc.equations.closures.manifold import closed_flows
from bgc.equations.loops.start import algebraic_rows
from bgc.ir.defaults import program_values
from bgc.ir.program import Program

_POWER_TOLERANCE = 1e-6  # of all powers; far above rounding, far below the effect of a wrong sign
_REST = 1e-9  # of the stored energy in a second: less power than that is rounding
_CANCELLED = (
    1e-8  # of the powers of single sources and resistors: less is what rounding leaves of them
)
_ROUNDINGS = 4  # random perturbations, which separate a broken balance from rounding
_EXPLAINED = 10.0  # of the differences between them: a larger sum is not rounding
_SOLVED = 1e-9  # of the powers that unsolved unknowns have: less is the error of their solution


def power_defect(program: Program) -> float | None:
    """The defect of the power balance, relative to the powers; None where it is not defined.

    It is defined only if the scene needs all accounts, every function has a value at the random
    state, the algebraic equations have a solution there, and the mass matrix does not couple rates.
    It is not defined where all digits of the balance are rounding.
    """
    if len(program.scene.needed_accounts(bool(program.jumps))) < 3 or _couples_rates(program):
        return None
    dag, energy = program.dag, program.energy
    points = _random_points(program)
    if points is None:
        return None
    implicit = set(algebraic_rows(program))
    explicit = [k for k in range(len(program.states)) if k not in implicit]
    moving = [dag.symbol(Kind.STATE, k) for k in explicit]
    rates = [program.states[k].derivative for k in explicit]
    moving.append(dag.symbol(Kind.TIME))
    rates.append(dag.one)
    slopes = gradient(dag, energy.stored, moving)
    shares = [dag.mul(slope, rate) for slope, rate in zip(slopes, rates, strict=True)]
    shares += [dag.neg(energy.supplied), energy.dissipated]
    single = [*_terms(dag, energy.supplied), *_terms(dag, energy.dissipated)]
    unsolved, solved = (
        evaluate_nodes(dag, [*shares, energy.stored, *single], x) for x in points[:2]
    )
    powers, (stored, *parts) = solved[: len(shares)], solved[len(shares) :]
    size = sum(map(abs, powers)) + _REST * abs(stored) + _CANCELLED * sum(map(abs, parts))
    typical = sum(map(abs, unsolved[: len(shares)])) if implicit else 0.0
    if math.isfinite(typical):
        size += _SOLVED * typical
    if not math.isfinite(size):
        return None
    defect = abs(sum(powers)) / size if size else 0.0
    if defect >= _POWER_TOLERANCE:
        left = [sum(_Rounding(dag, points[k % 2 + 1], k).values(shares)) for k in range(_ROUNDINGS)]
        if not max(map(abs, left)) > _EXPLAINED * (max(left) - min(left)):
            return None
    return defect


class _Rounding(Evaluator):
    """Values with random roundings of a unit in the last place in each operation.

    Where these change a sum by as much as it amounts to, it is rounding (J. Vignes, stochastic
    arithmetic).
    """

    def __init__(self, dag: Dag, point: Mapping[Symbol, float], seed: int) -> None:
        super().__init__(dag, point.__getitem__)
        self._random = random.Random(seed)

    def _rounded(self, value: float) -> float:
        return value * (1.0 + sys.float_info.epsilon * self._random.uniform(-1, 1))

    def _from_leaf(self, value: float) -> float:
        return self._rounded(value)

    def _from_operands(self, op: int, operands: list[float]) -> float:
        return self._rounded(self._apply(op, operands))


def _terms(dag: Dag, total: int) -> list[int]:
    """The terms of a sum, each once."""
    found, seen, open_ = [], {total}, [total]
    while open_:
        node = open_.pop()
        if Op(dag.op[node]) in {Op.ADD, Op.SUB, Op.NEG}:
            fresh = [n for n in dag.operands(node) if n not in seen]
            seen.update(fresh)
            open_ += fresh
        else:
            found.append(node)
    return found


def _couples_rates(program: Program) -> bool:
    """Return whether the mass matrix couples rates, or the energy depends on algebraic states."""
    one = program.dag.one
    if any(m.row != m.column or m.value != one for m in program.mass or ()):
        return True
    implicit = {program.dag.symbol(Kind.STATE, k) for k in algebraic_rows(program)}
    return not implicit.isdisjoint(program.dag.reachable([program.energy.stored]))


def _random_points(program: Program) -> list[dict[Symbol, float]] | None:
    """Random values of all symbols, then twice with unknowns that satisfy the algebraic equations.

    The two solutions begin from different values; they differ by the error of the solution. None
    where none is found.
    """
    rng = random.Random(1)
    values: dict[Symbol, float] = program_values(program)
    values[Symbol(Kind.TIME, 0)] = rng.uniform(0.1, 1)
    for k in range(program.inputs):
        values[Symbol(Kind.INPUT, k)] = rng.uniform(-1, 1)
    for k in range(len(program.states)):
        values[Symbol(Kind.STATE, k)] = rng.uniform(-1, 1)
    rows = algebraic_rows(program)
    if program.closures is not None:
        values = closed_flows(program, values)
    if not rows:
        return [values, values, values]
    unknowns = [Symbol(Kind.STATE, k) for k in rows]
    equations = Rows(program.dag, [program.states[k].derivative for k in rows], unknowns)
    points = [values]
    for scale in (1.0, 0.9):
        found = equations.solve(values, [scale * values[u] for u in unknowns])
        if found is None:
            return None
        points.append(values | dict(zip(unknowns, found, strict=True)))
    return points


def assert_power_balance(program: Program) -> None:
    """Raise AssertionError, a bug in bgc, where the balance does not hold."""
    defect = power_defect(program)
    assert defect is None or defect < _POWER_TOLERANCE, f"power balance broken by {defect:.1e}"
