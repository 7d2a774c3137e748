"""Estimated errors of runs against published values at the end, closed forms and tight runs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import bgc
import bgc.library
from bgc.runtime.cli.app import application
from bgc.runtime.results.summary import extremes

pytestmark = pytest.mark.errors

MODELS = Path(__file__).parents[1] / "models"
LIBRARY = Path(bgc.library.__path__[0])
REFERENCES = json.loads((MODELS / "ivp" / "references.json").read_text())
LARGE = {"pollution": 1e-2}  # atol over rtol


@pytest.mark.parametrize(
    ("name", "solver"),
    [
        ("oregonator", "rodas5p"),
        ("pollution", "rodas5p"),
        ("kaps", "rodas5p"),
        ("squeezer", "rodas5p"),
        ("detest_f1", "rodas5p"),  # pushed the other way at each second: events
        ("five_bodies", "dopri5"),
        ("chemical_akzo", "rodas5p"),  # an algebraic equation
    ],
)
def test_estimates_are_within_twice_the_true_errors_at_the_end(name, solver):
    model = bgc.compile(MODELS / "ivp" / f"{name}.bg")
    end = model.facts.duration
    run = model.simulate(
        every=end / 1000, solver=solver, rtol=1e-5, atol=1e-5 * LARGE.get(name, 1.0), error=True
    )
    ratios = [
        run.error[column][-1] / true
        for column, exact in REFERENCES[name]["end"].items()
        if (true := abs(run[column][-1] - exact)) > 1e-11 * np.abs(run[column]).max()
    ]
    assert 0.5 < np.median(ratios) < 2


@pytest.mark.parametrize("rtol", [1e-4, None, 1e-8])
def test_an_arm_of_twelve_joints_says_by_how_much_it_is_off(rtol, tmp_path, monkeypatch):
    """The default method changes from implicit to explicit steps and back."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "bench"))
    from growing import text_of

    path = tmp_path / "arm.bg"
    path.write_text(text_of("arm:12"))
    model = bgc.compile(path)
    exact = model.simulate(solver="radau5", rtol=1e-12)
    run = model.simulate(rtol=rtol, error=True)
    assert run.counts["method_changes"] >= 3
    for joint in range(12):
        name = f"v{joint}"
        true = np.abs(run[name] - exact[name]).max()
        assert 0.7 < run.error[name].max() / true < 1.4


@pytest.mark.parametrize("path", ["examples/two_tanks", "examples/clutch", "scenes/ur5"])
def test_rows_are_the_same_bits_with_and_without_estimates(path):
    model = bgc.compile(LIBRARY / f"{path}.bg")
    plain, estimated = model.simulate(error=False), model.simulate()
    for name, column in plain.columns.items():
        assert column.tobytes() == estimated[name].tobytes()
    assert estimated.errors and not plain.errors
    assert plain.error_estimate == "not estimated: it was not asked for"
    assert all(np.isnan(column).all() for column in plain.error.values())


OSCILLATOR = """
model Oscillator {
  state x = 1;
  state v = 0;
  state late = 1;
  der(x) = v;
  der(v) = -x;
  der(late) = -1e4*(late - x);
}
scene oscillator of Oscillator { observe x, v; run 200 every 0.5; }
"""


@pytest.mark.parametrize("solver", ["rodas5p", "rodas4p2", "radau5"])
@pytest.mark.parametrize("rtol", [1e-5, 1e-8])
def test_errors_of_an_oscillation_add_up_where_not_each_step_is_measured(solver, rtol, tmp_path):
    path = tmp_path / "oscillator.bg"
    path.write_text(OSCILLATOR)
    run = bgc.compile(path).simulate(solver=solver, rtol=rtol)
    for name, exact in (("x", np.cos(run.time)), ("v", -np.sin(run.time))):
        assert 0.7 < run.error[name].max() / np.abs(run[name] - exact).max() < 1.4


