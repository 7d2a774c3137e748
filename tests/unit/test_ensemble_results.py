"""Parameters of ensembles, their results and files, and their interruption."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from ensembles import OSCILLATOR, interrupt_after
from model_files import model_text

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.runs import Interrupted
from bgc.runtime.running import batches, partial_ensemble

pytestmark = pytest.mark.slow

MODELS = Path(__file__).parents[1] / "models"
FIXED = {"solver": "ros34prw", "step": 0.01}


# --- parameters -------------------------------------------------------------------------------


def test_parameters_are_lists_with_units_or_sets(oscillator):
    by_name = oscillator.simulate_many({"mass": ["2000 g", 3.0], "k": "20 N/m"}, **FIXED)
    by_set = oscillator.simulate_many([{"mass": 2, "k": 20}, {"mass": "3 kg", "k": 20}], **FIXED)
    np.testing.assert_array_equal(by_name.parameters["mass"], [2, 3])
    np.testing.assert_array_equal(by_name.parameters["k"], [20, 20])
    np.testing.assert_array_equal(by_name.values, by_set.values)


def test_what_was_set_before_holds_for_all(oscillator_file):
    model = bgc.compile(oscillator_file)
    model.parameters["k"] = 25.0
    ensemble = model.simulate_many({"mass": [1.0, 2.0]}, **FIXED)
    assert list(ensemble.parameters) == ["mass"]
    expected = model.simulate(parameters={"mass": 2.0}, **FIXED)
    np.testing.assert_array_equal(ensemble["q"][1], expected["q"])


@pytest.mark.parametrize(
    ("sets", "code"),
    [
        ({"mass": [1, 2], "k": [1, 2, 3]}, "BG740"),
        ([], "BG741"),
        ({"mass": []}, "BG741"),
        ({"weight": [1, 2]}, "BG060"),
        ({"mass": ["1 m", "2 m"]}, "BG063"),
    ],
)
def test_parameters_that_make_no_sense(oscillator, sets, code):
    with pytest.raises(BgError) as caught:
        oscillator.simulate_many(sets)
    assert caught.value.diagnostics[0].code == code


def test_a_file_that_changed_is_not_mixed_with_the_model_in_memory(tmp_path):
    path = tmp_path / "edited.bg"
    path.write_text(OSCILLATOR)
    model = bgc.compile(path)
    path.write_text(OSCILLATOR.replace(")^2)", ")^4)"))
    with pytest.raises(BgError) as caught:
        model.simulate_many({"k": [1, 2, 3, 4]})
    assert caught.value.diagnostics[0].code == "BG742"


# --- the result -------------------------------------------------------------------------------


def test_outputs_are_found_by_name_and_vectors_whole():
    model = bgc.compile(MODELS / "handle.bg", scene="position")
    ensemble = model.simulate_many([{}, {}], 0.1, every=0.05)
    vector = next(n.partition("[")[0] for n in ensemble.names if n.endswith("[1]"))
    assert ensemble[vector].shape == (2, 3, 3)
    assert ensemble[f"{vector}[2]"].shape == (2, 3)
    assert vector in ensemble and "nothing" not in ensemble
    with pytest.raises(KeyError):
        ensemble["nothing"]


def test_files_have_every_row_with_its_parameters(oscillator, tmp_path):
    ensemble = oscillator.simulate_many({"k": [5, 6]}, **FIXED)
    ensemble.to_csv(tmp_path / "many.csv")
    with (tmp_path / "many.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["instance", "k", "time", "q", "v"]
    assert len(rows) == 2 * 7
    assert (rows[-1]["instance"], float(rows[-1]["k"]), float(rows[-1]["time"])) == ("1", 6, 3)
    assert float(rows[-1]["q"]) == ensemble["q"][1, -1]
    ensemble.to_npz(tmp_path / "many.npz")
    with np.load(tmp_path / "many.npz") as archive:
        np.testing.assert_array_equal(archive["values"], ensemble.values)
        np.testing.assert_array_equal(archive["parameter:k"], [5, 6])
        assert list(archive["names"]) == ["q", "v"]


TURNTABLE = model_text("ensemble_results_turntable")


def test_an_ensemble_is_a_mapping_of_quantities_in_their_shapes(tmp_path):
    (tmp_path / "turn.bg").write_text(TURNTABLE)
    speeds = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    model = bgc.compile(tmp_path / "turn.bg")
    ensemble = model.simulate_many({"speed": speeds})
    angle = np.outer(speeds, ensemble.time)
    c, s = np.cos(angle), np.sin(angle)
    close = {"rtol": 0, "atol": 1e-9}
    np.testing.assert_allclose(
        ensemble["axes"], np.moveaxis([[c, -s], [s, c]], (0, 1), (2, 3)), **close
    )
    np.testing.assert_allclose(ensemble["tip"], np.moveaxis([2000 * c, 2000 * s], 0, 2), atol=1e-6)
    np.testing.assert_allclose(ensemble["tip.y"], 2000 * s, atol=1e-6)
    np.testing.assert_allclose(ensemble["angle"], np.degrees(angle), atol=1e-6)
    assert ensemble.count == 5 and len(ensemble) == 7 and "axes" in ensemble
    assert list(ensemble) == list(ensemble.keys()) == list(ensemble.names)
    assert {name: values.shape for name, values in ensemble.items()} == dict.fromkeys(
        ensemble.names, (5, 5)
    )
    assert ensemble["time"] is ensemble.time and ensemble.get("nothing") is None
    for name in ("axes", "tip", "angle", "time"):
        whole = ensemble[name] if name == "time" else ensemble[name][3]
        assert np.array_equal(ensemble.run(3)[name], whole)


def test_xarrays_of_one_run_and_of_many_are_of_one_kind(oscillator):
    xarray = pytest.importorskip("xarray")
    many = oscillator.simulate_many({"k": [5, 6]}, **FIXED)
    found, one = many.to_xarray(), many.run(1).to_xarray()
    assert isinstance(found, xarray.Dataset) and list(found) == list(one) == ["q", "v"]
    assert found["q"].dims == ("instance", "time") and found["k"].attrs["units"] == "N/m"
    assert found["q"].attrs == one["q"].attrs == {"units": "m"}
    assert found["status"].values.tolist() == ["done", "done"]
    xarray.testing.assert_equal(found.isel(instance=1).drop_vars(["k", "status"]), one)


def test_a_parameter_named_as_an_output_stays_apart(tmp_path):
    pytest.importorskip("xarray")
    (tmp_path / "turn.bg").write_text(
        TURNTABLE.replace("spring.q in deg as angle", "drive.f as speed")
    )
    many = bgc.compile(tmp_path / "turn.bg").simulate_many({"speed": [1.0, 2.0]})
    data = many.to_xarray()
    assert data["parameter:speed"].values.tolist() == [1, 2]
    assert data["speed"].values.tolist() == [[1] * 5, [2] * 5]


def test_ctrl_c_keeps_what_was_computed(oscillator, monkeypatch):
    waits = iter(range(2))
    original = batches.wait

    def interrupted_wait(*arguments, **named):
        if next(waits, None) == 0:
            raise KeyboardInterrupt
        return original(*arguments, **named)

    monkeypatch.setattr(batches, "wait", interrupted_wait)
    sets = {"k": np.linspace(5, 6, 40)}
    with pytest.raises(Interrupted) as caught:
        oscillator.simulate_many(sets, 1e5, every=1e4, solver="rk4", step=1e-5)
    result = caught.value.result
    assert result.count == 40
    assert set(result.status) <= {"done", "interrupted"}
    assert "interrupted" in result.status


@pytest.mark.parametrize("vectorised", [True, False])
def test_an_interrupted_ensemble_is_resumed_with_the_same_numbers(
    oscillator, monkeypatch, tmp_path, vectorised
):
    monkeypatch.setattr(partial_ensemble, "FOLDER", str(tmp_path / "sweeps"))
    sets = {"k": np.linspace(5, 6, 40)}
    options = {**FIXED, "vectorised": vectorised, "resume": True}
    whole = oscillator.simulate_many(sets, **options)
    with monkeypatch.context() as patch:
        interrupt_after(patch, 2)
        with pytest.raises(Interrupted) as caught:
            oscillator.simulate_many(sets, **options)
    partial = caught.value.result
    done = partial.status.count("done")
    assert caught.value.kept and 0 < done < 40
    out = tmp_path / "part.csv"
    partial.to_csv(out)
    with out.open() as file:
        numbers = {int(row["instance"]) for row in csv.DictReader(file)}
    assert numbers == {k for k, status in enumerate(partial.status) if status == "done"}
    partial.to_npz(tmp_path / "part.npz")
    with np.load(tmp_path / "part.npz") as archive:
        assert not np.isnan(archive["values"]).any()
        assert set(archive["instance"].tolist()) == numbers
        np.testing.assert_array_equal(archive["parameter:k"], sets["k"][archive["instance"]])

    resumed = oscillator.simulate_many(sets, **options)
    assert resumed.recalled == done and resumed.done.all()
    np.testing.assert_array_equal(resumed.values, whole.values)
    np.testing.assert_array_equal(resumed.parameters["k"], sets["k"])
    assert not list((tmp_path / "sweeps").glob("*"))
    assert oscillator.simulate_many(sets, **options).recalled == 0


def test_another_ensemble_or_a_damaged_file_is_not_resumed(oscillator, monkeypatch, tmp_path):
    monkeypatch.setattr(partial_ensemble, "FOLDER", str(tmp_path / "sweeps"))
    sets = {"k": np.linspace(5, 6, 40)}
    with monkeypatch.context() as patch:
        interrupt_after(patch, 2)
        with pytest.raises(Interrupted):
            oscillator.simulate_many(sets, **FIXED, resume=True)
    for other in ({"k": np.linspace(5, 6.1, 40)}, {**sets, "mass": 2.0}):
        assert oscillator.simulate_many(other, **FIXED, resume=True).recalled == 0
    (path,) = (tmp_path / "sweeps").glob("*.npz")
    path.write_bytes(path.read_bytes()[:200])
    assert oscillator.simulate_many(sets, **FIXED, resume=True).recalled == 0
