"""Solvers of others: CVODE, where SUNDIALS is installed."""

import subprocess
from dataclasses import replace

import numpy as np
import pytest
from model_files import compiled, model_text
from refusals import codes_of, refusal
from trades import OSCILLATOR, quick, written

import bgc
from bgc.building import backends
from bgc.building.backends import BACKENDS, build_backend
from bgc.building.build import runtime_directory
from bgc.building.cache import open_cache

pytestmark = pytest.mark.slow

RLC = model_text("backends_rlc")

BALL = model_text("backends_ball")

FENCED = """
model Fenced {
  state x = 0;
  der(x) = 1;
  assert x < 0.5, "x left its range";
}
scene out of Fenced { observe x; run 1 s; }
"""

COUPLED = model_text("backends_coupled")


@pytest.fixture(scope="session")
def sundials():
    try:
        build_backend(BACKENDS["cvode"], open_cache())
    except bgc.BgError as missing:
        assert [d.code for d in missing.diagnostics] == ["BG046"]
        pytest.skip("SUNDIALS is not installed")


def test_a_circuit_by_cvode_is_the_matrix_exponential(tmp_path, sundials):
    result = compiled(tmp_path, RLC).simulate()
    assert result.solver == "cvode"
    # u'' + R/L u' + u/(L C) = 5/(L C), at rest: underdamped.
    decay, natural = 2 / 2e-3, 1 / (1e-3 * 10e-6)
    omega = np.sqrt(natural - decay**2)
    t = result.time
    e = 5 * (1 - np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t)))
    assert np.abs(result["e"] - e).max() < 1e-6
    assert len(t) == 1001 and t[-1] == 0.01


def test_energy_accounts_balance_by_cvode(tmp_path, sundials):
    model = compiled(tmp_path, RLC)
    theirs, ours = model.simulate(), model.simulate(solver="rodas5p", rtol=1e-10)
    assert np.abs(theirs["supplied"] - ours["supplied"]).max() < 1e-9
    assert np.abs(theirs["residual"]).max() < 1e-6 * np.abs(theirs["supplied"]).max()


def test_parameters_and_tolerances_reach_cvode(tmp_path, sundials):
    model = compiled(tmp_path, RLC)
    exact = model.simulate(solver="rodas5p", rtol=1e-11, parameters={"R": 20})["e"]
    coarse, fine = (
        np.abs(model.simulate(rtol=rtol, parameters={"R": 20})["e"] - exact).max()
        for rtol in (1e-3, 1e-8)
    )
    assert fine < 1e-5 < coarse


def test_steps_of_cvode_end_at_switches(tmp_path, sundials):
    model = compiled(tmp_path, BALL)
    theirs = model.simulate(solver="cvode", rtol=1e-9)
    ours = model.simulate(solver="rodas5p", rtol=1e-10)
    assert theirs.counts["events"] == 4  # two bounces
    assert np.abs(theirs["x"] - ours["x"]).max() < 1e-5


def test_a_failed_assertion_ends_a_run_of_cvode_with_the_rows_before(tmp_path, sundials):
    with pytest.raises(bgc.SimulationError, match="x left its range") as failed:
        compiled(tmp_path, FENCED).simulate(solver="cvode")
    assert 0 < failed.value.result["x"][-1] < 0.5


def test_coupled_rates_are_refused(tmp_path, sundials):
    assert codes_of(lambda: compiled(tmp_path, COUPLED).simulate(solver="cvode")) == ["BG047"]


def test_a_suite_that_is_missing_is_named_with_its_packages(tmp_path, monkeypatch):
    nowhere = replace(backends.BACKENDS["cvode"], variants=(("-lno_such_library",),))
    monkeypatch.setitem(backends.BACKENDS, "cvode", nowhere)
    diagnostic = refusal(lambda: compiled(tmp_path, RLC).simulate())
    assert diagnostic.code == "BG046" and "apt-get install libsundials-dev" in diagnostic.help


@pytest.mark.parametrize("flags", [("-DBGC_KLU", "-I/usr/include/suitesparse"), ()])
def test_the_backend_compiles_without_warnings(tmp_path, sundials, flags):
    folder = runtime_directory()
    done = subprocess.run(
        ("cc", "-std=c11", "-Wall", "-Wextra", "-Werror", *flags, f"-I{folder}", "-c",
         str(folder / "backends" / "cvode.c"), "-o", str(tmp_path / "cvode.o")),
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_cvode_is_a_row_or_says_why_it_is_none(tmp_path, monkeypatch, sundials, measured):
    path = written(tmp_path, OSCILLATOR)
    with monkeypatch.context() as patch:
        nowhere = replace(BACKENDS["cvode"], variants=(("-lno_such_library",),))
        patch.setitem(BACKENDS, "cvode", nowhere)
        missing = quick(path, solvers=["cvode"])
    assert {r.status for r in missing.measurements} == {"refused"}
    assert missing.measurements[-1].message.startswith("BG046")
    here = quick(path, solvers=["cvode"])  # installed in between
    coarse, fine = here.measurements
    assert fine.worst > 0 and fine.cpu > 0 and here.target.error(fine) < here.target.error(coarse)
