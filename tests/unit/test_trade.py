"""`bgc trade` on small scenes whose answers are known."""

from __future__ import annotations

import math
from itertools import cycle, islice
from pathlib import Path

import numpy as np
import pytest
from trades import OSCILLATOR, legend_of, quick, written

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.measuring.judging import Accuracy
from bgc.runtime.measuring.measured_store import open_store
from bgc.runtime.measuring.timed_run import Budget, paced_times, timed_run
from bgc.runtime.trade.configurations import Configuration
from bgc.runtime.trade.measurement import Measurement
from bgc.runtime.trade.trade_session import TradeSession
from bgc.runtime.trade.work_precision import _LINE_COLOURS, _MARKERS, plot_trade

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("measured")]

ORDERS = {
    "lie": 1,
    "heun": 2,
    "midpoint": 2,
    "ros23": 2,
    "rodas23w": 2,
    "ros34prw": 3,
    "rk4": 4,
}


# --- errors against closed forms --------------------------------------------------------------


@pytest.mark.parametrize("method", ORDERS)
def test_errors_fall_with_the_order_of_the_method(tmp_path: Path, method: str) -> None:
    text = OSCILLATOR.replace("run 2 s;", "run 2 s every 80 ms;")  # rows at ends of steps
    found = bgc.trade(
        written(tmp_path, text), solvers=[method], steps=[0.04, 0.02, 0.01], keeps=[1]
    )
    errors = {row.configuration.step: found.target.error(row) for row in found.measurements}
    slope = math.log2(errors[0.04] / errors[0.01]) / 2
    assert slope == pytest.approx(ORDERS[method], abs=0.25)


def test_errors_are_those_against_the_closed_form(tmp_path: Path) -> None:
    """The largest between the rows too, of which there are three."""
    path = written(tmp_path, OSCILLATOR.replace("run 2 s;", "run 2 s every 1 s;"))
    found = bgc.trade(path, solvers=["heun"], steps=[0.04], keeps=[1])
    (row,) = found.measurements
    result = bgc.compile(path).simulate(solver="heun", step=0.04, every=1e-4)
    exact = {"x": np.cos(2 * result.time), "v": -2 * np.sin(2 * result.time)}
    for quantity, error in zip(found.quantities, row.errors, strict=True):
        expected = np.max(np.abs(result[quantity.name] - exact[quantity.name]))
        assert error == pytest.approx(expected, rel=1e-3)
    assert found.target.error(row) == pytest.approx(
        max(error / q.scale for error, q in zip(row.errors, found.quantities, strict=True))
    )


RELAXATION = """
model VanDerPol {
  state x = 2; state v = 0;
  der(x) = v / 1 s; der(v) = (1000*(1 - x^2)*v - x) / 1 s;
}
scene s of VanDerPol { observe x; run 2000 s every 2 s; }
"""


def test_what_happens_between_the_rows_is_judged(tmp_path: Path) -> None:
    """A jump takes a millionth of the period (Hairer, Wanner, IV.1), a thousandth of a row."""
    path = written(tmp_path, RELAXATION)
    found = bgc.trade(path, solvers=["rodas5p"], rtols=[1e-4, 1e-6, 1e-9])
    model = bgc.compile(path)
    fine = model.simulate(solver="radau5", rtol=1e-12, every=1e-3)["x"]
    for row in found.measurements:
        run = model.simulate(solver="rodas5p", rtol=row.configuration.rtol, every=1e-3)
        assert row.errors[0] >= 0.5 * np.max(np.abs(run["x"] - fine))
    assert found.recommended == Configuration("rodas5p", rtol=1e-9)
    assert [row.errors[0] > 0.5 for row in found.measurements] == [True, True, False]