@pytest.mark.parametrize("solver", ["rodas5p", "rodas4p2", "radau5"])
def test_a_step_knows_its_errors_in_fast_parts(solver, tmp_path):
    """Oscillations by one and two radians in the step, and decays by e^-3 and e^-8."""
    path = tmp_path / "fast.bg"
    path.write_text("""
    model Fast {
      state a = 1; state b = 0.3; state c = 1; state d = 0.3; state e = 1; state g = 1;
      der(a) = b; der(b) = -a;
      der(c) = 2*d; der(d) = -2*c;
      der(e) = -3*e; der(g) = -8*g;
    }
    scene fast of Fast { observe a, b, c, d, e, g; run 1 every 1; }
    """)
    run = bgc.compile(path).simulate(solver=solver, rtol=0.4, atol=1e6, step=1.0)
    assert run.counts["steps"] == 1
    turned = np.exp(-1j * np.array([1, 2])) * (1 + 0.3j)
    exact = [turned[0].real, turned[0].imag, turned[1].real, turned[1].imag, np.exp(-3), np.exp(-8)]
    true = [abs(run[name][-1] - value) for name, value in zip("abcdeg", exact, strict=True)]
    found = [run.error[name][-1] for name in "abcdeg"]
    for part in (slice(0, 2), slice(2, 4), slice(4, 5), slice(5, 6)):
        assert 0.5 < np.linalg.norm(found[part]) / np.linalg.norm(true[part]) < 1.5


@pytest.mark.parametrize(("rtol", "factor"), [(1e-4, 2), (1e-6, 3)])
def test_errors_of_slow_and_fast_diffusion_are_known(rtol, factor):
    """Heat on a grid: the fast parts pass within the first steps."""
    model = bgc.compile(MODELS / "ivp" / "heat_square.bg")
    end = model.facts.duration
    exact = model.simulate(every=end / 200, solver="radau5", rtol=1e-11, error=False)
    run = model.simulate(every=end / 200, rtol=rtol)
    for name in run.columns:
        true = np.abs(run[name] - exact[name]).max()
        assert true / factor < run.error[name].max() < factor * true or true == 0.0


def test_errors_are_followed_far_below_the_sizes_of_states():
    """The autocatalytic problem E5: concentrations from 1e-3 to 1e-80."""
    model = bgc.compile(MODELS / "ivp" / "e5.bg")
    run = model.simulate(every=1e10, duration=1e11, rtol=1e-6, atol=1e-23)
    assert 0 < run.error["y[2]"][-1] < 1e-18


BALL = """
model Ball {
  state x = 1;
  state v = 0;
  der(x) = v;
  der(v) = -10 - 0.3*v*abs(v);
  when x < 0 { reset v = -0.8*v; }
}
scene ball of Ball { observe x, v; run 1.9 every 1.9/400; }
"""


@pytest.mark.parametrize("rtol", [1e-5, 1e-7])
@pytest.mark.parametrize("solver", ["rodas5p", "radau5", "dopri5"])
def test_errors_pass_contacts_at_which_the_force_jumps(solver, rtol, tmp_path):
    """The damping sets in at the speed of the impact."""
    path = tmp_path / "drop.bg"
    path.write_text("""
    model Drop {
      state x = 1; state v = 0;
      der(x) = v;
      der(v) = -9.81 - (if x < 0 then 1e4*x + 20*v else 0);
    }
    scene drop of Drop { observe x, v; run 2.5 s every 10 ms; }
    """)
    model = bgc.compile(path)
    exact = model.simulate(solver="radau5", rtol=1e-12, atol=1e-14)
    run = model.simulate(solver=solver, rtol=rtol)
    for name in ("x", "v"):
        true = np.abs(run[name] - exact[name]).max()
        assert 0.4 < run.error[name].max() / true < 3


def test_errors_pass_sixty_contacts_that_amplify_them():
    """Edges coincide at each contact of backlash, and errors grow by 1e3 in a second."""
    model = bgc.compile(LIBRARY / "examples/backlash.bg")
    exact = model.simulate("1 s", rtol=1e-12, atol=1e-14, solver="radau5", error=False)
    run = model.simulate("1 s", rtol=1e-6)
    for name in ("motor", "load", "twist [deg]"):
        true = np.abs(run[name] - exact[name]).max()
        assert 0.5 < run.error[name].max() / true < 2


