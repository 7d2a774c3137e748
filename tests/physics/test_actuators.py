"""Drives on a joint's shaft."""

import numpy as np
from scipy.integrate import solve_ivp


def test_a_rate_servo_reaches_its_rate_within_its_torque(load):
    result = load("actuators", "servo").simulate(rtol=1e-8)
    rate = result["rate"]
    np.testing.assert_allclose(rate[-1], 0.5, rtol=1e-4)
    np.testing.assert_allclose(rate[5], 20 / 50 * 0.5, rtol=1e-3)  # at first at its limit
    assert np.diff(rate).min() > -1e-9


def test_a_cylinder_pushes_by_the_derivative_of_its_stroke(load):
    """Energy: the work of a constant force over the stroke is the load's kinetic energy."""
    result = load("actuators", "cylinder").simulate()
    a, b, start = 1, 0.5, np.radians(60)

    def length(angle):
        return np.sqrt(a * a + b * b - 2 * a * b * np.cos(angle + start))

    def rates(_, state):
        angle, rate = state
        return [rate, 100 * a * b * np.sin(angle + start) / length(angle) / 50]

    exact = solve_ivp(rates, (0, 2), [0, 0], t_eval=result.time, rtol=1e-10, atol=1e-12)
    assert exact.y[0, -1] > 0.5
    np.testing.assert_allclose(result["angle"], exact.y[0], atol=1e-6)
    np.testing.assert_allclose(result["stroke"], length(exact.y[0]), atol=1e-6)
    work = 100 * (length(result["angle"]) - length(0))
    np.testing.assert_allclose(25 * result["rate"] ** 2, work, atol=1e-5)