def test_times_are_those_of_a_second_of_the_scene(tmp_path: Path) -> None:
    text = OSCILLATOR.replace("run 2 s;", "run 2 s; deadline 3 ms;")
    found = quick(written(tmp_path, text))
    assert found.target.deadline == pytest.approx(3e-3)
    for row in found.measurements:
        seconds = row.mean_step * row.counts["steps"]
        assert row.cpu * found.duration == pytest.approx(seconds, rel=1e-9)


def test_the_worst_of_many_equal_periods_is_like_all_others(tmp_path: Path) -> None:
    model = bgc.compile(written(tmp_path))
    method = Configuration("ros34prw", step=1e-2).method
    times = np.linspace(0.0, 2.0, 201)
    whole = timed_run(model, method, times, accounts=False, limit=60.0).seconds
    paced = paced_times(model, method, 1e-2, 2.0, 3)
    assert paced is not None
    assert 0.2 * whole / 200 < paced.usual < whole / 4
    assert paced.periods == 200
    assert len(paced.slowest) == 2
    assert paced.slowest[0] >= paced.slowest[-1] == paced.usual


def test_nothing_is_repeated_once_the_budget_is_spent(tmp_path: Path) -> None:
    model = bgc.compile(written(tmp_path))
    times = np.linspace(0.0, 2.0, 21)
    spent = TradeSession(
        model=model,
        duration=2.0,
        accuracy=Accuracy(1e-3),
        store=open_store(model, 2.0, None),
        budget=Budget(0.0),
        times=times,
        repeats=3,
    )
    row = Measurement(Configuration("ros34prw", step=1e-2), "done", cpu=1e-3, repeats=1)
    assert spent._again(row.configuration, 5) == []
    assert spent._repeated(row) is row
    assert spent._paced(row, 1e-2) is row


def test_pacing_ends_with_its_limit(tmp_path: Path) -> None:
    model = bgc.compile(written(tmp_path))
    method = Configuration("ros34prw", step=1e-2).method
    assert paced_times(model, method, 1e-2, 2.0, 3, limit=0.0) is None


def test_a_kept_jacobian_costs_fewer_factorisations(tmp_path: Path) -> None:
    found = bgc.trade(written(tmp_path), solvers=["ros34prw"], steps=[0.01], keeps=[1, 5])
    assert legend_of(plot_trade(found))[:2] == ["ros34prw", "Jacobian kept for steps"]
    fresh, kept = (row.counts["factorisations"] for row in found.measurements)
    assert [row.configuration.keep for row in found.measurements] == [1, 5]
    assert fresh == pytest.approx(5 * kept)


def test_no_two_methods_of_a_plot_are_drawn_alike() -> None:
    pairs = list(islice(zip(cycle(_LINE_COLOURS), cycle(_MARKERS), strict=False), 25))
    assert len(set(pairs)) == len(pairs) and len(set(_LINE_COLOURS)) == len(_LINE_COLOURS)


def test_methods_without_a_jacobian_are_not_tried_with_a_kept_one(tmp_path: Path) -> None:
    found = bgc.trade(
        written(tmp_path), solvers=["rk4", "heun", "dopri5"], steps=[0.01], rtols=[1e-4], keeps=[2]
    )
    assert {row.configuration.keep for row in found.measurements} == {1}
    assert {row.counts["jacobians"] for row in found.measurements} == {0}


def test_the_energy_residual_is_known_whatever_the_scene_observes(tmp_path: Path) -> None:
    without = quick(written(tmp_path))
    with_accounts = quick(written(tmp_path, OSCILLATOR.replace("as v;", "as v, energy.residual;")))
    for found in (without, with_accounts):
        by_method = {r.configuration: r.residual for r in found.measurements if r.done}
        coarse = by_method[Configuration("rk4", step=0.1)]
        fine = by_method[Configuration("rk4", step=0.01)]
        assert coarse is not None and fine is not None
        assert 0 < fine < 1e-2 * coarse < 1e-2
    assert [q.name for q in with_accounts.quantities] == ["x", "v"]


# --- the reference ----------------------------------------------------------------------------

