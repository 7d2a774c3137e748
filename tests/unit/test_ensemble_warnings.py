"""Ensembles and studies warn of the steps and the energies of a run as that run alone does."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from ensembles import interrupt_after
from model_files import model_file

import bgc
from bgc.runtime.cli.app import application
from bgc.runtime.model import Model
from bgc.runtime.results.ensemble import Ensemble
from bgc.runtime.results.runs import Interrupted

pytestmark = pytest.mark.slow

# Fixed steps cannot bring x to rest: beside 0 its rate has no bound. A ball that knocks on a stiff
# wall, whose energies steps that are too long do not keep. One equation, whose values are known.
FILE = model_file("ensemble_warnings")
STIFFNESSES = [1000.0, 1e4, 300.0, 2e4, 1e5, 10.0]


@pytest.fixture(scope="module")
def root() -> Model:
    return bgc.compile(FILE)


@pytest.fixture(scope="module")
def knock() -> Model:
    return bgc.compile(FILE, scene="knock")


def told(model: Model, ensemble: Ensemble, **options: float | str) -> list[list[tuple[str, str]]]:
    """The codes and messages of each instance's run alone."""
    return [
        [
            (warning.code, warning.message)
            for warning in model.simulate(
                parameters={name: values[k] for name, values in ensemble.parameters.items()},
                **options,
            ).warnings
        ]
        for k in range(ensemble.count)
    ]


def texts(ensemble: Ensemble) -> list[list[tuple[str, str]]]:
    """The same of an ensemble."""
    return [
        [(warning.code, warning.message) for warning in ensemble.run_warnings.get(k, ())]
        for k in range(ensemble.count)
    ]


def test_a_wrong_end_is_not_left_without_a_word(root: Model) -> None:
    """x reaches 0 at 1.5 / k and stays there; with long steps it ends at 1000."""
    ensemble = root.simulate_many({"k": [0.01, 6000, 0.02, 0.03]}, solver="lie", step=0.1)
    assert ensemble.together == 4
    assert ensemble["x"][1, -1] == pytest.approx(1000)
    (warning,) = ensemble.warnings
    assert warning.code == "BG719"
    assert warning.note == "in instance 1, with `k` = 6000"
    assert list(ensemble.run_warnings) == [1]
    assert ensemble.run(1).warnings == ensemble.run_warnings[1]
    assert ensemble.run(0).warnings == ()


@pytest.mark.parametrize("solver", ["lie", "ros23", "rk4"])
def test_too_long_steps_and_lost_energy_are_those_of_runs_alone(knock: Model, solver: str) -> None:
    """Some steps an instance takes by itself: the wall switches."""
    options = {"solver": solver, "step": 0.005}
    ensemble = knock.simulate_many({"k": STIFFNESSES}, **options)
    assert ensemble.together == len(STIFFNESSES)
    found = texts(ensemble)
    assert found == told(knock, ensemble, **options)
    assert {code for some in found for code, _ in some} == {"BG716", "BG719"}
    assert not found[-1]  # a soft wall
    assert sorted(warning.code for warning in ensemble.warnings) == ["BG716", "BG719"]


def test_instances_that_run_alone_are_warned_of_too(knock: Model) -> None:
    options = {"solver": "ros23", "step": 0.005}
    together, alone = (
        knock.simulate_many({"k": STIFFNESSES}, **options, vectorised=vectorised)
        for vectorised in (True, False)
    )
    assert (together.together, alone.together) == (6, 0)
    assert texts(together) == texts(alone) != [[]] * 6


def test_warnings_outlive_an_interruption(root: Model, monkeypatch) -> None:
    values = {"k": [6000.0, *np.linspace(0.01, 0.02, 11)]}
    options = {"solver": "lie", "step": 0.1}
    interrupt_after(monkeypatch, 1)
    with monkeypatch.context() as one:
        one.setattr("bgc.runtime.running.batches.processors", lambda: 1)
        with pytest.raises(Interrupted):
            root.simulate_many(values, **options, resume=True)
    monkeypatch.undo()
    ensemble = root.simulate_many(values, **options, resume=True)
    assert 0 < ensemble.recalled < 12
    assert list(ensemble.run_warnings) == [0]
    assert [warning.code for warning in ensemble.warnings] == ["BG719"]


