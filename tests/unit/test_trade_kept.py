"""`bgc trade`: what it keeps for the next run and for `solver auto`, goals, and its command."""

from __future__ import annotations

import csv
import re
from html.parser import HTMLParser
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from trades import OSCILLATOR, codes, quick, written

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.measuring.measured_store import open_store
from bgc.runtime.measuring.timed_run import timed_run
from bgc.runtime.trade import trade_session as session_module
from bgc.runtime.trade.configurations import Configuration
from bgc.runtime.trade.measurement import Measurement

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("measured")]

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
    assert codes(bgc.compile(path).simulate()) == ["BG090", "BG721"]
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


@pytest.mark.parametrize(
    ("scene", "within", "named"),
    [
        ("", {"x": "1 mm"}, "`--within`"),
        ("require x within 1 um;", {"x": "1 mm"}, "`--within`"),
        ("require x within 1 um;", {"x": "1 um"}, "`require`"),
        ("require x within 1 um;", {"v": "1 mm/s"}, "`require` and `--within`"),
        ("require x within 1 um;", {}, "`require`"),
        ("", {}, "0.001 of the range (the scene has no `require`)"),
    ],
)
def test_the_sentence_names_what_requires_the_accuracy(
    tmp_path: Path, scene: str, within: dict[str, str], named: str
) -> None:
    path = written(tmp_path, REQUIRING.replace("require x within 1 um;", scene))
    sentence = quick(path, within=within).verdict.sentence
    assert f"within {named}:" in sentence or f"within {named}." in sentence


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
