"""Limits of joints and joints that follow others, against integration, momentum and frequencies."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bgc.diagnostics.diagnostic import BgError


@pytest.mark.parametrize("damping", [0.0, 0.2, 5.0])
def test_a_stop_pushes_and_never_pulls(load, damping):
    result = load("coupling", "thrown").simulate(rtol=1e-9, parameters={"damping": damping})

    def force(q, v):
        above, below = max(q - 0.3, 0), max(-0.4 - q, 0)
        return 5000 * (above * max(1 + damping * v, 0) - below * max(1 - damping * v, 0))

    def rates(_, y):
        return [y[1], -force(*y) / 2]

    exact = solve_ivp(
        rates, (0, 1), [0, 3], t_eval=result.time, rtol=1e-10, atol=1e-12, max_step=1e-3
    ).y
    np.testing.assert_allclose(result["angle"], exact[0], atol=1e-6)
    np.testing.assert_allclose(result["rate"], exact[1], atol=1e-4)
    assert (result["force"] * np.sign(result["depth"])).min() >= -1e-9
    assert np.abs(result["depth"]).max() > 0.01, "it has to be hit"
    if damping < 1:
        assert result["force"].min() < 0 < result["force"].max(), "at both limits"
    assert np.abs(result["energy.residual"]).max() < 1e-6
    if damping == 0:
        free = result["depth"] == 0
        np.testing.assert_allclose(np.abs(result["rate"][free]), 3, atol=1e-6)


@pytest.mark.parametrize("ratio", [-0.5, 3.0, 0.0])
def test_an_ideal_follower_adds_its_inertia_by_the_square_of_the_ratio(load, ratio):
    result = load("coupling", "ideal").simulate(rtol=1e-9, parameters={"ratio": ratio})
    first = 0.2 + result.time + 10 / (2 + ratio**2 * 3) * result.time**2 / 2
    np.testing.assert_allclose(result["first"], first, atol=1e-8)
    np.testing.assert_allclose(result["second"], ratio * first + 0.7, atol=1e-8)
    assert np.abs(result["energy.residual"]).max() < 1e-6


def test_a_stiff_follower_has_the_frequency_of_its_belt(load):
    model = load("coupling", "belt")
    values = model.eigenvalues()
    frequency = np.abs(values[values.imag > 1]).max()
    assert frequency == pytest.approx(np.sqrt(400 * (0.25 / 2 + 1 / 3)), rel=1e-9)
    result = model.simulate(rtol=1e-9)
    stretch = result["second"] - (-0.5 * result["first"] + 0.7)
    np.testing.assert_allclose(result["stretch"], stretch, atol=1e-8)
    assert np.abs(result["energy.residual"]).max() < 1e-5


def test_an_offset_is_where_the_coordinates_settle_or_start(load):
    """The belt comes to rest at ratio*leader + offset; the ideal coupling has to start there."""
    result = load("coupling", "offset_belt").simulate(rtol=1e-8)
    beyond = result["second"] - (-0.5 * result["first"] + 0.5)
    np.testing.assert_allclose(result["stretch"], beyond, atol=1e-7)
    # The leader is driven by 10 N m: what is left is the stretch that turns the follower.
    driven = -0.5 * 10 / (2 + 0.25 * 3) * 3 / 400
    assert beyond[0] == pytest.approx(0.2) and beyond[-1] == pytest.approx(-driven, rel=1e-3)
    assert len(load("coupling", "right_offset").simulate("0.1 s").time)
    with pytest.raises(BgError, match="`follower0` has to be ratio"):
        load("coupling", "wrong_offset").simulate("0.1 s")


@pytest.mark.parametrize("backward", [False, True])
def test_a_gear_on_a_joint_loses_a_share_of_the_power_of_the_driving_side(load, backward):
    """Forwards the motor drives; backwards the wheel drives the motor, which brakes."""
    torque, start = (-2.0, 30.0) if backward else (2.0, 0.0)
    result = load("coupling", "geared").simulate(
        rtol=1e-9, parameters={"torque": torque, "rate0": start}
    )
    # T - Jm n a = Jw a/(n k), with k = 0.8 forwards and 1/0.8 backwards.
    share = 1 / 0.8 if backward else 0.8
    acceleration = torque / (1e-3 * 50 + 2 / (50 * share))
    np.testing.assert_allclose(result["rate"], start + acceleration * result.time, rtol=1e-4)
    closed = result["energy.supplied"] - result["energy.stored"] - result["heat"]
    np.testing.assert_allclose(closed, 0, atol=1e-5)
    assert result["heat"][-1] > 10
    assert np.abs(result["energy.residual"]).max() < 1e-6
