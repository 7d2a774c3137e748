"""What is asserted of every program: the power balance at a random state.

The rate of the stored energy along the derived equations has to equal what sources supply less
what resistors dissipate. A slip of a sign anywhere between the graph and the equations breaks it.
"""

from __future__ import annotations

import math
import random

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.derivatives import gradient
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.newton import Rows
from bgc.equations.loops.start import algebraic_rows
from bgc.ir.defaults import default_values
from bgc.ir.program import Program

_TOLERANCE = 1e-6  # of all powers; far above rounding, far below a slip
_REST = 1e-9  # of the stored energy in a second: less power than that is rounding


def power_defect(program: Program) -> float | None:
    """The defect of the power balance relative to the powers; None where it says nothing.

    It says nothing unless the scene needs all accounts, where a function is not defined at the
    random state or algebraic equations have no solution there, and where a mass matrix couples
    rates.
    """
    if len(program.scene.needed_accounts) < 3 or _couples_rates(program):
        return None
    dag, energy = program.dag, program.energy
    values = _random_point(program)
    if values is None:
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
    *powers, stored = evaluate_nodes(dag, [*shares, energy.stored], values)
    size = sum(map(abs, powers)) + _REST * abs(stored)
    if not math.isfinite(size):
        return None
    return abs(sum(powers)) / size if size else 0.0


def _couples_rates(program: Program) -> bool:
    """Whether rates do not stand by themselves, or the energy is that of algebraic states too."""
    one = program.dag.one
    if any(m.row != m.column or m.value != one for m in program.mass or ()):
        return True
    implicit = {program.dag.symbol(Kind.STATE, k) for k in algebraic_rows(program)}
    return not implicit.isdisjoint(program.dag.reachable([program.energy.stored]))


def _random_point(program: Program) -> dict[Symbol, float] | None:
    """Values of all symbols: random, but on the algebraic equations; None where that fails."""
    rng = random.Random(1)
    values: dict[Symbol, float] = dict(default_values(program.dag, program.parameters))
    values[Symbol(Kind.TIME, 0)] = rng.uniform(0.1, 1)
    for k in range(program.inputs):
        values[Symbol(Kind.INPUT, k)] = rng.uniform(-1, 1)
    for k in range(len(program.states)):
        values[Symbol(Kind.STATE, k)] = rng.uniform(-1, 1)
    rows = algebraic_rows(program)
    if not rows:
        return values
    unknowns = [Symbol(Kind.STATE, k) for k in rows]
    equations = Rows(program.dag, [program.states[k].derivative for k in rows], unknowns)
    found = equations.solve(values, [values[u] for u in unknowns])
    return None if found is None else values | dict(zip(unknowns, found, strict=True))


def assert_power_balance(program: Program) -> None:
    """Fail, as a bug of the compiler's, where the balance is broken."""
    defect = power_defect(program)
    assert defect is None or defect < _TOLERANCE, f"power balance broken by {defect:.1e}"
