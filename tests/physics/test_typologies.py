"""Jacobian typologies: tip velocity J q' and torque J' F from one transformer."""

import numpy as np
import pytest

CASES = {
    "planar": ([0.7, -0.4], [30, -20]),
    "slewing": ([0.7, -0.4, 0.9], [30, -20, 50]),
    "telescoping": ([0.7, -0.4, 0.9], [30, -20, 50]),
}


@pytest.mark.parametrize("scene", CASES)
def test_the_jacobian_is_the_derivative_of_the_position(load, scene):
    result = load("typologies", scene).simulate()
    moved = result["position"] - result["position"][0]
    assert np.abs(moved).max() > 0.5
    np.testing.assert_allclose(result["travelled"], moved, atol=1e-8)


@pytest.mark.parametrize("scene", CASES)
def test_torque_is_its_transpose_times_the_force(load, scene):
    """At any rates, so the powers agree: q' . J'F = F . J q'."""
    rates, force = CASES[scene]
    result = load("typologies", scene).simulate()
    np.testing.assert_allclose(result["torque"] @ rates, result["velocity"] @ force, rtol=1e-12)


def test_closed_forms_at_the_start(load):
    planar = load("typologies", "planar").observe()
    a, b = 0.3, 0.8
    assert planar["position[1]"] == pytest.approx(2 * np.cos(a) + 1.5 * np.cos(b))
    assert planar["position[2]"] == pytest.approx(2 * np.sin(a) + 1.5 * np.sin(b))
    assert planar["torque[2]"] == pytest.approx(1.5 * (-30 * np.sin(b) - 20 * np.cos(b)))

    slewing = load("typologies", "slewing").observe()
    reach = 2 * np.cos(0.5) + 1.5 * np.cos(-0.2)
    assert slewing["position[1]"] == pytest.approx(reach * np.cos(0.3))
    assert slewing["position[3]"] == pytest.approx(2 * np.sin(0.5) + 1.5 * np.sin(-0.2))
    slew_torque = reach * (-30 * np.sin(0.3) - 20 * np.cos(0.3))
    assert slewing["torque[1]"] == pytest.approx(slew_torque)

    telescoping = load("typologies", "telescoping").observe()
    along = np.array([np.cos(0.5) * np.cos(0.3), np.cos(0.5) * np.sin(0.3), np.sin(0.5)])
    position = [telescoping[f"position[{k}]"] for k in (1, 2, 3)]
    np.testing.assert_allclose(position, 2.7 * along)
    assert telescoping["torque[3]"] == pytest.approx(along @ [30, -20, 50])


OTHERS = {"planar": 2, "knuckle": 3, "gantry": 3, "column": 3, "scara": 3, "six": 3}


@pytest.mark.parametrize("name", OTHERS)
def test_other_typologies_move_their_tips_and_pass_all_power(load, name):
    """In the position form, and in the full form of SCARA and six-joint arm."""
    result = load("typologies", "others").simulate()
    for k in range(OTHERS[name]):
        position = result[f"{name}_J.position[{k + 1}]"]
        travelled = result[f"{name}.travelled[{k + 1}]"]
        np.testing.assert_allclose(travelled, position - position[0], atol=1e-8)
    np.testing.assert_allclose(result[f"{name}.power"], 0, atol=1e-11)


def test_the_knuckle_boom_is_made_of_two_links_and_two_triangles(load):
    result = load("typologies", "others").simulate()
    for k in (1, 2, 3):
        own = result[f"knuckle_J.position[{k}]"]
        assert np.abs(own - own[0]).max() > 0.3
        np.testing.assert_allclose(result[f"links.position[{k}]"], own, atol=1e-7)
    np.testing.assert_allclose(result["boom_rate"], 0.3, rtol=1e-9)
    for k, name in enumerate(("slewing", "luffing", "folding")):
        np.testing.assert_allclose(result[name], result[f"knuckle.torque[{k + 1}]"], rtol=1e-6)
        assert result[f"gantry.torque[{k + 1}]"][-1] == [30, -20, 50][k]


FULL = {
    "planar_2": ("at_2", 2, 3),
    "planar_3": ("at_3", 3, 3),
    "slew": ("at_3", 3, 6),
    "boom": ("at_3", 3, 6),
    "gantry": ("at_3", 3, 6),
    "column": ("at_3", 3, 6),
    "knuckle": ("at_rams", 3, 6),
    "scara": ("at_4", 4, 6),
    "six": ("at_6", 6, 6),
}
STRAIGHT = {"at_2": [0.4, 0], "at_3": [0.3, np.pi / 2, 0], "at_4": [1, 0, 0, 0], "at_6": [0] * 6}
FOLDED = {
    "at_2": [0.4, np.pi],
    "at_3": [0, 0.5, -2.0],  # the telescope's boom of 2 m is gone
    "at_4": [0.2, -np.pi, 1, 0.4],
    "at_6": [0, 0, -np.pi, 0.3, 0, 1],
}
ZERO = {"at_2": [0, 0], "at_3": [0, 0, 0], "at_4": [0] * 4, "at_6": [0.3, np.pi / 2, 0, 0, 0, 0]}


def matrix(values, name, rows, columns):
    return np.array(
        [[values[f"{name}[{i + 1},{k + 1}]"] for k in range(columns)] for i in range(rows)]
    )


def poses():
    rng = np.random.default_rng(5)
    for _ in range(20):
        given = {
            name: rng.uniform(-3, 3, int(name[-1])) for name in ("at_2", "at_3", "at_4", "at_6")
        }
        yield given | {"at_rams": [rng.uniform(-3, 3), *rng.uniform([1.5, 2.1], [4.2, 3.8])]}
    # Straight, folded and upright arms, a tip on the axis of slew, a wrist in line.
    yield from (STRAIGHT, FOLDED, ZERO)
    # Cylinders 1 mm before their dead centres.
    yield {"at_rams": [0, 1.347, 1.954]}
    yield {"at_rams": [1, 4.315, 3.956]}


def test_each_jacobian_is_the_derivative_of_its_own_position_and_axes(load):
    """`jacobian(position, q)`, and the angular velocity of `jacobian(axes, q)`, to rounding."""
    model = load("typologies", "derived")
    for given in poses():
        values = model.observe(parameters={f"{name}.q0": list(q) for name, q in given.items()})
        for name, (_, n, m) in FULL.items():
            own = matrix(values, f"{name}.jacobian", m, n)
            flat = m == 3
            derived = matrix(values, f"{name}_p", 2 if flat else 3, n)
            scale = max(1, np.abs(derived).max())
            np.testing.assert_allclose(own[: len(derived)], derived, atol=1e-14 * scale, rtol=0)
            axes, changes = matrix(values, f"{name}.axes", 3, 3), matrix(values, f"{name}_A", 9, n)
            for k in range(n):
                spin = changes[:, k].reshape(3, 3).T @ axes.T
                turning = [spin[2, 1], spin[0, 2], spin[1, 0]]
                expected = turning[2:] if flat else turning
                scale = max(1, np.abs(turning).max())
                np.testing.assert_allclose(
                    own[len(derived) :, k], expected, atol=1e-14 * scale, rtol=0
                )
