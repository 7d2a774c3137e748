"""A line between two points: formulas, virtual work, energy."""

import numpy as np
import pytest


def rotations(result, name):
    """Rotation matrices, one a row."""
    columns = [result[f"{name}[{i},{j}]"] for i in (1, 2, 3) for j in (1, 2, 3)]
    return np.stack(columns, axis=1).reshape(-1, 3, 3)


def test_the_rate_and_the_forces_of_a_line_are_those_of_its_points(load):
    result = load("two_point", "between").simulate()
    at_a, at_b = np.array([0.2, 0.1, -0.1]), np.array([-0.3, 0.2, 0.15])
    A_a, A_b = rotations(result, "A_a"), rotations(result, "A_b")
    apart = result["r_b"] + A_b @ at_b - result["r_a"] - A_a @ at_a
    length = np.linalg.norm(apart, axis=1)
    along = apart / length[:, None]
    np.testing.assert_allclose(result["length"], length, rtol=1e-13)

    velocities = []
    for twist, A, at in ((result["twist_a"], A_a, at_a), (result["twist_b"], A_b, at_b)):
        here = twist[:, :3] + np.cross(twist[:, 3:], at)
        velocities.append(np.einsum("tij,tj->ti", A, here))
    rate = np.einsum("ti,ti->t", along, velocities[1] - velocities[0])
    np.testing.assert_allclose(result["rate"], rate, atol=1e-12)
    assert np.ptp(rate) > 0.5

    # What the bodies put into the line: equal and opposite forces along it, at the points.
    for wrench, A, at, sign in (
        (result["wrench_a"], A_a, at_a, -1),
        (result["wrench_b"], A_b, at_b, 1),
    ):
        force = sign * result["pull"][:, None] * np.einsum("tji,tj->ti", A, along)
        scale = np.abs(result["pull"]).max()
        np.testing.assert_allclose(wrench[:, :3], force, atol=1e-12 * scale)
        np.testing.assert_allclose(wrench[:, 3:], np.cross(at, force), atol=1e-12 * scale)

    taken = sum(
        np.einsum("ti,ti->t", result[f"wrench_{k}"], result[f"twist_{k}"]) for k in ("a", "b")
    )
    power = result["pull"] * result["rate"]
    np.testing.assert_allclose(taken, power, atol=1e-12 * np.abs(power).max())
    np.testing.assert_allclose(result["stretch"], length - length[0], atol=1e-7)
    assert np.abs(result["energy.residual"]).max() < 1e-7 * result.counts["exchanged"]


@pytest.mark.parametrize(
    ("a", "b", "offset", "angle0", "rate"),
    [(1.485, 2.831, 0.7869, 0.5, 0.8), (2.955, 1.002, -2.4, 0.3, -0.4), (1, 1, 1.5, 0, 0.3)],
)
def test_the_triangle_has_its_formulas_and_is_the_line_between_the_frames(
    load, a, b, offset, angle0, rate
):
    given = {"a": a, "b": b, "offset": offset, "angle0": angle0, "rate": rate}
    result = load("two_point", "boom").simulate(parameters=given)
    between = result["angle"] + offset
    length = np.sqrt(a * a + b * b - 2 * a * b * np.cos(between))
    lever = a * b * np.sin(between) / length
    np.testing.assert_allclose(result["length"], length, rtol=1e-12)
    np.testing.assert_allclose(result["leverage"], lever, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(result["straight"], length, rtol=1e-12)
    np.testing.assert_allclose(result["straight_rate"], lever * rate, atol=1e-12)
    np.testing.assert_allclose(result["rate_of_length"], lever * rate, atol=1e-12)
    work = result["torque"] * result["angle_rate"] - result["pull"] * result["rate_of_length"]
    scale = np.abs(result["pull"] * result["rate_of_length"]).max()
    np.testing.assert_allclose(work, 0, atol=1e-12 * scale)
    moved = np.gradient(length, result["angle"], edge_order=2)
    np.testing.assert_allclose(lever[2:-2], moved[2:-2], atol=2e-4)
    assert np.abs(result["energy.residual"]).max() < 1e-8 * max(result.counts["exchanged"], 1)
