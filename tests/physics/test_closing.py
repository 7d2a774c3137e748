"""Joints between bodies that each integrate their pose: the gap stays closed, at any stiffness."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bgc.runtime.model import Model

Load = Callable[[str, str | None], Model]

METHODS = [("rodas5p", None), ("ros34prw", 1e-3)]
EXCHANGED = 970.0  # J: the pendulum's weight over its swing


@pytest.mark.parametrize(("solver", "step"), METHODS)
def test_poses_do_not_drift_apart_in_a_thousand_seconds(
    load: Load, solver: str, step: float | None
) -> None:
    result = load("closing", None).simulate(1000, every=10, solver=solver, step=step)
    drift = result["drift"]
    assert drift.max() < 1e-7
    assert drift[50:].max() < 2 * drift[:50].max()  # it is bounded, not only small
    assert np.abs(result["energy.residual"]).max() < 1e-5 * EXCHANGED


def test_without_the_correction_they_do(load: Load) -> None:
    """Linearly implicit Euler at 1 ms: 20 cm in 100 s, and 5 mm with it."""

    def drift(closing_time: float) -> float:
        given = {"closing_time": closing_time}
        result = load("closing", None).simulate(100, solver="lie", step=1e-3, parameters=given)
        return float(result["drift"][-1])

    assert drift(1e12) > 0.1
    assert drift(2.0) < 0.01


def test_the_start_of_a_gap_closes_with_the_closing_time(load: Load) -> None:
    """q starts at zero where the poses leave 1 mm: q - gap falls as exp(-t/T)."""
    given = {"bob.r0[1]": 1.001, "closing_time": 0.5}
    result = load("closing", None).simulate(2, every=0.5, rtol=1e-9, parameters=given)
    expected = 1e-3 * np.exp(-result.time / 0.5)
    np.testing.assert_allclose(result["drift"], expected, rtol=1e-3)


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e10, 1e12])
def test_accuracy_is_the_same_at_every_stiffness(load: Load, stiffness: float) -> None:
    """Against tight steps, and against the rigid pendulum (140 kg m^2 about its pivot) as 1/k."""
    model = load("closing", None)
    given = {"stiffness": stiffness}
    tight = model.simulate(5, every=1, rtol=1e-11, parameters=given)
    found = model.simulate(5, every=1, solver="ros34prw", step=1e-3, parameters=given)
    np.testing.assert_allclose(found["place"], tight["place"], rtol=0, atol=1e-6)
    rigid = solve_ivp(
        lambda _, y: [y[1], -100 * 9.81 / 140 * np.cos(y[0])],
        (0, 5),
        [0, 0],
        rtol=1e-10,
        atol=1e-12,
    )
    expected = [np.cos(rigid.y[0, -1]), 0, np.sin(rigid.y[0, -1])]
    np.testing.assert_allclose(tight["place"][-1], expected, rtol=0, atol=5e4 / stiffness + 1e-6)
