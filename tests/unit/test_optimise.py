"""Design optimisation against closed forms: absorbers, limits, failures, interruption, errors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_file
from scipy.optimize import minimize

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.model import Model
from bgc.runtime.results.runs import Interrupted
from bgc.runtime.studies import designs, points

FILE = model_file("optimise_spring")
MU = 0.1
BOTH = {"k": "1..1000 N/m", "c": "0..100 N*s/m"}


@pytest.fixture(scope="module")
def absorber() -> Model:
    return bgc.compile(model_file("optimise_absorber"))


@pytest.fixture(scope="module")
def spring() -> Model:
    return bgc.compile(FILE)


@pytest.fixture(params=["differences", "exact"])
def derivatives(request, monkeypatch):
    exact = request.param == "exact"
    monkeypatch.setattr(designs, "_exact_costs_less", lambda *_: exact)


@pytest.mark.usefixtures("derivatives")
def test_an_absorber_after_a_blow_is_that_of_the_least_energy(absorber):
    """The H2 optimum (G. B. Warburton, 1982; T. Asami et al., 1991), exact for a blow."""
    tuning = math.sqrt(1 + MU / 2) / (1 + MU)
    damping = math.sqrt(MU * (1 + 0.75 * MU) / (4 * (1 + MU) * (1 + MU / 2)))
    found = absorber.optimise(BOTH, minimise="rms(x)")
    assert found.converged and found.runs < 200 and not found.warnings
    assert found["k"] == pytest.approx((10 * tuning) ** 2, rel=1e-5)
    assert found["c"] == pytest.approx(2 * damping * 10 * tuning, rel=1e-4)


def test_the_worst_of_many_frequencies_is_minimised(absorber):
    """Den Hartog's absorber; the reference minimises the closed frequency response."""
    w = np.linspace(7, 13, 25)

    def amplitude(k: float, c: float) -> float:
        mount = k + 1j * w * c
        moved = mount * w**2 / (mount - w**2)  # the absorber's force over the machine's motion
        return float(np.abs(100 / (1000 - 10 * w**2 - moved)).max())

    known = minimize(
        lambda p: amplitude(*p), (82.0, 3.3), method="Nelder-Mead",
        options={"xatol": 1e-6, "fatol": 1e-9},
    )  # fmt: skip
    absorber.parameters["force"] = 100.0
    absorber.parameters["v"] = 0.0
    try:
        found = absorber.optimise(
            BOTH, minimise="peak(x) from 17 s", over={"w": w}, duration=20, every="10 ms"
        )
    finally:
        del absorber.parameters["force"], absorber.parameters["v"]
    assert found.converged
    assert found.objective == pytest.approx(1e3 * known.fun, rel=2e-3)
    assert found["k"] == pytest.approx(known.x[0], rel=5e-3)
    assert found["c"] == pytest.approx(known.x[1], rel=0.05)
    assert found["k"] == pytest.approx(1000 * MU / (1 + MU) ** 2, rel=0.01)
    assert found.objective == pytest.approx(100 * math.sqrt((2 + MU) / MU), rel=0.01)
    assert "the worst case is w = " in repr(found)


@pytest.mark.parametrize("search", ["gradient", "evolution"])
def test_a_limit_holds_and_decides(spring, search):
    """The stretch v sqrt(m/k) is least where the force v sqrt(m k) is at its limit of 60 N."""
    found = spring.optimise(
        {"k": "1..1000 N/m"}, minimise="max(x)", require=["max(force) < 60 N"], search=search
    )
    assert found.converged and found.feasible and found.limits[0].note == "reached"
    assert found["k"] == pytest.approx(200, rel=1e-4)
    assert found.objective == pytest.approx(300, rel=1e-4)


def test_designs_that_fail_are_avoided_and_counted(spring):
    found = spring.optimise({"k": "1..1000 N/m"}, minimise="max(x)", require=[])
    assert 890 < found["k"] < 900
    (warning,) = found.warnings
    assert warning.code == "BG658" and "the spring breaks" in warning.message
    assert found.failed == len(found.failures) > 0


def test_limits_of_the_scene_count_and_those_that_cannot_be_met_are_named(spring):
    plain = spring.optimise({"k": "1..800 N/m"}, minimise="max(x)")
    assert [each.criterion.limit for each in plain.limits] == [1000]
    found = spring.optimise({"k": "4..800 N/m"}, minimise="max(x)", require=["max(force) < 1 N"])
    assert [each.code for each in found.warnings] == ["BG656"] and not found.feasible
    assert found["k"] == pytest.approx(4) and found.at_bound == (True,)


