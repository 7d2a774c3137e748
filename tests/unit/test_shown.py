"""Units as written: shown everywhere through one mechanism, while values stay in SI."""

from __future__ import annotations

import csv
import json
import math

import numpy as np
import pytest
from model_files import model_file

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source
from bgc.grammar.parse import parse
from bgc.linearising.analysis_scene import open_scene
from bgc.options import Options
from bgc.runtime.fmi.fmu_model import prepare_model
from bgc.runtime.linear.linear_tables import linear_tables
from bgc.runtime.measuring.judging import quantities_of
from bgc.runtime.model import Model
from bgc.runtime.realtime.course import Course
from bgc.runtime.results.summary import extremes
from bgc.runtime.running.model_loading import load_as
from bgc.runtime.running.simulate import method_of
from bgc.runtime.stress.drives import read_drive
from bgc.runtime.view.scene_description import describe_model
from bgc.values.shown_units import Shown
from bgc.values.units import Written, parse_unit, shown_of, si_symbol, times_seconds

FILE = model_file("shown")


@pytest.fixture(scope="module")
def model() -> Model:
    return bgc.compile(FILE)


@pytest.fixture(scope="module")
def result(model):
    return model.simulate()


def test_units_come_from_declarations_literals_and_domains(result):
    shown = {name: result.shown_in(name).unit for name in result}
    assert shown == {
        "pressure": "bar", "higher": "bar", "back": "deg", "tank.inlet.rate": "L/min",
        "wheel.body.f": "rad/s", "wheel.body.e": "N*m", "loose.f": "rad/s", "loose.p": "N*m*s",
        "angle [deg]": "deg", "turned [mrad]": "mrad", "speed [rpm]": "rpm",
        "energy.stored": "J", "energy.supplied [kWh]": "kWh", "energy.residual [mJ]": "mJ",
        "kept [mJ]": "mJ", "pair[1] [deg]": "deg", "pair[2] [deg]": "deg",
    }  # fmt: skip


def test_arrays_stay_in_si_but_for_columns_in_a_unit(result):
    angle = math.radians(30) * np.exp(-result.time)
    np.testing.assert_allclose(result["back"], -angle, rtol=1e-5)
    np.testing.assert_allclose(result["angle [deg]"], np.degrees(angle), rtol=1e-5)
    np.testing.assert_allclose(result["turned [mrad]"], 1e3 * angle, rtol=1e-5)
    np.testing.assert_allclose(result["pair [deg]"][:, 1], 2 * np.degrees(angle), rtol=1e-5)
    np.testing.assert_allclose(result["speed [rpm]"], 5 / 3 * result.time * 30 / np.pi, rtol=1e-5)
    assert result.units["pressure"] == "Pa"
    np.testing.assert_allclose(result.in_words("pressure") * 1e5, result["pressure"], rtol=1e-15)
    np.testing.assert_allclose(result.in_words("back"), -np.degrees(angle), rtol=1e-5)


