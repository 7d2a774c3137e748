"""`bgc trade` on small scenes whose answers are known."""

from __future__ import annotations

import csv
import math
import re
from html.parser import HTMLParser
from itertools import cycle, islice
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from trades import OSCILLATOR, codes, legend_of, quick, written

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.measuring.judging import Accuracy
from bgc.runtime.measuring.measured_store import open_store
from bgc.runtime.measuring.timed_run import Budget, paced_times, timed_run
from bgc.runtime.trade import trade_session as session_module
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


def test_the_command_counts_compiling_in_its_budget(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def measured(model: object, **options: Any) -> None:
        seen.append(options["budget"])
        raise KeyboardInterrupt

    monkeypatch.setattr("bgc.runtime.cli.trade.measure_trade", measured)
    CliRunner().invoke(application, ["trade", str(written(tmp_path)), "--budget", "30 s"])
    assert 15.0 <= seen[0] < 30.0


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


# --- interrupted, resumed, at the same time ---------------------------------------------------


def counted_runs(monkeypatch: pytest.MonkeyPatch, stop_at: int = 10**9) -> list[str]:
    """The methods that are run from now on; Ctrl-C comes at the one of that number."""
    ran: list[str] = []
    real = timed_run

    def run(model: Any, method: Any, *rest: Any, **named: Any) -> Any:
        if len(ran) == stop_at:
            raise KeyboardInterrupt
        ran.append(method.name)
        return real(model, method, *rest, **named)

    monkeypatch.setattr(session_module, "timed_run", run)
    return ran


def test_an_interrupted_trade_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path)
    whole = counted_runs(monkeypatch)
    expected = quick(path, fresh=True)
    monkeypatch.undo()
    monkeypatch.setattr("bgc.runtime.running.recommendation.FOLDER", str(tmp_path / "other"))
    before = counted_runs(monkeypatch, stop_at=len(whole) // 2)
    with pytest.raises(KeyboardInterrupt):
        quick(path)
    monkeypatch.undo()
    monkeypatch.setattr("bgc.runtime.running.recommendation.FOLDER", str(tmp_path / "other"))
    after = counted_runs(monkeypatch)
    found = quick(path)
    assert len(before) == len(whole) // 2
    assert 0 < len(after) < len(whole) - len(before) // 2
    pairs = zip(found.measurements, expected.measurements, strict=True)
    assert all(one.errors == other.errors for one, other in pairs)
    counted = counted_runs(monkeypatch)
    quick(path)
    assert counted == []  # everything is there
    quick(path, fresh=True)
    assert len(counted) == len(whole)


def test_a_damaged_file_is_measured_anew(tmp_path: Path, measured: Path) -> None:
    path = written(tmp_path)
    first = quick(path)
    for row in measured.rglob("rows/*.json"):
        row.write_text(row.read_text()[:40])
    second = quick(path)
    pairs = zip(first.measurements, second.measurements, strict=True)
    assert all(one.errors == other.errors for one, other in pairs)


def test_two_trades_at_once_store_what_one_does(tmp_path: Path) -> None:
    path = written(tmp_path)
    found: list[bgc.Trade] = []
    threads = [Thread(target=lambda: found.append(quick(path))) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    model = bgc.compile(path)
    store = open_store(model, 2.0, None)
    for row in found[0].measurements:
        stored = store.read(Measurement, model.facts.content, row.configuration)
        assert stored is not None and stored.errors == row.errors


# --- solver auto ------------------------------------------------------------------------------

REQUIRING = OSCILLATOR.replace("run 2 s;", "require x within 1 um; solver auto; run 2 s;")


def test_solver_auto_takes_the_stored_answer(tmp_path: Path) -> None:
    path = written(tmp_path, REQUIRING)
    before = bgc.compile(path).simulate()
    assert codes(before) == ["BG090"] and before.solver == "rodas5p"
    found = bgc.trade(path, solvers=["rk4"], steps=[0.1, 0.01, 0.005])
    assert found.recommended is not None and found.recommended.solver == "rk4"
    after = bgc.compile(path).simulate()
    assert after.solver == "rk4" and codes(after) == []
    assert after.counts["steps"] == pytest.approx(2 / found.recommended.step)
    # what a caller asks for goes before it, and no warning is due
    assert bgc.compile(path).simulate(rtol=1e-9).solver == "rodas5p"


def test_solver_auto_does_not_take_the_answer_to_another_question(tmp_path: Path) -> None:
    path = written(tmp_path, REQUIRING)
    bgc.trade(path, solvers=["rk4"], steps=[0.01])
    model = bgc.compile(path)
    assert codes(model.simulate(parameters={"k": 5})) == ["BG090"]
    written(tmp_path, REQUIRING.replace("I(1 kg)", "I(2 kg)"))
    assert codes(bgc.compile(path).simulate()) == ["BG090"]
    written(tmp_path, REQUIRING.replace("within 1 um", "within 1 nm"))
    assert codes(bgc.compile(path).simulate()) == ["BG090"]
    written(tmp_path, REQUIRING.replace("run 2 s;", "run 2 s; deadline 1 ms;"))
    assert codes(bgc.compile(path).simulate()) == ["BG090"]
    written(tmp_path, f"// a remark\n{REQUIRING}")
    assert codes(bgc.compile(path).simulate()) == []


def test_the_answer_holds_for_a_scene_that_named_a_solver_when_it_was_measured(
    tmp_path: Path,
) -> None:
    path = written(tmp_path, REQUIRING.replace("solver auto;", "solver ros23(step = 1 ms);"))
    bgc.trade(path, solvers=["rk4"], steps=[0.01])
    written(tmp_path, REQUIRING)
    assert bgc.compile(path).simulate().solver == "rk4"


def test_part_of_a_scene_is_no_answer_for_the_whole(tmp_path: Path) -> None:
    path = written(tmp_path, REQUIRING)
    found = bgc.trade(path, solvers=["rk4"], steps=[0.01], duration=1.0)
    assert found.recommended is not None and not found.complete
    assert codes(bgc.compile(path).simulate()) == ["BG090"]


# --- require ----------------------------------------------------------------------------------


def test_what_is_required_need_not_be_observed(tmp_path: Path) -> None:
    path = written(tmp_path, REQUIRING.replace("x within 1 um", "mass.p within 1e-6 N*s"))
    model = bgc.compile(path)
    assert model.facts.requirements == (("mass.p", 1e-6),)
    assert list(model.simulate(0.1, solver="rodas5p")) == ["x", "v"]
    assert list(model.observe()) == ["x", "v"]
    assert model.linearise().outputs == ("x", "v")
    found = quick(path)
    assert [(q.name, q.decides) for q in found.quantities] == [
        ("x", False),
        ("v", False),
        ("mass.p", True),
    ]


def test_the_stored_reference_is_judged_by_what_is_required_now(tmp_path: Path) -> None:
    found = {}
    for tolerance in ("1 um", "1e-17 m"):
        path = written(tmp_path, REQUIRING.replace("1 um", tolerance))
        found[tolerance] = quick(path)
    first, second = found["1 um"].reference, found["1e-17 m"].reference
    assert np.array_equal(first.rows, second.rows)  # nothing was solved again
    assert second.accuracy == pytest.approx(1e11 * first.accuracy)
    assert first.converged and not second.converged
    assert found["1e-17 m"].recommended is None
    free = quick(written(tmp_path, REQUIRING.replace("require x within 1 um;", "")))
    assert free.reference.converged and not free.reference.required


def test_a_goal_of_the_command_is_judged_by_the_same_measurements(tmp_path: Path) -> None:
    path = written(tmp_path, REQUIRING)
    assert quick(path).recommended == Configuration("rodas5p", rtol=1e-7)
    goal = {"within": {"x": "1 mm"}, "faster_than": 2.0, "deadline": "1 s"}
    found = quick(path, **goal, budget=1e-9)
    assert found.recommended is not None and found.margins.keys() == {"error", "time", "speed"}
    required = next(q for q in found.quantities if q.name == "x")
    assert required.scale == 1e-3
    least = min(r.cpu for r in found.measurements if r.done and found.target.fits(r))
    assert found.verdict.recommended is not None and found.verdict.recommended.cpu == least
    assert bgc.compile(path).simulate(0.1).solver == "rodas5p"  # for the scene's own goal
    with pytest.raises(BgError) as caught:
        quick(path, within={"y": "1 mm"})
    assert [d.code for d in caught.value.diagnostics] == ["BG065"]


def test_a_column_may_be_required_by_its_name_or_by_what_it_is(tmp_path: Path) -> None:
    for text in ("require x within 1 mm;", "require spring.q within 1 mm;"):
        model = bgc.compile(written(tmp_path, OSCILLATOR.replace("run 2 s;", f"{text} run 2 s;")))
        assert model.facts.requirements == (("x", 1e-3),)


# --- the command ------------------------------------------------------------------------------


class Links(HTMLParser):
    """References of a page, and the rows of its tables."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self.rows = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.rows += tag == "tr"
        self.found += [v or "" for k, v in attrs if k in ("src", "href", "xlink:href")]


def test_the_command_writes_a_table_a_picture_and_a_page_that_needs_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, REQUIRING)
    monkeypatch.chdir(tmp_path)
    arguments = "trade scene.bg --out t.csv --plot t.png --html t.html --steps 10ms".split()
    outcome = CliRunner().invoke(application, [*arguments[:-1], "10 ms, 5 ms"])
    assert outcome.exit_code == 0, outcome.output
    assert "solver " in outcome.output.splitlines()[-1]
    rows = list(csv.DictReader((tmp_path / "t.csv").read_text().splitlines()))
    assert len({(r["solver"], r["rtol"], r["step"], r["keep"]) for r in rows}) == len(rows) > 30
    (best,) = (row for row in rows if row["recommended"] == "True")
    assert float(best["error"]) <= 1 and best["solver"] in outcome.output.splitlines()[-1]
    cheaper = [r for r in rows if r["accurate"] == "True" and r["cpu_per_second"]]
    assert float(best["cpu_per_second"]) == min(float(r["cpu_per_second"]) for r in cheaper)
    assert (tmp_path / "t.png").read_bytes()[:4] == b"\x89PNG"
    page = Links()
    text = (tmp_path / "t.html").read_text()
    page.feed(text)
    assert all(link.startswith("#") for link in page.found)
    assert not re.search(r"@import|url\(\s*['\"]?(?!#)", text)
    assert page.rows > len([row for row in rows if row["status"] == "done"])
    assert "<svg" in text and 'name="viewport"' in text


def test_ctrl_c_ends_the_command_with_a_word_on_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path)
    counted_runs(monkeypatch, stop_at=3)
    outcome = CliRunner().invoke(application, ["trade", str(path)])
    assert outcome.exit_code == 130
    assert "the same command continues" in outcome.output


def test_a_configuration_can_be_written_into_the_scene_as_it_is_recommended(tmp_path: Path) -> None:
    for configuration in (
        Configuration("ros34prw", step=2.5e-4, keep=5),
        Configuration("rodas5p", rtol=1e-7),
    ):
        text = OSCILLATOR.replace("run 2 s;", f"{configuration.statement(50.0)} run 2 s;")
        facts = bgc.compile(written(tmp_path, text)).facts
        assert facts.solver.name == configuration.solver
        options = facts.solver.given
        assert options.get("step", 0.0) == pytest.approx(configuration.step)
        assert options.get("rtol", 0.0) == pytest.approx(configuration.rtol)
        assert options.get("keep", 1) == configuration.keep
        assert options["settle"] == pytest.approx(50.0)


def test_another_start_is_another_question(tmp_path: Path) -> None:
    path = written(tmp_path, REQUIRING)
    bgc.trade(path, solvers=["rk4"], steps=[0.01])
    written(tmp_path, REQUIRING.replace("solver auto;", "solver auto(settle = 1 kHz);"))
    assert codes(bgc.compile(path).simulate()) == ["BG090"]
    found = bgc.trade(path, solvers=["rk4"], steps=[0.01])
    assert "settle = 1000 Hz" in found.sentence
