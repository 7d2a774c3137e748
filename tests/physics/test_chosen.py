"""A crane whose typology is chosen at run time."""

from __future__ import annotations

import numpy as np
import pytest

from bgc.diagnostics.diagnostic import BgError

# Position of each typology with the lengths of `ChosenKinematics`, by hand.
POSITIONS = {
    1: lambda s, a, b: polar(s, *(12 * arm(a) + 9 * arm(a + b))),
    2: lambda s, a, x: polar(s, *((10 + x) * arm(a))),
    3: lambda s, c, d: polar(
        s,
        *(7 * arm(boom(c)) + 5.2 * arm(boom(c) + between(2.955, 1.002, d) - 2 * np.pi + 3.2074)),
    ),
    4: lambda x, y, z: np.array([x, y, z]),
    5: lambda s, h, r: polar(s, r, h),
}


def arm(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def between(a, b, c):
    return np.arccos((a**2 + b**2 - c**2) / (2 * a * b))


def boom(c):
    return between(1.485, 2.831, c) - 0.7869


def polar(slew, reach, height):
    return np.array([reach * np.cos(slew), reach * np.sin(slew), height])


def vector(result, name):
    return np.array([result[f"{name}[{k}]"] for k in (1, 2, 3)])


@pytest.mark.parametrize("choice", POSITIONS)
def test_each_choice_is_its_crane_without_compiling_anew(load, choice):
    result = load("chosen", "operate").simulate(parameters={"choice": choice})
    coordinates, position = vector(result, "coordinates"), vector(result, "position")
    np.testing.assert_allclose(position, POSITIONS[choice](*coordinates), atol=1e-12)
    # The tip's velocity is that of this position, and the load is carried.
    moved = np.trapezoid(vector(result, "velocity"), result.time, axis=1)
    np.testing.assert_allclose(moved, position[:, -1] - position[:, 0], atol=1e-4)
    assert np.ptp(position[2]) > 0.1
    assert np.abs(result["lost"]).max() < 1e-6
    assert np.abs(result["passed"]).max() < 1e-6
    assert np.abs(result["energy.residual"]).max() < 1e-4


@pytest.mark.parametrize("other", [2, 3, 4, 5])
def test_a_choice_at_rest_makes_no_step_in_force(load, other):
    """The coupling carries 12 kN throughout; the position is that of another crane at once."""
    model = load("chosen", "operate")
    result = model.simulate(parameters={"other": other, "at": 20.01})
    before, after = result.time < 20.005, result.time > 20.005
    force, position = vector(result, "force"), vector(result, "position")
    assert np.linalg.norm(position[:, after][:, 0] - position[:, before][:, -1]) > 1
    step = force[:, after] - force[:, before][:, -1:]
    assert np.abs(step).max() < 0.1
    np.testing.assert_allclose(force[2, before][-1], -12e3, atol=0.1)
    assert np.abs(vector(result, "torque")[:, after]).max() < 1


def test_a_number_without_a_typology_is_refused(load):
    with pytest.raises(BgError, match=r"(?s)BG705.*1 to 5"):
        load("chosen", "operate").simulate(parameters={"choice": 7})
