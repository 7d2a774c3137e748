"""`bgc stress` on models whose limits are known."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.language.solver import Solver
from bgc.runtime.cli.app import application
from bgc.runtime.compiling import compile_model
from bgc.runtime.measuring.judging import Accuracy
from bgc.runtime.measuring.timed_run import timed_run
from bgc.runtime.stress.drives import all_drives, read_drive, requested_drives
from bgc.runtime.stress.stress import StressSession, stress
from bgc.runtime.stress.stress_judge import References, Verdict, judge
from bgc.runtime.stress.stress_plot import draw
from bgc.runtime.stress.stress_tables import summary
from bgc.runtime.stress.unresolved_modes import ringing_at_start

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("measured")]

MODELS = Path(__file__).parents[1] / "models" / "stress.bg"


def verdicts(found):
    return {p.settings[0][1]: p.judgement.verdict for p in found.points}


def rows_of(study):
    """The rows of each point that a study judges."""
    seen = []

    def spied(model, method, times, *others):
        seen.append(timed_run(model, method, times, accounts=False, limit=60).rows)
        return judge(model, method, times, *others)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bgc.runtime.stress.stress.judge", spied)
        study()
    return seen


def test_an_explicit_method_breaks_where_its_stability_ends():
    """Undamped, |R(i h omega)| > 1 for rk4 beyond h omega = 2 sqrt 2 (Hairer, Wanner, IV.2)."""
    model = compile_model(MODELS, "undamped")
    step, limit = 0.01, math.sqrt(8)
    inside, outside = ((factor * limit / step) ** 2 for factor in (0.98, 1.02))
    found = stress(model, [f"k={inside!r}, {outside!r}"])
    errors = {p.settings[0][1]: p.judgement.error for p in found.points}
    assert errors[inside] < 3  # damped or out of phase: wrong, but bounded
    assert errors[outside] > 100
    assert {*verdicts(found).values()} == {Verdict.WARNED}
    words = [point.judgement.message.partition(":")[0] for point in found.points]
    assert words == ["inaccurate", "unstable"]
    accurate = stress(model, ["k=1..100 N/m"])
    assert {*verdicts(accurate).values()} == {Verdict.HOLDS}


def test_a_stiff_method_has_no_such_limit():
    model = compile_model(MODELS, "oscillator")
    found = stress(model, ["k=1e3..1e14 N/m"], solver="rodas5p")
    assert {*verdicts(found).values()} == {Verdict.HOLDS}


def test_no_number_is_silently_wrong_anywhere_for_the_default_method():
    found = stress(compile_model(MODELS, "oscillator"), budget=60)
    assert found.wrong == ()
    assert not found.skipped
    driven = {drive.name: drive.role for drive in found.drives}
    assert driven["k"] == "stiffness" and driven["mass0"] == "inertia"
    assert driven["zeta"] == "resistance" and driven["load"] == "source"
    assert found.counts()[Verdict.HOLDS] > 40


def test_overflow_and_subnormal_values_end_with_a_status():
    model = compile_model(MODELS, "oscillator")
    found = stress(model, ["load=1e300, 1.7976931348623157e308", "mass0=5e-324, 1e-300"])
    for point in found.points:
        assert point.judgement.verdict in (Verdict.FAILS, Verdict.HOLDS), point
    assert found.counts()[Verdict.FAILS] >= 2
    assert all(p.judgement.message.startswith("BG7") for p in found.points
               if p.judgement.verdict is Verdict.FAILS)  # fmt: skip


def test_a_parameter_outside_its_range_is_refused_at_its_point():
    found = stress(compile_model(MODELS, "oscillator"), ["k=-1, 100"])
    assert verdicts(found) == {-1.0: Verdict.FAILS, 100.0: Verdict.HOLDS}
    assert found.points[0].judgement.message.startswith("BG061")


def test_a_coarse_step_is_degraded_and_then_told_by_the_balance():
    found = stress(compile_model(MODELS, "oscillator"), ["step=1 ms, 50 ms, 0.26 s"], solver="rk4",
                   step=1e-3)  # fmt: skip
    assert [*verdicts(found).values()] == [Verdict.HOLDS, Verdict.DEGRADED, Verdict.WARNED]


def test_a_solution_that_is_unstable_is_not_judged():
    found = stress(compile_model(MODELS, "inverted"), ["start=3.141592653589793, 3"])
    assert verdicts(found)[3.141592653589793] is Verdict.UNJUDGED
    assert verdicts(found)[3.0] is not Verdict.UNJUDGED


def test_a_structural_parameter_is_compiled_for_each_value():
    model = compile_model(MODELS, "undamped")
    assert "zeta" not in model.parameters
    model.parameters["k"] = 400
    seen = rows_of(lambda: stress(model, ["zeta=0"]))
    np.testing.assert_allclose(
        seen[0][:, 0], np.cos(20 * np.linspace(0, 4, len(seen[0]))), atol=2e-3
    )
    found = stress(model, ["zeta=0, 0.5"])
    assert {*verdicts(found).values()} == {Verdict.HOLDS}


def test_a_grid_is_a_map_of_two():
    found = stress(compile_model(MODELS, "oscillator"), ["k=1, 1e4", "mass0=1, 2, 3"], grid=True)
    assert len(found.points) == 6
    assert found.points[0].settings == (("k", 1.0), ("mass0", 1.0))


def test_a_loose_tolerance_is_judged_by_its_true_error():
    """Not by what it leaves open: 2 % at rtol 0.1, against the closed form, do not hold."""
    model = compile_model(MODELS, "circuit")
    found = stress(model, ["rtol=0.1, 1e-6"])
    assert [*verdicts(found).values()] == [Verdict.DEGRADED, Verdict.HOLDS]
    run = model.simulate(rtol=0.1, every=5e-5)
    decay, omega = 1000.0, math.sqrt(1e8 - 1e6)
    phase = omega * run.time
    exact = 5 - 5 * np.exp(-decay * run.time) * (np.cos(phase) + decay / omega * np.sin(phase))
    error = np.abs(run["capacitor.e"] - exact).max() / np.ptp(exact)
    assert found.points[0].judgement.error == pytest.approx(error, rel=0.05)


def test_ringing_that_every_method_passes_over_is_not_said_to_hold():
    """At 500 THz for 1 ms: L-stable methods agree on 5 V, which rings between 0 and 10 V."""
    found = stress(compile_model(MODELS, "circuit"), ["C=1e-28, 1e-5 F"])
    silent, slow = (point.judgement for point in found.points)
    assert silent.verdict is Verdict.UNJUDGED and "rings at 5e+14 Hz" in silent.message
    assert slow.verdict is Verdict.HOLDS


def test_ringing_at_the_start_by_its_closed_form():
    (mode,) = ringing_at_start(compile_model(MODELS, "circuit"), 10e-3)
    assert mode.frequency == pytest.approx(math.sqrt(1e8 - 1e6) / math.tau)
    assert mode.seconds == pytest.approx(1e-3)
    assert mode.amplitude == pytest.approx([5 * 1e4 / math.sqrt(1e8 - 1e6)])


@pytest.mark.parametrize(("solver", "others"), [("rodas5p", "radau5"), ("radau5", "rodas5p")])
def test_a_method_is_never_held_against_itself(solver, others):
    model = compile_model(MODELS, "circuit")
    times, method = np.linspace(0, 10e-3, 201), Solver(solver, rtol=1e-6)
    references = References()
    judgement = judge(model, method, times, Accuracy(1e-3), 60, references)
    assert judgement.verdict is Verdict.HOLDS
    assert {name for name, _ in references.runs} == {others}


def test_parameters_that_are_alike_go_together():
    model = compile_model(MODELS, "pair")
    found = stress(model, ["*.k=400, 10000 N/m"])
    assert {*verdicts(found).values()} == {Verdict.HOLDS}
    assert found.drives[0].members == ("left.k", "right.k")
    known = [model.parameters[name] for name in model.parameters]
    every = all_drives(compile_scene(*model.origin, until="elaborate").graph, known, duration=2.0)
    assert [drive.name for drive in every if drive.role == "stiffness"] == ["*.k"]
    with pytest.raises(BgError):
        read_drive("*.stiffness=1..2", {"left.k": "N/m"})


def test_a_pattern_sets_all_that_it_names():
    """At k = 400 both masses swing twice as fast, so one that was left would be wrong."""
    model = compile_model(MODELS, "pair")
    seen = rows_of(lambda: stress(model, ["*.k=400 N/m"]))
    exact = np.cos(20 * np.linspace(0, 2, len(seen[0])))
    np.testing.assert_allclose(seen[0], np.stack([exact, exact], axis=1), atol=1e-4)


def test_what_was_found_is_not_run_again_until_it_is_asked_for():
    model = compile_model(MODELS, "circuit")
    first = stress(model, ["rtol=1e-8..1e-3:6"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bgc.runtime.stress.stress.judge", None)
        assert stress(model, ["rtol=1e-8..1e-3:6"]).points == first.points
        with pytest.raises(TypeError):
            stress(model, ["rtol=1e-8..1e-3:6"], fresh=True)
        with pytest.raises(TypeError):
            stress(model, ["rtol=1e-8..1e-3:6"], within=1e-4)


def test_where_a_budget_ends_another_run_goes_on():
    model = compile_model(MODELS, "circuit")
    part = stress(model, budget=0)
    assert len(part.points) == 1 and part.planned > 30
    assert "run it again to continue" in summary(part)
    whole = stress(model, budget=60)
    assert len(whole.points) > 30
    assert part.points[0] in whole.points  # the same part of the scene, whatever the budget


def test_what_the_longest_point_takes_is_told():
    """A fixed step keeps its pace: 1e4 s take 2,500 times the 4 s of the scene."""
    model = compile_model(MODELS, "undamped")
    short, long = (stress(model, [f"step=1 ms, {t}"], budget=0) for t in ("2 ms", "4 ms"))
    assert short.needed == pytest.approx(long.needed)  # both points run over the whole scene
    every = stress(model, budget=0)
    assert every.needed == pytest.approx(10000 / every.duration * short.needed)


def test_short_steps_are_taken_over_a_part_of_the_scene():
    model = compile_model(MODELS, "undamped")
    found = stress(model, ["step=1e-9, 1e-3 s"], duration=100)
    short, long = found.points
    assert 0 < short.duration < 1 < long.duration == 100
    assert short.judgement.verdict is Verdict.HOLDS


def test_a_scene_is_driven_to_ten_thousand_seconds():
    found = stress(compile_model(MODELS, "oscillator"), ["time=10, 1e4 s"])
    assert {*verdicts(found).values()} == {Verdict.HOLDS}
    assert found.points[-1].duration == 1e4


def test_the_sentence_says_up_to_where_the_scene_can_be_trusted():
    model = compile_model(MODELS, "undamped")
    text = summary(stress(model, ["k=1, 10, 100, 2e4 N/m"], solver="gauss4"))
    assert "the scene holds for k 1 N/m to 100 N/m; for k some are wrong without a warning" in text
    text = summary(stress(model, ["k=1, 10 N/m"]))
    assert "the scene holds for all tried values of k; no number is wrong without a warning" in text


def test_drives_are_read_with_their_units():
    units = {"k": "N/m"}
    assert read_drive("k = 1 kN/m .. 1e6 kN/m", units).values == tuple(
        pytest.approx(10.0**n) for n in range(3, 10)
    )
    assert read_drive("k=1 N/m..3 N/m:3", units).values == (1.0, 2.0, 3.0)
    assert read_drive("k=1..3 kN/m:3", units).values == (1000.0, 2000.0, 3000.0)
    assert read_drive("step=1 ms, 2 ms", {}).values == (0.001, 0.002)
    assert read_drive("k=1, 2, 5 kN/m", units).values == (1000.0, 2000.0, 5000.0)
    assert read_drive("k=1..4 N/m:3 log", units).values == (1.0, 2.0, 4.0)
    assert read_drive("k=0..1 N/m", units).values[0] == 0.0


@pytest.mark.parametrize(
    "text", ["k", "k=2..1", "k=1..2:x", "=1..2", "k=1..2:1", "k=0..2 log", "*.q=1"]
)
def test_what_is_no_drive_is_refused(text):
    with pytest.raises(BgError) as problem:
        read_drive(text, {"k": ""})
    assert [d.code for d in problem.value.diagnostics] == ["BG087"]


GAINS = """model Gain { const gain = 2; param k = 1; output y = gain*k; }
model M {
  const order = 3;
  param rate: 1/s = 1;
  part: Gain();
  state x = 1;
  der(x) = -rate*x*order*part.y;
}
scene s of M { observe x; run 1 s; }
"""


@pytest.mark.parametrize(
    ("drive", "code", "help_"),
    [
        ("nosuch=1..2", "BG211", "declare it"),
        ("ordr=1..2", "BG211", "did you mean `order`?"),
        ("part.kk=1, 2", "BG210", "`gain`, `k`"),
        ("x=1..2", "BG603", "set the parameter"),
        ("nos*=1..2", "BG087", "NAME=LOW..HIGH"),
    ],
)
def test_a_name_that_cannot_be_set_is_refused_before_any_run(
    tmp_path, monkeypatch, drive, code, help_
):
    monkeypatch.setattr(StressSession, "begin", lambda *_, **__: pytest.fail("the scene ran"))
    path = tmp_path / "m.bg"
    path.write_text(GAINS)
    with pytest.raises(BgError) as problem:
        stress(compile_model(path), [drive])
    (diagnostic,) = problem.value.diagnostics
    assert diagnostic.code == code and help_ in diagnostic.help and diagnostic.span is None


def test_parameters_and_constants_can_be_driven(tmp_path):
    """A value that does not compile is a point that fails, and no reason to refuse the drive."""
    path = tmp_path / "m.bg"
    path.write_text(GAINS.replace("state x", "for i in 1..order { row[i]: Gain(); }\n  state x"))
    model = compile_model(path)
    texts = ["rate=1, 2", "part.k=1, 2", "part.gain=1, 2", "order=1.5, 2", "step=1 ms, 2 ms"]
    assert [drive.name for drive in requested_drives(model, texts)] == [
        text.partition("=")[0] for text in texts
    ]
    judged = {point.settings[0][1]: point for point in stress(model, ["order=1.5, 2"]).points}
    assert judged[1.5].judgement.verdict is Verdict.FAILS
    assert judged[2.0].judgement.verdict is Verdict.HOLDS


def test_a_scene_that_observes_nothing_or_does_not_run_is_refused(tmp_path):
    text = 'model M { state x = 1; der(x) = -x; assert time < 1, "over"; }\n'
    for scene, code in (
        ("scene s of M { run 1 s; }", "BG088"),
        ("scene s of M { observe x; run 2 s; }", "BG089"),
    ):
        path = tmp_path / f"{code}.bg"
        path.write_text(text + scene)
        with pytest.raises(BgError) as problem:
            stress(compile_model(path))
        assert [d.code for d in problem.value.diagnostics] == [code]


def run(*arguments):
    return CliRunner().invoke(application, ["stress", str(MODELS), *arguments])


def test_the_command_writes_its_map_and_tells_of_wrong_numbers(tmp_path):
    table, picture = tmp_path / "map.csv", tmp_path / "map.png"
    drive = ("--scene", "undamped", "--solver", "gauss4", "--drive", "k=100, 2e4")
    done = run(*drive, "--out", str(table), "--plot", str(picture))
    assert done.exit_code == 1
    assert "WRONG NUMBERS" in done.output
    assert picture.read_bytes().startswith(b"\x89PNG")
    header, first, second = table.read_text().splitlines()
    assert header == "driven,value,seconds,verdict,error,residual,message"
    assert first.startswith("k,100.0,4.0,holds,") and second.startswith("k,20000.0,4.0,wrong,")
    found = json.loads(run("--scene", "undamped", "--drive", "k=100", "--json").output)
    assert found["counts"]["holds"] == 1
    assert found["points"][0]["settings"] == {"k": 100.0}


def test_the_map_explains_its_colours_and_numbers(tmp_path):
    found = stress(compile_model(MODELS, "undamped"), ["k=100, 2e4"], solver="gauss4")
    (legend,) = draw(found, tmp_path / "map.svg").legends
    assert legend.get_title().get_text() == ("in a cell: the value, and below it the largest error")
    counts = {verdict.value: count for verdict, count in found.counts().items() if count}
    assert len(counts) == 2
    assert [text.get_text() for text in legend.get_texts()] == [
        f"{verdict} ({count})" for verdict, count in counts.items()
    ]


def test_a_grid_is_drawn(tmp_path):
    picture = tmp_path / "map.svg"
    drives = ("--drive", "k=1..1e3 N/m", "--drive", "mass0=1, 2 kg", "--grid")
    done = run("--scene", "oscillator", *drives, "--plot", str(picture))
    assert done.exit_code == 0
    assert picture.stat().st_size > 1000
