"""Closure equations whose pivots vanish, or which have several solutions."""

import numpy as np
import pytest
from scipy.optimize import root

METHODS = [("rodas5p", None), ("rodas4p2", None), ("radau5", None), ("gauss4", 0.01)]
METHODS += [("ros34prw", 0.01)]


@pytest.mark.parametrize(("solver", "step"), METHODS)
def test_equations_are_solved_where_static_pivots_vanish(load, solver, step):
    result = load("linkages", "turning_pivots").simulate(solver=solver, step=step)
    for time, a, b in zip(result.time, result["a"], result["b"], strict=True):
        s = np.sin(np.sin(time))
        exact = root(
            lambda v, s=s: (
                s * v[0] + v[1] + 0.1 * v[1] ** 3 - 1,
                v[0] + 0.1 * v[0] ** 3 - s * v[1] - 0.5,
            ),
            (a, b),
            tol=1e-12,
        ).x
        np.testing.assert_allclose((a, b), exact, rtol=1e-5)


@pytest.mark.parametrize(("solver", "step"), METHODS)
def test_steps_stay_on_one_branch_of_a_linkage(load, solver, step):
    result = load("linkages", "slider_crank").simulate(solver=solver, step=step)
    exact = np.arcsin(np.sin(result["crank"]) / 3)
    np.testing.assert_allclose(result["angle"], exact, atol=1e-9)
    np.testing.assert_allclose(
        result["slide"], np.cos(result["crank"]) + 3 * np.cos(exact), atol=1e-9
    )