def test_the_largest_mean_of_cases(spring):
    found = spring.optimise(
        ["k=1..90 N/m"], maximise="min(x)", over={"v": "1..3 m/s:3"}, judge="mean"
    )
    assert found["k"] == pytest.approx(90)
    assert found.objective == pytest.approx(-2e3 * math.sqrt(2 / 90), rel=1e-3)


def test_a_count_of_rows_is_searched_without_derivatives(spring):
    """The share of time above 0.2 m is least where the amplitude v sqrt(m/k) is below it."""
    found = spring.optimise({"k": "100..800 N/m"}, minimise="above(x, 200 mm)", runs=400)
    assert found.search == "evolution"
    assert found["k"] > 9 * 2 / 0.2**2 and found.objective == 0


def test_a_parameter_without_influence_is_named(spring):
    found = spring.optimise({"k": "1..90 N/m", "unused": "0..9"}, minimise="max(x)")
    assert [each.code for each in found.warnings] == ["BG657"]
    assert "`unused`" in found.warnings[0].message and found["k"] == pytest.approx(90)


def test_an_interruption_keeps_the_best_design(spring, monkeypatch):
    run, batches = points.run_many, []

    def interrupted(plan, **options):
        batches.append(plan)
        study = run(plan, **options)
        if len(batches) % 9 == 0:
            raise study.interrupted(kept=False)
        return study

    monkeypatch.setattr(points, "run_many", interrupted)
    with pytest.raises(Interrupted, match="the best design by then") as caught:
        spring.optimise({"k": "1..800 N/m"}, minimise="max(x)", require=["max(force) < 60 N"])
    found = caught.value.result
    assert not found.converged and found.objective < found.at_start
    command = ["optimise", str(FILE), "--vary", "k=1..800 N/m", "--minimise", "max(x)"]
    done = CliRunner().invoke(application, [*command, "--require", "max(force) < 60 N"])
    assert done.exit_code == 130 and "best design" in done.output


@pytest.mark.parametrize(
    ("vary", "options", "code"),
    [
        ({}, {}, "BG655"),
        ({"k": "5..5 N/m"}, {}, "BG655"),
        ({"v": "-1e308..1e308 m/s"}, {}, "BG655"),
        ({"k": "950..990 N/m"}, {}, "BG655"),
        ({"k": "1..9 N/m"}, {"over": {"k": [1, 2]}}, "BG655"),
        ({"k": "1..9 N/m"}, {"minimise": "above(x, 1 m)", "search": "gradient"}, "BG655"),
        ({"k": "1..9 N/m"}, {"runs": 2, "starts": 4}, "BG655"),
        ({"k": "1..9 N/m"}, {"maximise": "max(x)"}, "BG066"),
        ({"k": "1..9 N/m"}, {"judge": "best"}, "BG066"),
        ({"k": "1..9 N/m"}, {"search": "luck"}, "BG066"),
        ({"k": "1..9 N/m"}, {"seed": -1}, "BG066"),
        ({"k": "1..9 N/m"}, {"minimise": "x"}, "BG787"),
        ({"q": "1..9 N/m"}, {}, "BG060"),
    ],
)
def test_arguments_at_fault_are_refused(spring, vary, options, code):
    with pytest.raises(BgError) as caught:
        spring.optimise(vary, **{"minimise": "max(x)", **options})
    assert [each.code for each in caught.value.diagnostics] == [code]
    assert caught.value.diagnostics[0].help


def test_the_command_prints_the_design_and_writes_it(tmp_path):
    out, plot = tmp_path / "o.csv", tmp_path / "o.png"
    command = ["optimise", str(FILE), "--vary", "k=1..800 N/m", "--minimise", "max(x)"]
    more = ["--require", "max(force) < 60 N", "--out", str(out), "--plot", str(plot)]
    done = CliRunner().invoke(application, [*command, *more])
    assert done.exit_code == 0, done.output
    assert "max(force) < 60 N  60 N   reached" in done.output
    lines = out.read_text().splitlines()
    assert lines[0] == "name,best,start,low,high" and lines[1].startswith("k,200.")
    assert lines[3].startswith("max(force),") and lines[3].endswith(",,,60.0")
    assert plot.read_bytes().startswith(b"\x89PNG")
