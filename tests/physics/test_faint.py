"""States that fall below their tolerance and grow again: rounding decides, or others drive them."""

import itertools
import re

import numpy as np
import pytest

from bgc.runtime.stress.stress import stress
from bgc.runtime.stress.stress_judge import Verdict
from bgc.runtime.trade.trade import trade

SOLVERS = ["rodas5p", "rodas4p2", "radau5", "dopri5"]


def decided(result):
    return [d for d in result.warnings if d.code == "BG726"]


@pytest.fixture(scope="module")
def exact(load):
    def solved(scene):
        return load("faint", scene).simulate(solver="dopri5", rtol=1e-11, atol=1e-24)

    return {scene: solved(scene) for scene in ("pitchfork", "populations", "bar")}


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(
    ("scene", "column", "allowed"),
    [("pitchfork", "x", 5e-3), ("populations", "prey", 0.2), ("bar", "angle", 5e-3)],
)
def test_a_run_that_rounding_decides_says_so_and_its_atol_cures(
    load, exact, scene, column, allowed, solver
):
    model = load("faint", scene)
    (warning,) = decided(model.simulate(solver=solver))
    assert re.search(r"rounding decides `\w+`: it was below its tolerance of", warning.message)
    atol = float(re.search(r"--atol (\S+)`", warning.help).group(1))
    cured = model.simulate(solver=solver, atol=atol)
    assert not decided(cured)
    true = exact[scene][column]
    np.testing.assert_allclose(cured[column], true, atol=allowed * np.ptp(true))


def test_without_the_cure_the_answer_has_the_wrong_sign(load, exact):
    assert load("faint", "pitchfork").simulate()["x"][-1] == pytest.approx(-1.222, abs=1e-3)
    assert exact["pitchfork"]["x"][-1] == pytest.approx(1.222, abs=1e-3)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("scene", ["pushed", "ringing"])
def test_a_state_that_is_driven_or_passes_through_zero_is_no_cause_for_a_warning(
    load, scene, solver
):
    assert not load("faint", scene).simulate(solver=solver).warnings


@pytest.mark.parametrize("rtol", [1e-3, 1e-4])
def test_a_pushed_mass_is_followed_but_not_reported(load, rtol):
    assert not load("faint", "pushed").simulate(rtol=rtol).warnings


def test_a_stress_map_never_says_that_such_a_run_holds(load):
    found = stress(load("faint", "pitchfork"), ["rtol=1e-4,1e-6,1e-8", "x0=0,0.1"], fresh=True)
    verdicts = {point.settings[0]: point.judgement.verdict for point in found.points}
    assert len(verdicts) == 5
    assert Verdict.HOLDS not in verdicts.values()
    assert verdicts["rtol", 1e-6] is Verdict.WARNED
    # Exactly at rest all methods agree; a start next to it ends elsewhere.
    assert verdicts["x0", 0.0] is Verdict.UNJUDGED


def test_a_reference_of_a_trade_that_rounding_decides_is_not_verified(load):
    found = trade(load("faint", "pitchfork"), budget=5.0, fresh=True)
    assert not found.reference.converged


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("scene", "fell", "tolerance"), [("twice", 3, 1e-6), ("low", 1, 1e-10)])
def test_the_warning_names_the_lowest_fall_and_the_tolerance_there(
    load, scene, fell, tolerance, solver
):
    (warning,) = decided(load("faint", scene).simulate(solver=solver))
    said = re.search(r"its tolerance of (\S+) at t = (\S+) s", warning.message)
    assert float(said[2]) == pytest.approx(fell, abs=0.1)
    assert 0.02 * tolerance < float(said[1]) < 2 * tolerance


@pytest.mark.parametrize("solver", ["rodas5p", "dopri5"])
def test_a_motion_below_the_tolerances_is_right_or_warned_of_with_a_cure(load, solver):
    model = load("faint", "slow")
    for slow, start in itertools.product(np.logspace(-3, 5, 9), [1e-11, 1e-9, 1e-6, 1e-3]):
        values = {"T": slow, "start": start}
        result = model.simulate(20 * slow, every=slow, parameters=values, solver=solver)
        true = start * np.cos(result.time / slow)
        right = np.abs(result["spring.q"] - true).max() < 0.05 * start
        warned = [d for d in result.warnings if d.code == "BG733"]
        assert right or warned, values
        for warning in warned:
            atol = float(re.search(r"--atol (\S+)`", warning.help).group(1))
            cured = model.simulate(
                20 * slow, every=slow, parameters=values, solver=solver, atol=atol
            )
            np.testing.assert_allclose(cured["spring.q"], true, atol=0.01 * start)
            assert not cured.warnings
