"""Energy accounts that no state keeps small the steps for, against their closed forms."""

import numpy as np
import pytest

from bgc.language.solver import Solver
from bgc.runtime.measuring.timed_run import timed_run

SOLVERS = ("rodas5p", "rodas4p2", "radau5", "dopri5")


@pytest.mark.parametrize("solver", SOLVERS)
def test_work_on_a_mass_that_is_moved(load, solver):
    result = load("accounts", "moved").simulate(solver=solver, every=1.0)
    energy = np.sin(2 * result.time) ** 2  # m v^2 / 2
    np.testing.assert_allclose(result["energy.supplied"], energy, rtol=0, atol=1e-5)
    assert np.abs(result["energy.residual"]).max() < 1e-5


@pytest.mark.parametrize("solver", SOLVERS)
def test_heat_of_an_alternating_current(load, solver):
    result = load("accounts", "heater").simulate(solver=solver, every=0.1)
    omega = 2 * np.pi * 50
    heat = 230**2 / 50 * (result.time - np.sin(2 * omega * result.time) / (2 * omega))
    np.testing.assert_allclose(result["energy.dissipated"], heat, rtol=0, atol=1e-5 * heat[-1])


def test_a_slow_state_beside_a_fast_power(load):
    result = load("accounts", "lag").simulate(every=2.0)
    t = result.time
    # The integral of (1 + sin 40 t)^2 / 2; the lag's own part is 1e-9 times as large.
    heat = 0.75 * t - (np.cos(40 * t) - 1) / 40 - np.sin(80 * t) / 320
    np.testing.assert_allclose(result["energy.dissipated"], heat, rtol=0, atol=1e-5 * heat[-1])


def test_accounts_follow_the_tolerance(load):
    model = load("accounts", "moved")
    loose, tight = (
        np.abs(model.simulate(rtol=r, every=0.9)["energy.residual"]).max() for r in (1e-4, 1e-9)
    )
    assert tight < 1e-3 * loose
    assert tight < 1e-8


def codes(result):
    return [warning.code for warning in result.warnings]


def test_a_step_that_is_too_long_for_the_balance_is_told(load):
    model = load("accounts", "released")
    coarse = model.simulate(solver="heun", step=0.05)
    assert codes(coarse) == ["BG716"]
    assert np.ptp(coarse["spring.q"]) > 1.3 * 1.8  # of an amplitude of 0.9: it was right to warn
    assert codes(model.simulate(solver="heun", step=0.001)) == []


@pytest.mark.parametrize("solver", ["rodas5p", "radau5", "dopri5", "ros34prw", "midpoint"])
@pytest.mark.parametrize("scene", ["released", "at_rest"])
def test_good_runs_are_not_warned_of_whatever_moves(load, scene, solver):
    step = 0.002 if solver in ("ros34prw", "midpoint") else None
    assert codes(load("accounts", scene).simulate(solver=solver, step=step)) == []


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
@pytest.mark.parametrize("solver", SOLVERS)
def test_a_long_run_balances_within_the_tolerance(load, solver, rtol):
    """The errors of the steps have one sign: without control of their sum, four tolerances."""
    result = load("accounts", "shaken").simulate(solver=solver, rtol=rtol)
    assert np.abs(result["energy.residual"]).max() < rtol * result["energy.dissipated"][-1]


def test_a_balance_that_stays_small_costs_no_steps(load):
    """radau5 leaves little by itself: its steps are those of a run that keeps no books."""
    model, method = load("accounts", "shaken"), Solver("radau5", rtol=1e-6)
    times = np.linspace(0, 200, 21)
    with_accounts, without = (
        timed_run(model, method, times, accounts=accounts, limit=60).counts["steps"]
        for accounts in (True, False)
    )
    assert with_accounts == pytest.approx(without, rel=1e-2)
