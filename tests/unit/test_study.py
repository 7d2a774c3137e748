"""Studies: observables on the fly, statistics, influence of parameters, files, plots."""

from __future__ import annotations

import csv
import tracemalloc

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_file

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.printing.text_tables import table_text
from bgc.runtime.cli.app import application
from bgc.runtime.model import Model
from bgc.runtime.results.runs import Interrupted
from bgc.runtime.results.study import Study
from bgc.runtime.running import batches, partial_ensemble
from bgc.runtime.running.csv_tables import read_cases
from bgc.runtime.running.parameter_grid import Listed, Range, points, read_axis

FILE = model_file("study")
ISHIGAMI = 2 * np.pi  # Ishigami and Homma's function of three angles from -pi to pi


@pytest.fixture(scope="module")
def model() -> Model:
    return bgc.compile(FILE)


def test_observables_are_those_of_the_run_and_failures_are_kept(model):
    vary = {"mass": [0.5, 1, 2, 5, 9], "k": "5..20 N/m:2"}
    study = model.sweep(vary, ["max(x)", "crossings(v, 0) from 1 s", "rms(v)"])
    rows, fine = model.sweep(vary), model.sweep(vary, every="1 ms")
    assert isinstance(study, Study) and len(study) == 10 and study.design == "grid"
    assert study.status == rows.status and study.failures.keys() == rows.failures.keys()
    assert 0 < study.status.count("failed") < 10
    late = rows.time >= 1
    for k in np.flatnonzero(study.done):
        x, v = rows["x [mm]"][k], rows["v"][k]
        assert study["max(x)"][k] == pytest.approx(fine["x [mm]"][k].max(), rel=1e-6)
        assert study["max(x)"][k] > x.max()  # between the rows
        count = np.count_nonzero((v[late][:-1] < 0) & (v[late][1:] >= 0))
        assert study["crossings(v, 0) from 1 s"][k] == count
    assert np.isnan(study.values[~study.done]).all()
    w = np.sqrt(study["k"] / study["mass"])
    exact = np.sqrt(0.5 + np.sin(8 * w) / (16 * w))
    np.testing.assert_allclose(study["rms(v)"][study.done], exact[study.done], rtol=1e-4)
    place = "\n".join(each.note for each in study.placed_failures())
    assert "in instance 6, with `mass` = 5, `k` = 5" in place


@pytest.mark.parametrize("text", ["max(x) from 20 s", "max(x) from 1 ms to 2 ms"])
def test_a_part_without_a_row_is_refused(model, text):
    with pytest.raises(BgError, match=r"BG787.*no row of the run.*ends at 4 s"):
        model.sweep({"k": "5..20 N/m:2"}, [text])


def test_an_interrupted_study_is_resumed(model, monkeypatch, tmp_path):
    monkeypatch.setattr(partial_ensemble, "FOLDER", str(tmp_path / "sweeps"))
    vary, observe = {"mass": np.linspace(1, 2, 40)}, ["max(x)"]
    whole = model.sweep(vary, observe)
    original = batches.Work.run_batch

    def interrupted(work, start):
        original(work, start)
        work.stopping = True

    with monkeypatch.context() as patch:
        patch.setattr(batches.Work, "run_batch", interrupted)
        with pytest.raises(Interrupted) as caught:
            model.sweep(vary, observe, resume=True)
    done = caught.value.result.status.count("done")
    assert caught.value.kept and 0 < done < 40
    assert model.sweep(vary, ["min(x)"], resume=True).recalled == 0
    resumed = model.sweep(vary, observe, resume=True)
    assert resumed.recalled == done
    np.testing.assert_array_equal(resumed.values, whole.values)


def ishigami(design: str, count: int) -> Study:
    axes = [Range(name, -np.pi, np.pi) for name in "abc"]
    at = points(axes, count, design, seed=3)
    y = np.sin(at["a"]) + 7 * np.sin(at["b"]) ** 2 + 0.1 * at["c"] ** 4 * np.sin(at["a"])
    status = ("done",) * len(y)
    return Study("s", "", at, ("y",), {"y": "1"}, y[:, None], status, design=design)