def test_files_say_both_units(result, tmp_path):
    result.to_csv(tmp_path / "r.csv")
    with (tmp_path / "r.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[0]["angle [deg]"]) == pytest.approx(30, rel=1e-14)
    assert float(rows[-1]["pressure"]) == result["pressure"][-1]
    result.to_npz(tmp_path / "r.npz")
    about = json.loads(str(np.load(tmp_path / "r.npz")["about"]))
    assert about["units"]["pressure"] == "Pa" and about["shown"]["pressure"] == "bar"
    assert about["units"]["angle [deg]"] == about["shown"]["angle [deg]"] == "deg"


def test_the_summary_is_in_units_as_written(result):
    rows = {line.split("  ")[1].strip(): line for line in extremes(result).splitlines()[1:]}
    assert rows["pressure [bar]"].split()[-2] == f"{result['pressure'].max() / 1e5:.6g}"
    off = float(rows["pressure [bar]"].split()[-1])
    assert off == pytest.approx(result.error["pressure"].max() / 1e5, rel=0.5)
    assert rows["back [deg]"].split()[3] == "-30"
    assert rows["angle [deg]"].split()[-2] == "30"


def test_plots_are_in_units_as_written(result):
    upper, lower = result.plot().axes[:2]
    assert upper.get_ylabel() == "[deg]" and lower.get_ylabel() == "[bar]"
    drawn = lower.get_lines()[0].get_ydata()
    np.testing.assert_allclose(drawn, result["pressure"] / 1e5)


def test_parameters_are_in_units_as_written(model):
    supply = model.parameters["pump.supply"]
    assert (supply.value, supply.unit) == (2e7, "Pa")
    assert repr(supply) == "<parameter pump.supply = 200 bar>"
    assert "  rest = 30 deg" in repr(model.parameters)
    assert "  constant = 0.5 N*m/A" in repr(model.parameters)
    with pytest.raises(BgError, match=r"400 bar is outside .* 0 \.\. 350 bar"):
        model.simulate(parameters={"pump.supply": "400 bar"})


def test_other_tables_are_in_units_as_written(model):
    linear = model.linearise()
    (point, *_) = linear_tables(linear, full=True)
    assert ("angle", "30", "deg") in point.rows
    known = model.parameters
    drive = read_drive(
        "pump.supply=100 bar..200 bar:2",
        {name: known[name].unit for name in known},
        {name: known[name].shown for name in known},
    )
    assert [drive.shown.text(value) for value in drive.values] == ["100 bar", "200 bar"]
    rows = np.zeros((2, len(model.measured)))
    required = dict(model.facts.requirements)
    quantity = quantities_of(model.measured, rows, required)[0]
    assert quantity.required and quantity.shown.text(quantity.scale) == "0.1 bar"


def test_ensembles_and_warm_starts_keep_the_units(model):
    ensemble = model.simulate_many({"rest": [0.1, 0.2]}, vectorised=False)
    assert ensemble.shown["pressure"] == Shown("bar", 1e5)
    warm = load_as(Model, FILE, Options(), {})
    assert warm.warm and warm.simulate().shown_in("pressure") == Shown("bar", 1e5)
    assert warm.parameters["rest"].shown.text(math.pi / 6) == "30 deg"


def test_an_output_can_be_asked_for_by_its_plain_name():
    opened = open_scene(FILE, Options(), (), ("turned", "speed [rpm]"))
    assert [(o.name, o.unit) for o in opened.program.observations] == [
        ("turned", "rad"),
        ("speed [rpm]", "rpm"),
    ]


def test_accounts_are_in_their_units_wherever_rows_are_read(model, result, tmp_path):
    """J per unit times the column is the account, in a run, an ensemble, a study and a page."""
    columns = {"energy.stored": 1.0, "kept [mJ]": 1e-3, "energy.supplied [kWh]": 3.6e6}
    last = {name: float(result[name][-1]) for name in columns}
    stored, kept, supplied = (last[name] * factor for name, factor in columns.items())
    assert stored == pytest.approx(kept, rel=1e-15) and supplied > stored > 1
    dissipated = supplied - stored  # of the pipe: a residual in J would be a thousandth
    assert dissipated > 1 and result.in_joules("supplied")[-1] == supplied
    np.testing.assert_allclose(result.in_joules("residual"), result["energy.residual [mJ]"] * 1e-3)
    assert not result.warnings

    with model.step() as run:
        run.advance(result.time[-1])
        assert run.values == pytest.approx({n: result[n][-1] for n in result}, rel=1e-6, abs=1e-4)
    texts = [f"max({name})" for name in ("energy.stored", "kept", "energy.supplied")]
    for vectorised in (False, True):
        some = model.simulate_many({"rest": [0.1] * 4}, vectorised=vectorised)
        assert [some[name][0, -1] for name in columns] == pytest.approx(list(last.values()))
    study = model.sweep({"rest": [0.1] * 4}, texts)
    assert study.values[0].tolist() == pytest.approx(list(last.values()))

    rows = np.arange(float(model.row_width))[None, :]
    chosen, method = model.selection(), method_of(model)[0]
    with model.started(method, accounts=True) as instance:
        course = Course(model, method, instance)
        live = dict(zip(course.columns, course.outputs(rows)[0].tolist(), strict=True))
    for quantity in describe_model(model, "rig.bg")["observed"]:
        name, number = quantity["name"], quantity["column"] / quantity["factor"]
        assert number == pytest.approx(live[name] / result.shown_in(name).factor, rel=1e-15)
        assert name not in columns or quantity["factor"] == columns[name]
    back = np.zeros_like(rows)
    chosen.fill(back, chosen.of(rows))
    places = list(chosen.places)
    np.testing.assert_allclose(back[0, places], rows[0, places], rtol=1e-15)


def test_accounts_of_an_fmu_are_in_joules_with_a_unit_of_display():
    found = {v.name: v for v in prepare_model(FILE, Options(), 2).table.of("account")}
    assert {name: (v.unit, v.causality, v.shown) for name, v in found.items()} == {
        "energy.stored": ("J", "output", None),
        "energy.supplied": ("J", "output", Shown("kWh", 3.6e6)),
        "energy.dissipated": ("J", "local", None),
        "energy.residual": ("J", "output", Shown("mJ", 1e-3)),
    }


def test_a_dimension_remembers_its_unit_and_equals_the_plain_one():
    unit = parse_unit("kN*m")
    assert unit is not None
    torque = Written(unit.dimension, "kN*m")
    assert torque == unit.dimension and hash(torque) == hash(unit.dimension)
    assert si_symbol(torque) == "N*m" and shown_of(torque) == Shown("kN*m", 1000.0)
    assert si_symbol(times_seconds(torque, 1)) == "N*m*s" and shown_of(unit.dimension) is None


@pytest.mark.parametrize("unit", ["bar", "deg", "rpm", "kWh", "mm", "L/min", "t", "kn"])
def test_short_decimals_survive_the_way_to_si_and_back(unit):
    parsed = parse_unit(unit)
    assert parsed is not None
    shown = Shown(unit, float(parsed.factor))
    for number in (0.1, 0.3, 7.0, 30.0, 1234.5):
        assert shown.number(number * shown.factor) == number
    assert shown.number(math.inf) == math.inf


def test_a_unit_stands_on_either_side_of_the_name():
    text = "scene s of M { observe x in deg, x as b in mm/s, x in 1/s as c, x + 3 m in m as d; }"
    file, wrong = parse(Source("s.bg", text))
    assert not wrong
    (scene,) = file.declarations
    found = [(item.alias, item.unit, item.unit_span.text) for item in scene.items]
    assert found == [
        (None, "deg", "deg"), ("b", "mm/s", "mm/s"), ("c", "1/s", "1/s"), ("d", "m", "m"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("si", "unit", "text"),
    [
        (1e300, Shown("uF", 1e-18), "1e+318 uF"),
        (1.23456789e305, Shown("mm", 1e-3), "1.23457e+308 mm"),
        (1.23456789e306, Shown("mm", 1e-3), "1.23457e+309 mm"),
        (5e-324, Shown("km", 1e3), "4.94066e-327 km"),
        (math.inf, Shown("mm", 1e-3), "inf mm"),
        (0.0, Shown("km", 1e3), "0 km"),
    ],
)
def test_a_number_may_be_outside_the_range_of_doubles_in_its_unit(si, unit, text):
    assert unit.text(si) == text