def test_an_input_that_jumps_moves_no_switch_in_time():
    model = bgc.compile(LIBRARY / "examples/hydraulic_cylinder.bg", scene="servo")
    exact = model.simulate(rtol=1e-11)
    run = model.simulate(rtol=1e-6)
    for name in ("position", "spool"):
        true = np.abs(run[name] - exact[name]).max()
        assert 0.2 < run.error[name].max() / true < 3


def test_errors_pass_jumps_and_count_between_rows(tmp_path):
    path = tmp_path / "ball.bg"
    path.write_text(BALL)
    model = bgc.compile(path)
    exact = model.simulate(rtol=1e-12, solver="radau5")
    run = model.simulate(rtol=1e-4, error=True)
    true = {name: np.abs(run[name] - exact[name]) for name in ("x", "v")}
    at_rest = true["v"] < 0.1  # not between the computed and the exact jump
    for name in ("x", "v"):
        assert 0.5 < run.error[name][at_rest].max() / true[name][at_rest].max() < 2
    # With two rows alone the second has the largest error of the whole run.
    coarse = model.simulate(rtol=1e-4, error=True, every=1.9)
    assert coarse.error["x"][-1] == pytest.approx(run.error["x"].max(), rel=0.5)


CHAOS = """
model Lorenz {
  state y[3] = [1, 1, 1];
  der(y) = [10*(y[2] - y[1]), y[1]*(28 - y[3]) - y[2], y[1]*y[2] - 8/3*y[3]];
}
scene lorenz of Lorenz { observe y; run 100 every 0.1; }
"""


def test_errors_of_a_chaotic_run_and_of_sampled_parts_are_withheld(tmp_path):
    path = tmp_path / "lorenz.bg"
    path.write_text(CHAOS)
    run = bgc.compile(path).simulate(error=True)
    assert np.isnan(run.error["y"]).all() and "`y[1]`" in run.error_estimate
    shown = extremes(run)
    assert shown.count("unknown ") == 1 and shown.count("  unknown\n") == 3
    note = run.plot().get_supxlabel()
    assert note == "error unknown: y[1], y[2], y[3]"
    sampled = bgc.compile(MODELS / "sampled.bg", scene="control")
    run = sampled.simulate()
    assert "not estimated" in run.error_estimate and "+-" not in extremes(run)


@pytest.mark.parametrize(
    ("path", "duration"),
    [(MODELS / "ivp/kepler.bg", None), (LIBRARY / "examples/backlash.bg", "2 s")],
    ids=["nonlinear", "events"],
)
def test_errors_too_large_for_linearised_equations_are_said_to_be_uncertain(path, duration):
    model = bgc.compile(path)
    run, closer = (model.simulate(duration, rtol=rtol) for rtol in (1e-4, 1e-6))
    assert "; uncertain: " in run.error_estimate
    assert "+- uncertain: some were too large for linearised equations" in extremes(run)
    assert "uncertain" not in closer.error_estimate + extremes(closer)


def test_a_run_without_estimate_says_so_where_it_is_asked_for(tmp_path):
    path = tmp_path / "ball.bg"
    path.write_text(BALL)
    command = ["run", str(path), "--solver", "gauss4", "--step", "1 ms"]
    assert "+-" not in CliRunner().invoke(application, command).stdout
    asked = CliRunner().invoke(application, [*command, "--error"]).stdout
    assert "  +- not estimated: the steps of `gauss4` are not followed\n" in asked


def test_errors_of_explicit_steps_with_algebraic_equations_are_not_followed():
    model = bgc.compile(MODELS / "ivp" / "chemical_akzo.bg")
    run = model.simulate("1 s", solver="heun", step="1 ms")
    assert "could not be followed" in run.error_estimate


def test_a_file_of_many_rows_has_no_errors(tmp_path, monkeypatch):
    monkeypatch.setattr("bgc.runtime.running.rows._memory", lambda: 2 * 8 * 191 * 4)
    path = tmp_path / "ball.bg"
    path.write_text(BALL)
    run = bgc.compile(path).simulate(every="10 ms")
    assert run.error_estimate == "not estimated: the rows are too many for memory"
