"""Levels of fidelity of a vessel: at rest, guided, in three and in six degrees of freedom."""

from __future__ import annotations

import numpy as np
import pytest
from ships_at_speed import free_horizontally, speed_terms


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    (a, b, c), (s, t, u) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = [[1, 0, 0], [0, a, -s], [0, s, a]]
    about_y = [[b, 0, t], [0, 1, 0], [-t, 0, b]]
    about_z = [[c, -u, 0], [u, c, 0], [0, 0, 1]]
    return np.array(about_z) @ about_y @ about_x


@pytest.mark.parametrize("scene", ["moored", "swell"])
def test_the_deck_moves_as_its_twist_says(load, scene):
    """Central differences of the pose against the twist on the bond, in the deck's axes."""
    result = load("vessel_levels", scene).simulate()
    time, r = result.time, result["r"]
    A = np.stack([[result[f"A[{i},{j}]"] for j in (1, 2, 3)] for i in (1, 2, 3)]).transpose(2, 0, 1)
    step = time[1] - time[0]
    velocity = np.einsum("tji,tj->ti", A[1:-1], (r[2:] - r[:-2]) / (2 * step))
    turning = np.einsum("tji,tjk->tik", A[1:-1], (A[2:] - A[:-2]) / (2 * step))
    spin = np.stack([turning[:, 2, 1], turning[:, 0, 2], turning[:, 1, 0]], axis=1)
    twist = result["twist"][1:-1]
    assert np.ptp(twist, axis=0).min() > 1e-3, "it has to move in every direction"
    np.testing.assert_allclose(velocity, twist[:, :3], atol=1e-4)
    np.testing.assert_allclose(spin, twist[:, 3:], atol=1e-4)


@pytest.mark.parametrize("scene", ["moored", "swell"])
def test_its_books_balance(load, scene):
    result = load("vessel_levels", scene).simulate()
    heave = 0.5 * 12018034.8 * 0.5**2  # what the vessel starts with, or a swell lifts, and more
    assert np.abs(result["energy.residual"]).max() < 1e-6 * heave


def test_at_rest_the_deck_is_where_it_is_put(load):
    result = load("vessel_levels", "still").simulate()
    expected = np.array([3, 4, 0.5]) + rotation(0.3, 0.2, 0.7) @ [-20, 0, 3]
    np.testing.assert_allclose(result["r"], [expected, expected], atol=1e-12)
    assert not result["twist"].any()


def test_a_swell_grows_from_rest(load):
    result = load("vessel_levels", "swell").simulate()
    time = result.time
    grown = 1 - np.exp(-((time / 5) ** 2))
    heave, roll, pitch = (
        size * grown * np.sin(2 * np.pi / 8 * time + phase)
        for size, phase in ((0.8, 0), (0.3, 1), (0.2, 2))
    )
    for k in (0, 300, len(time) - 1):
        turned = rotation(0.1 + roll[k], 0.05 + pitch[k], 0.7) @ [-20, 2, 3]
        expected = np.array([3, 4, 0.5 + heave[k]]) + turned
        np.testing.assert_allclose(result["r"][k], expected, atol=1e-9)
    assert not result["twist"][0].any()


def test_periods_of_three_degrees_of_freedom(load):
    """Eigenvalues of G x = w^2 M x, with the cargo's inertia about the vessel's origin."""
    model = load("vessel_levels", "upright")

    def matrix(name: str, rows: range) -> np.ndarray:
        def entry(i: int, j: int) -> float:
            key = f"vessel.{name}[{i},{j}]"
            return model.parameters[key].value if key in model.parameters else 0.0

        return np.array([[entry(i, j) for j in rows] for i in rows])

    M = matrix("M_RB", range(1, 7)) + matrix("M_A", range(1, 7))
    follow = free_horizontally(M)
    x, z = -20.0, 3.0
    # Twist of the cargo in NED axes; the deck lies aft and above.
    J = np.eye(6)
    J[:3, 3:] = [[0, -z, 0], [z, 0, x], [0, -x, 0]]
    cargo = J.T @ np.diag([50e3, 50e3, 50e3, 1e5, 1e5, 1e5]) @ J
    M = follow.T @ (M + cargo) @ follow
    omega = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, matrix("G", range(1, 4)))).real)
    values = model.eigenvalues()
    found = np.sort(values.imag[values.imag > 1e-6])
    np.testing.assert_allclose(found, np.sort(omega), rtol=1e-6)


def test_heave_alone_is_the_same_in_three_and_six_degrees_of_freedom(load):
    six, three = (load("vessel_levels", s) for s in ("barge", "barge_seakeeping"))
    assert len(three.states) < len(six.states)
    z = six.simulate()["z"]
    assert np.ptp(z) > 0.4
    np.testing.assert_allclose(three.simulate()["z"], z, atol=1e-8)
    # 4e6 z'' + 1e6 z' + 1e7 z = 0 from 0.4 m.
    time = six.simulate().time
    decay, omega = 1e6 / 8e6, np.sqrt(1e7 / 4e6 - (1e6 / 8e6) ** 2)
    expected = (
        0.4 * np.exp(-decay * time) * (np.cos(omega * time) + decay / omega * np.sin(omega * time))
    )
    np.testing.assert_allclose(z, expected, atol=1e-8)


@pytest.mark.parametrize("speed", [0.0, 7.0])
def test_modes_under_way_are_those_of_kirchhoffs_equations(load, speed):
    """Matrices without any symmetry of a hull: every term of speed counts."""
    rng = np.random.default_rng(5)

    def definite(*scales: float) -> np.ndarray:
        drawn = rng.normal(size=(6, 6))
        scale = np.diag(np.sqrt(scales))
        return scale @ (drawn @ drawn.T / 6 + np.eye(6)) @ scale

    A = definite(1e5, 1e6, 2e6, 1e7, 1e8, 1e8)
    D = definite(1e4, 1e4, 1e6, 1e7, 1e8, 1e8)
    M = np.diag([2e6, 2e6, 2e6, 1e8, 1e9, 1e9]) + A
    follow = free_horizontally(M)
    B, C = speed_terms(A, D, follow, speed)
    C += np.diag([1e7, 1e8, 5e9])
    rates = -np.linalg.solve(follow.T @ M @ follow, np.hstack([C, B]))
    expected = np.linalg.eigvals(np.vstack([np.hstack([np.zeros((3, 3)), np.eye(3)]), rates]))
    given = {"vessel.M_A": A, "vessel.D": D, "vessel.speed": speed, "vessel.r0": [0, 0, 0]}
    found = load("vessel_levels", "under_way").eigenvalues(parameters=given)
    np.testing.assert_allclose(
        np.sort_complex(found), np.sort_complex(expected), rtol=1e-5, atol=1e-6
    )
