"""Estimation from noisy motions: true values, intervals, identifiability, outliers, errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_file

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.model import Model

FILE = model_file("fit")
BOUNDS = {"k": "1..1000 N/m", "c": "0..20 N*s/m"}
TIME = np.arange(1, 61) / 15.0


def motion(k: float = 40.0, c: float = 1.2, mass: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """The exact motion: x in mm, v in m/s."""
    decay = c / (2 * mass)
    w = np.sqrt(k / mass - decay**2)
    x = np.exp(-decay * TIME) * np.sin(w * TIME) / w
    v = np.exp(-decay * TIME) * (np.cos(w * TIME) - decay / w * np.sin(w * TIME))
    return 1e3 * x, v


@pytest.fixture(scope="module")
def model() -> Model:
    return bgc.compile(FILE)


def test_known_stiffness_and_damping_are_within_their_intervals_in_the_stated_share(model):
    rng, hits, total, widths = np.random.default_rng(7), 0, 30, []
    x, v = motion()
    for _ in range(total):
        data = {
            "time": TIME,
            "x": x + rng.normal(0, 8, len(x)),
            "v": v + rng.normal(0, 0.05, len(v)),
        }
        found = model.fit(data, BOUNDS, confidence=0.9)
        assert found.converged and not found.warnings
        ends = {name: found.interval(name) for name in BOUNDS}
        hits += (ends["k"][0] <= 40 <= ends["k"][1]) + (ends["c"][0] <= 1.2 <= ends["c"][1])
        widths.append([high - low for low, high in ends.values()])
        assert found.noise["x [mm]"] == pytest.approx(8, rel=0.5)
        assert found.noise["v"] == pytest.approx(0.05, rel=0.5)
    assert 47 <= hits <= 59  # 90 % of 60, within three standard deviations
    assert (np.median(widths, axis=0) < [2.0, 0.25]).all()


def test_an_exact_motion_is_recovered_and_a_result_is_a_motion(model):
    exact = model.simulate(parameters={"k": 40, "c": 1.2}, every="50 ms")
    found = model.fit(exact, BOUNDS, columns=["x [mm]"])
    assert found.parameters() == pytest.approx({"k": 40, "c": 1.2}, rel=1e-7)
    assert np.abs(found.correlation[0, 1]) < 0.9 and len(found.plot().axes) == 1


def test_exact_derivatives_and_differences_find_the_same_estimate(model):
    """`radau5` has no sensitivities, and neither have energy accounts."""
    rng = np.random.default_rng(3)
    x, v = motion()
    data = {"time": TIME, "x": x + rng.normal(0, 8, len(x)), "v": v + rng.normal(0, 0.05, len(v))}
    exact = model.fit(data, BOUNDS)
    other = model.fit(data, BOUNDS, solver="radau5", rtol=1e-9)
    errors = exact.half_widths / 2
    assert exact.runs < other.runs
    assert (np.abs(exact.values - other.values) < 1e-2 * errors).all()
    assert exact.half_widths == pytest.approx(other.half_widths, rel=1e-3)
    stored = model.simulate(parameters={"k": 40, "c": 1.2})
    found = model.fit(stored, BOUNDS, columns=["energy.stored"])
    assert found.parameters() == pytest.approx({"k": 40, "c": 1.2}, rel=1e-6)


def test_parameters_that_the_data_do_not_determine_are_named(model):
    x, _ = motion()
    found = model.fit({"time": TIME, "x": x}, {"k": "1..1000 N/m", "unused": "0..9"})
    (warning,) = found.warnings
    assert warning.code == "BG478" and "`unused` has no influence" in warning.message
    assert np.isnan(found.half_widths).all()


def test_mass_and_stiffness_of_a_free_oscillation_are_one_parameter(model):
    x, _ = motion(c=0)
    model.parameters["c"] = 0.0
    try:
        bounds = {"k": "1..1000 N/m", "mass": "1..9 kg"}
        found = model.fit({"time": TIME, "x": x}, bounds, starts=32)
    finally:
        del model.parameters["c"]
    (warning,) = found.warnings
    assert "combination of `k`, `mass`" in warning.message
    assert found["k"] / found["mass"] == pytest.approx(20, rel=1e-5)


def test_a_column_of_zeros_is_fitted(model):
    found = model.fit({"time": TIME, "x": 0 * TIME}, {"k": "1..1000 N/m"})
    assert 1 <= found["k"] <= 1000 and np.isfinite(found.noise["x [mm]"])


def test_a_robust_loss_bears_outliers(model):
    rng = np.random.default_rng(2)
    x, _ = motion()
    x = x + rng.normal(0, 2, len(x))
    x[::7] += 300
    plain = model.fit({"time": TIME, "x": x}, BOUNDS)
    robust = model.fit({"time": TIME, "x": x}, BOUNDS, loss="cauchy")
    low, high = robust.interval("k")
    assert low < 40 < high and high - low < 2
    assert abs(robust["k"] - 40) < 0.3 * abs(plain["k"] - 40)


def test_bounds_starts_and_failed_runs(model):
    x, _ = motion()
    data = {"time": TIME, "x": x}
    bound = model.fit(data, {"k": "1..30 N/m"})
    assert bound.at_bound == (True,) and bound["k"] == pytest.approx(30)
    assert np.isnan(bound.interval("k")).all()
    model.parameters["k"] = 900.0
    try:
        far = model.fit(data, BOUNDS, starts=64)
    finally:
        del model.parameters["k"]
    assert far["k"] == pytest.approx(40, rel=1e-4) and far.start[0] < 100


@pytest.mark.parametrize(
    ("data", "bounds", "options", "code"),
    [
        ({"time": TIME, "y": TIME}, BOUNDS, {}, "BG479"),
        ({"time": TIME[:2], "x": TIME[:2]}, BOUNDS, {}, "BG479"),
        ({"time": TIME, "x": TIME}, {}, {}, "BG479"),
        ({"time": TIME, "x": TIME}, BOUNDS, {"noise": {"v": 1.0}}, "BG479"),
        ({"time": TIME, "x": TIME}, BOUNDS, {"match": {"x": "y"}}, "BG479"),
        ({"time": TIME, "x": TIME}, BOUNDS, {"match": {"xm": "x"}}, "BG479"),
        ({"x": TIME}, BOUNDS, {}, "BG788"),
        ({"time": -TIME, "x": TIME}, BOUNDS, {}, "BG788"),
        ({"time": TIME, "x": TIME}, BOUNDS, {"loss": "least"}, "BG066"),
        ({"time": TIME, "x": TIME}, {"z": "1..2"}, {}, "BG060"),
        ({"time": TIME, "x": TIME}, ["k=1..2", "k=1..2"], {}, "BG744"),
    ],
)
def test_what_cannot_be_estimated_is_refused(model, data, bounds, options, code):
    with pytest.raises(BgError) as caught:
        model.fit(data, bounds, **options)
    assert [d.code for d in caught.value.diagnostics] == [code]
    assert caught.value.diagnostics[0].help


def test_a_matched_column_replaces_the_one_of_the_observed_name(model):
    x, _ = motion()
    found = model.fit({"time": TIME, "xm": x, "x": 0 * x}, BOUNDS, match={"xm": "x"})
    np.testing.assert_array_equal(found.recorded.values[:, 0][-len(x) :], x)


def test_the_command_reads_units_and_prints_intervals(model, tmp_path):
    x, v = motion()
    table = tmp_path / "run.csv"
    columns = np.column_stack((1e3 * TIME, x / 1e3, v)).tolist()
    rows = (",".join(map(repr, row)) for row in columns)
    table.write_text("time [ms],position [m],speed\n" + "\n".join(rows) + "\n")
    out, plot = tmp_path / "o.csv", tmp_path / "o.png"
    command = ["fit", FILE, "--data", table, "--vary", "k=1..1000 N/m", "--vary", "c=0..20 N*s/m"]
    match = ["--match", "x=position", "--match", "v=speed", "--noise", "x=1 cm"]
    done = CliRunner().invoke(
        application, [*map(str, command), *match, "--out", str(out), "--plot", str(plot)]
    )
    assert done.exit_code == 0, done.output
    assert "95 % interval" in done.output and "10 mm" in done.output
    cells = dict(line.split(",", 1) for line in out.read_text().splitlines()[1:])
    assert float(cells["k"].split(",")[0]) == pytest.approx(40, rel=1e-4)
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_hostile_arguments_of_the_command_end_in_a_sentence(tmp_path, monkeypatch):
    x, v = motion()
    data = tmp_path / "m.csv"
    rows = (f"{a},{b},{c}" for a, b, c in zip(TIME, x, v, strict=True))
    data.write_text("\n".join(["time,x [mm],v", *rows]))
    huge = tmp_path / "huge.csv"
    huge.write_text("time,x\n0.1,1e300\n0.2,1e300\n")
    short = tmp_path / "short.csv"
    short.write_text("time,x\n1\n")

    def fit(*arguments: str, table: Path = data) -> str:
        given = ["fit", str(FILE), "--data", str(table), *arguments]
        done = CliRunner().invoke(application, given)
        assert done.exit_code == 1, done.output
        assert "Warning:" not in done.output and "Traceback" not in done.output
        return done.output

    assert "BG479" in fit("--vary", "k=1..1000 N/m", table=huge)
    assert "it has 1 cell below 2 names" in fit("--vary", "k=1..1000 N/m", table=short)
    for text in ("k=1..1000 N/m:7", "k=1..1000 N/m log", "k=1, 2, 3"):
        assert "BG565" in fit("--vary", text)
    assert '`--noise "x=2 mm"`' in fit("--vary", "k=1..9", "--noise", "3")
    assert '`--match "position=x"`' in fit("--vary", "k=1..9", "--match", "x")
    assert "its parameters are `mass`, `k`" in fit("--vary", "stiff=1..9")

    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Model, "fit", interrupt)
    given = ["fit", str(FILE), "--data", str(data), "--vary", "k=1..9"]
    done = CliRunner().invoke(application, given)
    assert done.exit_code == 130 and "interrupted before the estimate" in done.output
