"""Published initial value problems as plain equations, to the digits that their tolerance promises.

`tests/models/ivp/references.json` holds the values at the end, with their sources; those that no
test set publishes are from `references.py` beside it.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp

import bgc
from bgc.runtime.model import Model

FOLDER = Path(__file__).parents[1] / "models" / "ivp"
REFERENCES = json.loads((FOLDER / "references.json").read_text())
STIFF = ("rodas5p", "rodas4p2", "radau5")
NOT_STIFF = (
    "pleiades", "arenstorf", "five_bodies", "euler_pulse",
    "detest_f1", "detest_f2", "detest_f3", "detest_f4",
)  # fmt: skip

# What the states amount to where that is not 1: atol is so much of rtol.
SIZES = {
    "robertson": 1e-9, "e5": 1e-17, "hires": 1e-3, "pollution": 1e-2, "chemical_akzo": 1e-2,
    "stiff_pendulum": 1e-2, "plate": 1e-3, "ring_modulator": 1e-4, "robertson_dae": 1e-5,
    "reactor": 1e-4, "detest_f4": 1e-9,
}  # fmt: skip
# How much an error grows up to the end where that is more than 40: close encounters, a modulator
# whose diodes switch, an oscillator that grows, kinks that no event is raised for.
GROWTH = {
    "pleiades": 2e3, "arenstorf": 1e5, "ring_modulator": 200, "detest_f1": 300, "detest_f3": 200,
    "squeezer": 80,
}  # fmt: skip
# Rounding spoils the last digits of E5, whose rates cancel in 17 digits; the modulator takes long.
# So do the fastest modes of the beam, which only error control damps.
TOLERANCES = {"e5": (1e-4, 1e-6), "ring_modulator": (1e-4, 1e-6), "beam": (1e-4, 1e-6)}

CASES = [
    (name, solver)
    for name in REFERENCES
    for solver in (*STIFF, *(("dopri5",) if name in NOT_STIFF else ()))
]


@cache
def compiled(name: str) -> Model:
    return bgc.compile(FOLDER / f"{name}.bg")


def error(name: str, solver: str, rtol: float) -> float:
    """The worst component's error at the end over atol + rtol |y|."""
    atol = rtol * SIZES.get(name, 1.0)
    result = compiled(name).simulate(solver=solver, rtol=rtol, atol=atol)
    end = REFERENCES[name]["end"]
    exact = np.array(list(end.values()))
    found = np.array([result[column][-1] for column in end])
    return float((np.abs(found - exact) / (atol + rtol * np.abs(exact))).max())


@pytest.mark.parametrize(("name", "solver"), CASES)
def test_digits_are_those_of_the_tolerance(name: str, solver: str) -> None:
    for rtol in TOLERANCES.get(name, (1e-5, 1e-8)):
        assert error(name, solver, rtol) < GROWTH.get(name, 40)


def against_scipy(name: str, rates, start, end: float) -> None:
    """Compare `u` and `v` at the end with SciPy's Radau."""
    result = compiled(name).simulate(rtol=1e-9, atol=1e-11)
    exact = solve_ivp(rates, (0, end), start, "Radau", rtol=1e-9, atol=1e-11)
    found = np.concatenate([result["u"][-1], result["v"][-1]])
    np.testing.assert_allclose(found, exact.y[:, -1], rtol=1e-7, atol=1e-9)


def test_brusselator_with_diffusion() -> None:
    n, alpha = 20, 1 / 50
    x = np.arange(1, n + 1) / (n + 1)

    def rates(_: float, y: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        u, v = y[:n], y[n:]
        spread = alpha * (n + 1) ** 2
        du = 1 + u**2 * v - 4 * u + spread * np.diff(np.concatenate([[1], u, [1]]), 2)
        dv = 3 * u - u**2 * v + spread * np.diff(np.concatenate([[3], v, [3]]), 2)
        return np.concatenate([du, dv])

    against_scipy("brusselator", rates, np.r_[1 + np.sin(2 * np.pi * x), 3 * np.ones(n)], 10)


def test_medical_akzo_switches_its_supply_off_and_needs_no_pivoting() -> None:
    """Values of the test set for y79, y199 and y200; underflow is not a fault of the pivots."""
    result = compiled("medical_akzo").simulate(rtol=1e-7, atol=1e-9)
    found = [result["u[40]"][-1], result["u[100]"][-1], result["v[100]"][-1]]
    exact = [0.2339942217046434e-3, 0.11737412926802e-3, 0.61908071460151e-5]
    np.testing.assert_allclose(found, exact, rtol=1e-5, atol=1e-9)
    assert result.counts["events"] == 1
    assert result.counts["fallbacks"] == 0


def test_a_tolerance_near_rounding_is_met_or_refused() -> None:
    """A step's second start must stay on what the capacitors hold: it once did not, silently."""
    try:
        result = compiled("transistor_amplifier").simulate(rtol=1e-9, atol=1e-13)
    except bgc.SimulationError as refused:
        assert refused.diagnostics[0].code == "BG701"
    else:
        exact = list(REFERENCES["transistor_amplifier"]["end"].values())
        np.testing.assert_allclose(result["y"][-1], exact, rtol=0, atol=1e-9)


@pytest.mark.parametrize("solver", STIFF)
@pytest.mark.parametrize("rtol", [1e-4, 1e-5])
def test_gates_at_rest_are_no_events(solver: str, rtol: float) -> None:
    """Voltages that come to rest at the switch of a transistor are noise: 550,000 steps once."""
    result = compiled("nand").simulate(solver=solver, rtol=rtol, atol=rtol)
    assert result.counts["steps"] < 3000