LORENZ = """
model Lorenz {
  state x = 1; state y = 1; state z = 1;
  der(x) = (10*(y - x)) / 1 s; der(y) = (x*(28 - z) - y) / 1 s; der(z) = (x*y - 8/3*z) / 1 s;
}
scene chaos of Lorenz { observe x, y; run 80 s; solver auto; }
"""


def test_a_reference_that_two_methods_do_not_agree_on_is_not_called_converged(
    tmp_path: Path,
) -> None:
    path = written(tmp_path, LORENZ)
    found = quick(path, steps=[0.01])
    assert not found.reference.converged
    assert "not converged" in found.warnings[0]
    # nothing is stored for `solver auto`
    assert [w.code for w in bgc.compile(path).simulate(0.1).warnings] == ["BG090"]


def test_the_reference_agrees_with_the_closed_form_as_well_as_it_says(tmp_path: Path) -> None:
    found = quick(written(tmp_path))
    assert found.reference.converged and found.reference.accuracy < 1e-9
    times = found.reference.instants.times
    assert np.max(np.abs(found.reference.rows[:, 0] - np.cos(2 * times))) < 1e-9


def test_errors_below_the_references_own_are_told(tmp_path: Path) -> None:
    found = bgc.trade(written(tmp_path), solvers=["rodas5p"], rtols=[1e-4, 1e-12, 1e-13])
    coarse, fine, finest = found.measurements
    assert not found.target.at_reference(coarse)
    assert found.target.at_reference(fine)
    assert finest.status == "skipped" and "accuracy" in finest.message


def test_no_reference_where_no_method_completes_the_run(tmp_path: Path) -> None:
    path = written(
        tmp_path, "model M { state x = 1; der(x) = x^2/1 s; } scene s of M { observe x; run 2 s; }"
    )
    with pytest.raises(BgError, match="no reference") as caught:
        quick(path)
    assert [d.code for d in caught.value.diagnostics] == ["BG092"]


# --- what fails, what is missing --------------------------------------------------------------


def test_configurations_that_fail_are_rows_with_their_reason(tmp_path: Path) -> None:
    stiff = OSCILLATOR.replace("k = 4 N/m", "k = 1e12 N/m").replace("q0 = 1 m", "q0 = 0 m, f0 = 0")
    stiff = stiff.replace(", f0 = 0", "").replace(
        "hub -> spring, mass;",
        """
      pull : Se(e = 1 N); damper : R(2e6 kg/s); pull -> hub; hub -> spring, mass, damper;""",
    )
    found = bgc.trade(
        written(tmp_path, stiff), solvers=["rk4", "ros34prw"], steps=[0.01], keeps=[1]
    )
    rows = {row.configuration.solver: row for row in found.measurements}
    assert rows["rk4"].status == "failed" and rows["rk4"].message.startswith("BG703")
    assert rows["ros34prw"].done
    assert {row["solver"] for row in found.table} == {"rk4", "ros34prw"}


def test_a_scene_that_observes_nothing_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, OSCILLATOR.replace("observe spring.q as x, mass.f as v;", ""))
    with pytest.raises(BgError) as caught:
        quick(path)
    assert [d.code for d in caught.value.diagnostics] == ["BG091"]


def test_what_the_budget_does_not_allow_is_said_and_made_up_for_later(tmp_path: Path) -> None:
    path = written(tmp_path)
    first = quick(path, budget=1e-9)
    assert {row.status for row in first.measurements} == {"skipped"}
    assert "the same command continues" in first.warnings[-1]
    assert all(row.done for row in quick(path).measurements)


def test_solvers_and_slots_that_do_not_exist_are_refused(tmp_path: Path) -> None:
    path = written(tmp_path)
    with pytest.raises(BgError, match="BG071"):
        quick(path, solvers=["rodas5"])
    with pytest.raises(BgError) as caught:
        quick(path, variants=["mass.lock"])
    assert [d.code for d in caught.value.diagnostics] == ["BG093"]