def test_sobol_indices_of_the_function_of_ishigami():
    """Its indices are known: T. Homma and A. Saltelli, Reliab. Eng. Syst. Saf. 52 (1996)."""
    found = ishigami("saltelli", 1000).sensitivity()
    assert found.runs == (1024 * 5,) and found.measure == "Sobol index"
    first, total = [0.3139, 0.4424, 0.0], [0.5576, 0.4424, 0.2437]
    np.testing.assert_allclose(found.first[0], first, atol=0.03)
    np.testing.assert_allclose(found.total[0], total, atol=0.03)
    for exact, interval in ((first, found.first_interval), (total, found.total_interval)):
        low, high = interval[0].T
        assert (low <= np.array(exact) + 0.02).all() and (high >= np.array(exact) - 0.02).all()
        assert (high - low < 0.25).all()
    assert found.ranking("y") == ["a", "b", "c"]


def test_a_failed_run_takes_its_point_out_of_the_indices():
    study = ishigami("saltelli", 256)
    whole = study.sensitivity()
    study.values[3 * 256 + 5] = np.nan
    found = study.sensitivity()
    assert found.runs == (255 * 5,)
    np.testing.assert_allclose(found.total, whole.total, atol=0.02)
    study.values[:] = np.nan
    with pytest.raises(BgError, match="BG066"):
        study.sensitivity()


def test_rank_correlations_and_how_often_their_intervals_hold_the_true_one():
    """Of normal variables of correlation r, Spearman's coefficient is 6/pi asin(r/2)."""
    rng, r, hits = np.random.default_rng(5), 0.6, 0
    for _ in range(200):
        a, b = rng.standard_normal((2, 60))
        y = r * a + np.sqrt(1 - r * r) * rng.standard_normal(60)
        study = Study("s", "", {"a": a, "b": b}, ("y",), {"y": ""}, y[:, None], ("done",) * 60)
        found = study.sensitivity(0.9)
        low, high = found.first_interval[0, 0]
        hits += low <= 6 / np.pi * np.arcsin(r / 2) <= high
    assert 165 <= hits <= 194  # 90 % of 200, within three standard deviations
    assert found.ranking("y")[0] == "a" and "rank correlation" in found.tables()[0].header


def test_statistics_ignore_what_is_not_finite():
    values = np.column_stack([np.array([1.0, 2, 3, 4, np.nan]), np.full(5, np.nan)])
    study = Study("s", "", {}, ("y", "z"), {}, values, ("done",) * 5)
    found = study.statistics([0.5])
    assert found.counts == (4, 0) and np.isnan(found["z"]["mean"])
    assert found["y"] == pytest.approx(
        {"mean": 2.5, "sd": np.std([1, 2, 3, 4], ddof=1), "least": 1, "largest": 4, "50 %": 2.5}
    )


def test_lists_logarithms_and_cases_make_points(model, tmp_path):
    p = model.parameters
    assert read_axis("mass=1, 2 t, 500 g", p.unit_of) == Listed("mass", (1e-3, 2000, 0.5))
    assert read_axis("k=1..100 N/m:3 log", p.unit_of) == Range("k", 1, 100, 3, True)
    with pytest.raises(BgError, match=r"BG743: .* ends above 0"):
        read_axis("k=0..100 N/m:3 log", p.unit_of)
    table = tmp_path / "cases.csv"
    table.write_text("# measured\nmass [g], k\n500, 3\n700, 4\n")
    cases = read_cases(table, p)
    at = points([Listed("x", (1.0, 2.0))], None, cases=cases)
    np.testing.assert_allclose(at["mass"], [0.5, 0.5, 0.7, 0.7])
    assert (at["k"].tolist(), at["x"].tolist()) == ([3, 3, 4, 4], [1, 2, 1, 2])
    listed = points([Listed("x", (1.0, 2.0)), Range("k", 1, 100, 3, True)], 64, "sobol")
    assert (np.unique(listed["x"], return_counts=True)[1] == 32).all()
    assert np.count_nonzero(listed["k"] < 10) == 32
    for text, place in (
        ("mass\n1,2\n", "line 2"),
        ("mass\nx\n", "line 2"),
        ("mass\n", "no rows"),
        ("", "is empty"),
    ):
        table.write_text(text)
        with pytest.raises(BgError, match="BG788") as caught:
            read_cases(table, p)
        assert place in str(caught.value)


