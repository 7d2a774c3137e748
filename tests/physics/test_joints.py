"""Each joint moves as its free direction should, held in all others; signs and axes."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

INERTIA = np.array([[40.0, 3, -2], [3, 25, 4], [-2, 4, 15]])
TORQUE = 300.0
MASS = 200.0


def kept_energy(result) -> bool:
    return bool(np.abs(result["energy.residual"]).max() < 1e-4)


def test_revolute_opens_about_any_axis(load):
    """A positive torque turns the child by a positive angle about the axis."""
    result = load("joints", "turns").simulate(rtol=1e-9)
    axis = np.array([0.6, 0, 0.8])
    acceleration = TORQUE / (axis @ INERTIA @ axis)
    angle = np.radians(10) + acceleration * result.time**2 / 2
    assert angle[-1] > 2, "it has to turn far"
    np.testing.assert_allclose(result["angle"], angle, rtol=1e-6)
    np.testing.assert_allclose(result["xx"], np.cos(angle) + 0.36 * (1 - np.cos(angle)), atol=1e-5)
    rate = acceleration * result.time[:, None] * axis
    np.testing.assert_allclose(result["twist"][:, 3:], rate, atol=1e-5)
    np.testing.assert_allclose(result["twist"][:, :3], 0, atol=1e-5)
    assert kept_energy(result)


def test_prismatic_extends_along_a_negative_axis(load):
    result = load("joints", "slides").simulate(rtol=1e-9)
    extension = 0.5 + TORQUE / MASS * result.time**2 / 2
    np.testing.assert_allclose(result["extension"], extension, rtol=1e-6)
    expected = extension[:, None] * [0, -1, 0]
    np.testing.assert_allclose(result["d"], expected, atol=1e-6)
    assert kept_energy(result)


def test_spherical_turns_as_eulers_equations_say(load):
    """Centre of mass 0.5 m off the joint along x, a torque about the child's x axis."""
    result = load("joints", "swings").simulate(rtol=1e-9)
    about_joint = INERTIA + MASS * 0.25 * np.diag([0, 1, 1])

    def rates(_, w):
        return np.linalg.solve(about_joint, [TORQUE, 0, 0] - np.cross(w, about_joint @ w))

    exact = solve_ivp(rates, (0, 1), np.zeros(3), t_eval=result.time, rtol=1e-10, atol=1e-12)
    assert np.abs(exact.y[0]).max() > 3
    np.testing.assert_allclose(result["twist"][:, 3:], exact.y.T, atol=1e-4)
    np.testing.assert_allclose(result["d"], 0, atol=1e-4)
    assert kept_energy(result)


def test_free_joint_pushes_along_the_parents_axes(load):
    result = load("joints", "floats").simulate(rtol=1e-9)
    expected = TORQUE / MASS * result.time[:, None] ** 2 / 2 * [1, 0, 0] + [0, 0, 1]
    np.testing.assert_allclose(result["d"], expected, atol=1e-9)
    np.testing.assert_allclose(result["twist"][:, 3:], 0, atol=1e-12)
    assert kept_energy(result)


@pytest.mark.parametrize("joint", ["fixed", "revolute", "prismatic", "spherical"])
def test_a_rigid_lock_is_the_limit_of_a_stiff_one(load, joint):
    stiff, rigid = (load("joints", scene) for scene in (joint, f"rigid_{joint}"))
    assert len(rigid.states) < len(stiff.states)
    one, two = stiff.simulate(), rigid.simulate()
    assert np.ptp(one["centre"], axis=0).max() > 0.5
    np.testing.assert_allclose(one["centre"], two["centre"], atol=2e-5)
    assert kept_energy(two)
