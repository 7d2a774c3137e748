"""The paper's experiment: the crane follows the hand, the hand feels the load, energy adds up."""

from importlib import resources
from pathlib import Path

import numpy as np
import pytest

import bgc
from bgc.runtime.realtime.loop_options import RealtimeOptions

SCENES = Path(str(resources.files("bgc.library"))) / "scenes" / "two_beam_crane.bg"
LOAD_IN_HAND = 2000 * 9.81 / 1800


@pytest.fixture(scope="module")
def experiment():
    return bgc.compile(SCENES, scene="two_beam_crane")


def follows_up_down_up(result) -> bool:
    """Rises, sinks and rises as the hand goes up, down and up (rate control)."""
    height = np.interp([2, 16, 38, 56], result.time, result["elevation"])
    rises = np.diff(height)
    return bool(rises[0] > 3 and rises[1] < -4 and rises[2] > 3)


def test_the_tip_follows_and_the_load_is_felt(experiment):
    result = experiment.simulate()
    assert result.time[-1] == 60
    assert np.isfinite(np.column_stack(list(result.columns.values()))).all()
    assert follows_up_down_up(result)
    assert np.abs(result["force_z"]).max() <= 12 * (1 + 1e-12)
    at_rest = result["force_z"][-50:]
    np.testing.assert_allclose(at_rest, -LOAD_IN_HAND, rtol=0.02)


def test_power_balance_with_the_adaptive_method(experiment):
    result = experiment.simulate(solver="rodas5p", rtol=1e-7, every=0.1)
    exchanged = sum(
        np.abs(np.diff(result[f"energy.{name}"])).sum()
        for name in ("stored", "supplied", "dissipated")
    )
    assert exchanged > 1e4
    assert np.abs(result["energy.residual"]).max() < 1e-6 * exchanged


def test_fixed_steps_agree_with_the_adaptive_method(experiment):
    fixed = experiment.simulate(4, every=0.1)
    adaptive = experiment.simulate(4, solver="rodas5p", rtol=1e-8, every=0.1)
    np.testing.assert_allclose(fixed["tip_height"], adaptive["tip_height"], atol=1e-4)


def test_another_crane_in_the_same_hand():
    result = bgc.compile(SCENES, scene="telescopic").simulate()
    assert follows_up_down_up(result)
    np.testing.assert_allclose(result["force_z"][-50:], -LOAD_IN_HAND, rtol=0.02)


def test_the_same_device_moves_several_cranes_in_one_loop(experiment, tmp_path):
    """Crane after crane takes the hand: the force falls to zero, and rises with the next load.

    It is the script of the manual, in shorter times and with a simulated hand.
    """
    cranes = [experiment, bgc.compile(SCENES, scene="telescopic"), experiment]
    options = RealtimeOptions(priority=False, watchdog=0.0, burst=0.0, policy="hold", ramp=0.05)
    hand = {"hand": "spring_hand(stiffness=5000, amplitude=0)"}
    record = tmp_path / "motion.csv"
    with cranes[0].realtime(devices=hand, options=options, record=record) as loop:
        for place, crane in enumerate(cranes):
            if place > 0:
                loop.exchange(crane)
            while loop.step().is_running and (len(loop.time) == 0 or loop.time[-1] < 0.3):
                pass
            assert place == 0 or loop.forces()[0, 2] > -0.1 * LOAD_IN_HAND
            assert loop.forces()[-1, 2] == pytest.approx(-LOAD_IN_HAND, rel=0.02)
    assert loop.report.exchanges == 2
    assert abs(loop.forces()[-1, 2]) < 1e-9
    again = experiment.simulate(
        loop.time[-1], every=1e-3, devices={"hand": f"{tmp_path}/motion_3.csv"}
    )
    rows = np.column_stack([again[name] for name in loop.columns])
    assert rows.tobytes() == np.ascontiguousarray(loop.rows).tobytes()


def test_force_in_proportion_to_elevation():
    result = bgc.compile(SCENES, scene="elevation_force").simulate(20)
    np.testing.assert_allclose(result["force_z"], -0.6 * result["elevation"], atol=1e-9)


def test_rigid_joints_give_the_same_motion(load):
    """The same crane with all locks rigid: 25 states instead of 67."""
    compliant, rigid = (load("crane_locks", scene) for scene in ("compliant", "rigid"))
    assert len(rigid.states) < len(compliant.states) - 40
    one, two = compliant.simulate(), rigid.simulate()
    np.testing.assert_allclose(one["tip"], two["tip"], atol=2e-3)
    np.testing.assert_allclose(one["stretch"], two["stretch"], atol=2e-3)
