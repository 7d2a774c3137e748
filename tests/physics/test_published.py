"""Published problems with a closed form or a solution by other means: `tests/models/ivp`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import bgc
from bgc.runtime.model import Model

FOLDER = Path(__file__).parents[1] / "models" / "ivp"
STIFF = ("rodas5p", "rodas4p2", "radau5")
ALL = (*STIFF, "dopri5")

End = dict[str, float]


@cache
def compiled(name: str) -> Model:
    return bgc.compile(FOLDER / f"{name}.bg")


def relaxation() -> End:
    """Digits of the test set, scaled back."""
    return {"x": 1.706167732170469, "v": -0.8928097010248125e-3}


def finite_elements() -> End:
    """A sine stays one: of tridiagonal Toeplitz matrices it is an eigenvector."""
    h = np.pi / 10
    rate = (2 * np.cos(h) - 2) / h / (h / 6 * (4 + 2 * np.cos(h)))
    left = np.exp(rate * np.expm1(np.pi))
    return {f"y[{i}]": float(np.sin(i * h) * left) for i in range(1, 10)}


def heat_square() -> End:
    """The start is a product of parabolas, and so is the solution one of their decays."""
    x = np.linspace(0, 1, 20)
    second = 19**2 * (np.diag(-2 * np.ones(18)) + np.eye(18, k=1) + np.eye(18, k=-1))
    rates, modes = np.linalg.eigh(second)
    inside = modes @ (np.exp(0.16 * rates) * (modes.T @ (4 * x * (1 - x))[1:-1]))
    decayed = np.concatenate([[0.0], inside, [0.0]])
    exact = np.outer(decayed, decayed)
    return {f"u[{i + 1},{j + 1}]": exact[i, j] for i in range(20) for j in range(20)}


def kepler() -> End:
    """By Kepler's equation."""
    e = 0.9
    anomaly = brentq(lambda a: a - e * np.sin(a) - 20, 19, 21, xtol=1e-15, rtol=1e-15)
    c, s, minor = np.cos(anomaly), np.sin(anomaly), np.sqrt(1 - e**2)
    far = 1 - e * c
    return {"r[1]": c - e, "r[2]": minor * s, "v[1]": -s / far, "v[2]": minor * c / far}


def chapman() -> End:
    """SciPy's Radau from one sunrise or sunset to the next."""

    def rates(sunny: bool) -> Callable[[float, np.ndarray], list[float]]:
        def f(t: float, y: np.ndarray) -> list[float]:
            sun = max(np.sin(np.pi / 43200 * t), 1e-300) if sunny else 1e-300
            k3, k4 = np.exp(-22.62 / sun), np.exp(-7.601 / sun)
            formed, lost = 1.63e-16 * y[0] * 3.7e16, 4.66e-16 * y[0] * y[1]
            return [2 * k3 * 3.7e16 + k4 * y[1] - formed - lost, formed - lost - k4 * y[1]]

        return f

    y = np.array([1e6, 1e12])
    for half in range(20):
        times = (43200 * half, 43200 * (half + 1))
        y = solve_ivp(rates(half % 2 == 0), times, y, "Radau", rtol=1e-9, atol=1e-3).y[:, -1]
    return {"O": 0.0, "O3": float(y[1])}


def lane_emden() -> End:
    """Published."""
    square = 1 + 100 / 3
    return {"y": square**-0.5, "v": -10 / 3 * square**-1.5}


# Problem -> the end, methods, tolerances, and the most that the error may be of a tolerance. The
# orbit carries an error along itself, the last jump one of time.
PROBLEMS = {
    "relaxation": (relaxation, STIFF, (1e-5, 1e-8, 1e-11), 20),
    "finite_elements": (finite_elements, STIFF, (1e-5, 1e-9), 1),
    "heat_square": (heat_square, ALL, (1e-5, 1e-8), 1),
    "kepler": (kepler, ALL, (1e-5, 1e-8, 1e-12), 2000),
    "lane_emden": (lane_emden, ALL, (1e-5, 1e-8, 1e-11), 1),
    "chapman": (chapman, STIFF, (1e-4, 1e-6), 5),
}
CASES = [(name, solver) for name, (_, solvers, _, _) in PROBLEMS.items() for solver in solvers]


@cache
def end_of(name: str) -> End:
    return PROBLEMS[name][0]()


@pytest.mark.parametrize(("name", "solver"), CASES)
def test_digits_are_those_of_the_tolerance(name: str, solver: str) -> None:
    """At tight tolerances too: steps of a jump may be beside the time what rounding is."""
    _, _, tolerances, most = PROBLEMS[name]
    exact = np.array(list(end_of(name).values()))
    for rtol in tolerances:
        result = compiled(name).simulate(solver=solver, rtol=rtol, atol=rtol)
        found = np.array([result[column][-1] for column in end_of(name)])
        assert (np.abs(found - exact) / (rtol + rtol * np.abs(exact))).max() < most


def test_each_sunrise_and_sunset_is_an_event() -> None:
    assert compiled("chapman").simulate(rtol=1e-4, atol=1e-4).counts["events"] >= 19


def test_the_rim_of_the_square_is_algebraic() -> None:
    result = compiled("heat_square").simulate(rtol=1e-6, atol=1e-6)
    assert result["u[1,7]"][-1] == 0.0
