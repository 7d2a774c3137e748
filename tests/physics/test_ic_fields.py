"""IC fields: a double pendulum and a condenser microphone given by their energies.

The pendulum is integrated independently in its two point masses' Cartesian coordinates:
`J' m (J q'' + J' q') = J' F`, which knows neither momenta nor dT/dq.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

MASSES = np.diag([1, 1, 0.5, 0.5])
WEIGHT = np.array([0, -9.81, 0, -4.905])


def points(q, rates):
    """The Jacobian of the two points, and its rate times the joint rates."""
    (a, b), (u, v) = (q[0], q[0] + q[1]), (rates[0], rates[0] + rates[1])
    upper = np.array([np.cos(a), np.sin(a)])
    lower = 0.8 * np.array([np.cos(b), np.sin(b)])
    jacobian = np.zeros((4, 2))
    jacobian[:2, 0] = upper
    jacobian[2:, 0] = upper + lower
    jacobian[2:, 1] = lower
    inward = u**2 * np.array([-np.sin(a), np.cos(a)])
    return jacobian, np.concatenate(
        [inward, inward + v**2 * 0.8 * np.array([-np.sin(b), np.cos(b)])]
    )


def mass_and_force(q, rates):
    jacobian, turning = points(q, rates)
    return jacobian.T @ MASSES @ jacobian, jacobian.T @ (WEIGHT - MASSES @ turning)


def integrated(acceleration, times, start):
    def rates(t, y):
        return np.concatenate([y[2:], acceleration(t, y[:2], y[2:])])

    start = np.concatenate([[1, 0.5], start])
    return solve_ivp(
        rates, (0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-12, atol=1e-12
    ).y.T


def free(t, q, rates):
    return np.linalg.solve(*mass_and_force(q, rates))


def geared(t, q, rates):
    mass, force = mass_and_force(q, rates)
    mass[0, 0] += 0.002 * 30**2
    force[1] -= 0.3 * rates[1]
    return np.linalg.solve(mass, force)


def driven(t, q, rates):
    mass, force = mass_and_force(q, rates)
    first = 3 * np.cos(3 * t)
    return np.array([first, (force[1] - mass[1, 0] * first) / mass[1, 1]])


@pytest.mark.parametrize(
    ("scene", "acceleration", "states"),
    [("free", free, 4), ("geared", geared, 4), ("driven", driven, 3)],
)
def test_an_arm_given_by_its_energy_moves_as_its_points(load, scene, acceleration, states):
    model = load("ic_fields", scene)
    assert len(model.states) == states
    result = model.simulate()
    expected = integrated(acceleration, result["time"], [0, 0])
    assert np.abs(expected[-1, :2] - expected[0, :2]).max() > 0.3
    np.testing.assert_allclose(result["q"], expected[:, :2], atol=2e-7)
    assert np.abs(result["residual"]).max() < 1e-7


def test_the_drive_of_a_moved_joint_bears_its_torque(load):
    result = load("ic_fields", "driven").simulate()
    expected = integrated(driven, result["time"], [0, 0])
    torques = []
    for t, y in zip(result["time"], expected, strict=True):
        mass, force = mass_and_force(y[:2], y[2:])
        torques.append((mass @ driven(t, y[:2], y[2:]) - force)[0])
    np.testing.assert_allclose(result["torque"], torques, atol=1e-5)


def test_a_microphone_shares_its_charge_and_its_plate_moves_with_the_dust(load):
    """Plate and dust of 3 g, drawn by its charge: the two capacitors keep 0.48 C between them."""
    result = load("ic_fields", "microphone").simulate()

    def rates(t, y):
        share = 0.48 * 2 / (2 + 1 + 20 * y[0])
        return [y[1], (-300 * y[0] - 10 * share**2) / 0.003]

    times = result["time"]
    expected = solve_ivp(
        rates,
        (0, times[-1]),
        [0.01, 0.05 / 0.002],
        method="DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-12,
    ).y.T
    np.testing.assert_allclose(result["q"][:, 0], expected[:, 0], atol=1e-6)
    np.testing.assert_allclose(result["q"][:, 1] + result["stray"], 0.48, rtol=1e-12)
    assert np.abs(result["residual"]).max() < 1e-6