def run(*arguments: object):
    return CliRunner().invoke(application, ["sweep", *map(str, arguments)])


def test_the_command_equals_the_method_and_draws(model, tmp_path):
    out, plot = tmp_path / "o.csv", tmp_path / "o.png"
    vary = ("--vary", "mass=1..3 kg:3", "--vary", "k=20, 30, 40 N/m")
    done = run(FILE, *vary, "--observe", "max(x)", "--rank", "--out", out, "--plot", plot)
    assert done.exit_code == 0, done.output
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert "statistics over 9 runs" in done.output and "influence" in done.output
    study = model.sweep({"mass": "1..3 kg:3", "k": "20, 30, 40 N/m"}, ["max(x)"])
    with out.open() as lines:
        rows = list(csv.DictReader(lines))
    assert [float(row["max(x)"]) for row in rows] == study["max(x)"].tolist()
    assert [float(row["k"]) for row in rows] == study["k"].tolist()
    for kind in ("curves", "contour", "scatter", "histogram"):
        assert study.plot(kind=kind).axes
    for wrong in (("--rank",), ("--design", "saltelli"), ("--observe", "max(x)", "--sample", 4)):
        extra = ("--cases", out) if wrong[0] == "--observe" else ()
        refused = run(FILE, *vary, *wrong, *extra, "--out", tmp_path / "w.csv")
        assert refused.exit_code in (1, 2) and not (tmp_path / "w.csv").exists()


def test_reports_that_do_not_fit_are_refused_before_the_runs(model, tmp_path, monkeypatch):
    def never(*args: object, **kwargs: object) -> None:
        raise AssertionError("it runs")

    monkeypatch.setattr(type(model), "sweep", never)
    vary = ("--vary", "mass=1..3 kg:3", "--observe", "max(x)")
    plot = ("--plot", tmp_path / "o.png")
    for arguments, wanted in (
        ((*vary, "--kind", "map", *plot), "not a plot of 1 varied parameter"),
        ((*vary, "--rank"), "8 runs or more"),
        ((*vary, "--kind", "map"), "--kind needs --plot"),
    ):
        done = run(FILE, *arguments)
        assert done.exit_code in (1, 2) and wanted in done.output, done.output


def test_a_table_of_statistics_takes_the_narrower_form(model):
    study = model.sweep({"mass": "1..3 kg:3"}, ["max(x)", "rms(x)", "peak(x) from 0.1 s"])
    table = study.statistics().table()
    assert table.title == "statistics over 3 runs" and table.header[1] == "max(x) [mm]"
    assert max(map(len, table_text(table).splitlines())) <= 79
    many = [f"quantile(x, 0.{k})" for k in range(10, 50, 3)]
    wide = model.sweep({"mass": [1.0]}, many).statistics().table()
    assert wide.title == "statistics over 1 run" and wide.header[1:3] == ("mean", "sd")


def test_the_memory_of_a_sweep_grows_by_its_observables_only(model):
    """Instants of 150 runs more would take 9 MB, those of a batch on each processor 1 MB."""
    peaks = []
    for count in (50, 50, 200):  # the first sweep fills caches
        vary = {"mass": np.linspace(1, 3, count)}
        tracemalloc.start()
        study = model.sweep(vary, ["max(x)"], every="5 ms")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert study.done.sum() == 200
    assert peaks[2] < peaks[1] + 2_000_000
