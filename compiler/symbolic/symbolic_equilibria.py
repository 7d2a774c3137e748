"""Equilibria in letters: the states at which all right-hand sides vanish.

The equations are put into the order in which they can be solved: each is matched to an unknown,
and the sets that depend on each other are solved one after the other. A set that is linear in its
unknowns is solved exactly; one equation in one unknown by SymPy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy
from sympy.solvers.solveset import NonlinearError, linsolve

from bgc.algebra.matching import match
from bgc.algebra.strong_components import all_components
from bgc.symbolic.letters import positive_letters

_MOST_OPERATIONS = 200  # operations of a nonlinear equation that SymPy is asked to solve


class NoFormula(Exception):
    """No formula was found for the states `states`."""

    def __init__(self, states: Sequence[sympy.Symbol]) -> None:
        super().__init__()
        self.states = tuple(states)


def solve_equilibrium(
    equations: Sequence[sympy.Expr],
    unknowns: Sequence[sympy.Symbol],
    near: Mapping[sympy.Symbol, float],
) -> dict[sympy.Symbol, sympy.Expr]:
    """Solve `equations = 0` for as many unknowns.

    Parameters
    ----------
    near
        A number for each letter, unknowns included: of several solutions the one is taken that is
        nearest to the unknown's number. Letters with a positive number are taken as positive.

    Raises
    ------
    NoFormula
        A set of equations cannot be solved for its unknowns, or not uniquely.
    """
    positive = positive_letters(near)
    plain = {dummy: x for x, dummy in positive.items()}
    numbers = {positive.get(x, x): n for x, n in near.items()}
    of = {x: positive.get(x, x) for x in unknowns}
    residuals = [e.xreplace(positive) for e in equations]
    places = {of[x]: k for k, x in enumerate(unknowns)}
    held = [sorted(places[x] for x in e.free_symbols if x in places) for e in residuals]
    column_of = match(held, {})
    free = [x for k, x in enumerate(unknowns) if k not in column_of.values()]
    if free:
        raise NoFormula(free)
    row_of = {column: row for row, column in column_of.items()}
    solved: dict[sympy.Symbol, sympy.Expr] = {}
    for part in all_components(range(len(unknowns)), lambda c: held[row_of[c]]):
        chosen = [of[unknowns[c]] for c in part]
        rows = [residuals[row_of[c]].xreplace(solved) for c in part]
        try:
            solved.update(_solve(rows, chosen, numbers))
        except NoFormula:
            raise NoFormula([unknowns[c] for c in part]) from None
    return {x: solved[of[x]].xreplace(plain) for x in unknowns}


def _solve(
    equations: Sequence[sympy.Expr],
    unknowns: Sequence[sympy.Symbol],
    numbers: Mapping[sympy.Symbol, float],
) -> dict[sympy.Symbol, sympy.Expr]:
    try:
        (found,) = linsolve(list(equations), list(unknowns)) or ((),)
    except NonlinearError:
        return _solve_one(equations, unknowns, numbers)
    if not found or any(e.free_symbols & set(unknowns) for e in found):
        raise NoFormula(unknowns)
    return dict(zip(unknowns, map(sympy.cancel, found), strict=True))


def _solve_one(
    equations: Sequence[sympy.Expr],
    unknowns: Sequence[sympy.Symbol],
    numbers: Mapping[sympy.Symbol, float],
) -> dict[sympy.Symbol, sympy.Expr]:
    if len(unknowns) > 1 or equations[0].count_ops() > _MOST_OPERATIONS:
        raise NoFormula(unknowns)
    (equation,), (unknown,) = equations, unknowns
    try:
        found = sympy.solve(equation, unknown, check=False)
    except NotImplementedError:
        raise NoFormula(unknowns) from None
    near = numbers[unknown]
    distances: list[tuple[float, sympy.Expr]] = []
    for solution in found:
        value = complex(solution.xreplace(_exact(numbers)).evalf())
        residual = equation.xreplace({unknown: solution}).xreplace(_exact(numbers)).evalf()
        if abs(value.imag) <= 1e-12 * abs(value) and abs(complex(residual)) <= 1e-9:
            distances.append((abs(value.real - near), solution))
    if not distances:
        raise NoFormula(unknowns)
    return {unknown: min(distances, key=lambda pair: pair[0])[1]}


def _exact(numbers: Mapping[sympy.Symbol, float]) -> dict[sympy.Symbol, sympy.Float]:
    return {x: sympy.Float(n, 30) for x, n in numbers.items()}
