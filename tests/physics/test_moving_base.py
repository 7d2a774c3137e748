"""Joints start at `rate0`, relative to their parent, whatever the base does."""

from __future__ import annotations

import numpy as np
import pytest

TWIST = np.array([2, 0.5, -0.3, 0.05, -0.1, 0.2])


def vector(values, name):
    return np.array([x for key, x in values.items() if key.startswith(f"{name}[")])


def of_base(values):
    """The twist of the tip in the world, if nothing moved relative to the base."""
    base = vector(values, "base").reshape(3, 3)
    arm = vector(values, "r") - vector(values, "origin")
    turn = base @ TWIST[3:]
    return base @ TWIST[:3] + np.cross(turn, arm), turn


def of_tip(values):
    axes = vector(values, "A").reshape(3, 3)
    return axes @ vector(values, "tip"), axes @ vector(values, "turn")


@pytest.mark.parametrize("scene", ["rigid", "compliant", "telescopic"])
def test_parts_on_a_moving_vessel_start_at_rest_relative_to_it(load, scene):
    values = load("moving_base", scene).observe()
    assert vector(values, "ground") == pytest.approx(TWIST, abs=1e-13)
    rates = [values[name] for name in ("slew", "luff", "fold", "slide") if name in values]
    assert len(rates) >= 2
    assert rates == pytest.approx([0] * len(rates), abs=1e-13)
    assert vector(values, "held") == pytest.approx(0, abs=1e-13)
    for found, expected in zip(of_tip(values), of_base(values), strict=True):
        assert found == pytest.approx(expected, abs=1e-12)
    if scene == "telescopic":
        assert vector(values, "swing") == pytest.approx([0.1, 0, -0.2], abs=1e-12)


def test_rates_that_are_given_hold_on_a_moving_vessel(load):
    values = load("moving_base", "rigid_rates").observe()
    assert vector(values, "ground") == pytest.approx(TWIST, abs=1e-12)
    rates = [values[name] for name in ("slew", "luff", "fold")]
    assert rates == pytest.approx([0, -0.1, 0.3], abs=1e-13)


def test_parameters_of_a_run_move_the_start(load):
    model = load("moving_base", "rigid_rates")
    values = model.observe(parameters={"crane.elbow.rate0": -1, "vessel.twist0[1]": 5})
    assert values["ground[1]"] == pytest.approx(5, abs=1e-12)
    rates = [values[name] for name in ("slew", "luff", "fold")]
    assert rates == pytest.approx([0, -0.1, -1], abs=1e-13)


def test_rates_of_joints_in_series(load):
    """The arm is turned by 40 degrees about -y, so its x axis is (cos, 0, sin) in the world."""
    values = load("moving_base", "trolley").observe()
    assert [values["slide"], values["swing"]] == pytest.approx([3, 2], abs=1e-14)
    angle = np.radians(40)
    assert vector(values, "v") == pytest.approx([3 * np.cos(angle), 0, -3 * np.sin(angle)])
    assert vector(values, "w") == pytest.approx([0, -2, 0])