# --- studies ------------------------------------------------------------------------------------


def test_a_study_a_fit_and_an_optimisation_pass_warnings_on(root: Model, tmp_path: Path) -> None:
    options = {"solver": "lie", "step": 0.1}
    study = root.sweep({"k": "4..40:4"}, ["max(x)"], **options)
    assert {warning.code for warning in study.warnings} == {"BG719"}
    best = root.optimise({"k": "20..40"}, minimise="max(x)", **options)
    assert "BG719" in {warning.code for warning in best.warnings}
    path = tmp_path / "record.csv"
    root.simulate(**options, parameters={"k": 30.0}).to_csv(path)
    fitted = root.fit(path, {"k": "20..40"}, **options)
    assert "BG719" in {warning.code for warning in fitted.warnings}


def test_the_command_prints_them_and_files_hold_them(tmp_path: Path) -> None:
    out = tmp_path / "out.npz"
    result = CliRunner().invoke(
        application,
        ["sweep", str(FILE), "--vary", "k=0.01,6000,0.02,0.03", "--solver", "lie",
         "--step", "100 ms", "--out", str(out), "--quiet"],
    )  # fmt: skip
    assert result.exit_code == 0
    assert "warning[BG719]" in result.stderr and "in instance 1, with `k` = 6000" in result.stderr
    with np.load(out) as archive:
        (warned,) = json.loads(str(archive["about"]))["warnings"].items()
    assert warned[0] == "1" and "is too long at" in warned[1][0]


# --- states below their tolerance ---------------------------------------------------------------

PITCHFORK = Path(__file__).parents[1] / "models" / "faint.bg"


def test_a_run_that_rounding_decides_is_warned_of_with_its_cure() -> None:
    """One of 32 is examined, the first: it is warned of as alone; with its cure none is."""
    model = bgc.compile(PITCHFORK, scene="pitchfork")
    values = {"x0": [0.1, 0.2, 0.3, 0.4]}
    ensemble = model.simulate_many(values)
    assert ensemble.together == 4
    (alone,) = model.simulate().warnings
    (warning,) = ensemble.warnings
    assert (warning.code, warning.help) == (alone.code, alone.help) and alone.code == "BG726"
    assert warning.note.splitlines() == [
        "1 of the 4 instances in which a state fell so were examined",
        "in instance 0, with `x0` = 0.1",
    ]
    cured = model.simulate_many(values, atol=float(alone.help.split("`")[1].split("= ")[1]))
    assert not cured.warnings


def test_a_driven_state_that_fell_is_not() -> None:
    """The push lifts it again, whatever is left of it."""
    model = bgc.compile(PITCHFORK, scene="pushed")
    ensemble = model.simulate_many([{}] * 4)
    assert ensemble.together == 4
    assert not ensemble.warnings


# --- rounding -----------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", ["rodas5p", "dopri5"])
def test_rounding_beside_a_large_term_is_told_of_the_instance_that_has_it(
    tmp_path: Path, solver: str
) -> None:
    """x'' = -x in all: beside 1e8, f changes in stairs, on which a shift by digits of x stays."""
    path = tmp_path / "stairs.bg"
    path.write_text(
        "model Stairs { param large = 1; state x = 0.4; state v = 0; der(x) = v / 1 s;"
        " der(v) = (large - exp(log(large + x))) / 1 s; }"
        "scene s of Stairs { observe x; run 30 s every 10 s; }"
    )
    model = bgc.compile(path)
    values, options = {"large": [1.0, 1e2, 1e8, 10.0]}, {"solver": solver, "rtol": 1e-9}
    alone = model.simulate(parameters={"large": 1e8}, **options)
    assert [warning.code for warning in alone.warnings] == ["BG731"]
    assert not model.simulate(parameters={"large": 1.0}, **options).warnings
    ensemble = model.simulate_many(values, **options)
    assert ensemble.together == 4
    (warning,) = ensemble.warnings
    assert (warning.code, warning.note) == ("BG731", "in instance 2, with `large` = 1e+08")
