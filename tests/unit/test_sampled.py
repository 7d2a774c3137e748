"""Sampled parts in the language and in the passes: words, slicing, linear form, ensembles."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
import sympy
from model_files import model_text
from parsed import items

import bgc
from bgc.building.recall import recall
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.grammar import syntax
from bgc.language.solver import Solver
from bgc.options import Options
from bgc.printing.stages import show_equations
from bgc.runtime.linearising.operating_point import OpenedModel
from bgc.runtime.linearising.symbolic import transfer_at
from bgc.runtime.running.run import set_method

MODELS = Path(__file__).parents[1] / "models"


@pytest.mark.parametrize(
    ("head", "offset"),
    [
        ("10 ms", None),
        ("10 ms offset 2 ms", "2 ms"),
        ("0.01 offset 0.002", "0.002"),
        ("T", None),
        ("(T) offset T/2", "T/2"),
        ("2*sample offset offset", "offset"),
        ("\n 1 s", None),
    ],
)
def test_a_sample_begins_before_an_expression(head, offset):
    (item,) = items(f"sample {head} {{ state i = 0; next (i) = i + 1; output next = i; }}")
    assert isinstance(item, syntax.Sample)
    assert (item.offset.span.text if item.offset else None) == offset
    assert [type(inner) for inner in item.items] == [syntax.Value, syntax.Next, syntax.Value]


MODEL = model_text("sampled")


def stages(tmp_path, text, until="slice"):
    path = tmp_path / "m.bg"
    path.write_text(text)
    return compile_scene(path, Options(verify=True), until=until)


def test_slicing_keeps_what_held_values_need(tmp_path):
    sliced = stages(tmp_path, MODEL).sliced
    assert [state.name for state in sliced.states] == ["x", "y"]
    assert [held.name for held in sliced.held] == ["i", "u"] and len(sliced.rates) == 1
    shown = show_equations(sliced)
    assert "next(i) = y + i" in shown and "i(0) = 3" in shown and "u = i - x" in shown


def test_a_scene_of_held_values_alone_runs(tmp_path):
    path = tmp_path / "m.bg"
    path.write_text(MODEL.replace("observe x;", "observe other, idle, i;"))
    result = bgc.compile(path).simulate(0.1)
    assert np.all(np.isfinite(result["idle"]))


def test_models_without_sampled_parts_have_no_trace_of_them():
    emitted = compile_scene(MODELS / "events.bg", Options("ball"), until="emit").emitted
    assert "sampled" not in emitted.units[0].parts
    assert not any(word in unit.text for unit in emitted.units for word in ("n_slot", "held"))


def test_a_linear_form_takes_held_values_as_constants(tmp_path):
    """At a time the state is that of the whole model, with its sampled parts."""
    path = tmp_path / "m.bg"
    path.write_text(MODEL)
    opened = OpenedModel(path, Options(), (), ("x",))
    linear = opened.linearise(opened.operating_point(0.05))
    assert linear.states == ("x",)
    np.testing.assert_array_equal(linear.A, [[-1]])
    run = bgc.compile(path).simulate(0.05, every=0.05)
    np.testing.assert_allclose(linear.point, run["x"][-1:], rtol=1e-6)
    with pytest.raises(BgError, match="BG772"):
        opened.operating_point("steady")


def test_ensembles_run_one_by_one():
    model = bgc.compile(MODELS / "sampled.bg", scene="control")
    values = [0.5e-3, 1e-3, 2e-3, 3e-3]
    many = model.simulate_many({"T": values}, 0.05, every=0.01)
    assert many.alone == "the model has sampled parts"
    for k, period in enumerate(values):
        alone = model.simulate(0.05, every=0.01, parameters={"T": period})
        np.testing.assert_array_equal(many.values[k, :, 0], alone["speed"])


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_a_period_must_be_positive(value):
    model = bgc.compile(MODELS / "sampled.bg", scene="control")
    with pytest.raises(BgError):
        model.simulate(0.05, parameters={"T": value})


def test_a_period_below_the_resolution_of_time_ends_the_run():
    model = bgc.compile(MODELS / "sampled.bg", scene="control")
    with pytest.raises(BgError, match="BG702"):
        model.simulate(0.05, parameters={"T": 1e-18, "delay": 0.01})


@pytest.mark.parametrize("step", [None, 0.3e-3])
def test_a_run_in_parts_has_the_same_bits(step):
    model = bgc.compile(MODELS / "sampled.bg", scene="control")
    method = Solver("rk4", step=step) if step else Solver("rodas5p")
    times = np.array([0.0, 1e-3, 2e-3, 2e-3, 5.1e-3, 0.0144, 0.03])
    width = model.library.model.n_output
    found = []
    for parts in (False, True):
        instance = model.parameters.instance({})
        assert set_method(instance, method, False) == 0 and instance.reset() == 0
        rows = np.full((len(times), width), np.nan)
        if parts:
            for k in range(len(times)):
                assert instance.run(times[k : k + 1], rows[k : k + 1]) == (0, 1)
        else:
            assert instance.run(times, rows) == (0, len(times))
        found.append(rows)
    np.testing.assert_array_equal(*found)


def test_a_recalled_build_has_the_places_of_jumps_and_held_values(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path = tmp_path / "m.bg"
    path.write_text(MODEL.replace("sample T {", "when x > 9 { reset x = 0; }\n  sample T {"))
    first = compile_scene(path, Options()).built
    again = recall(path, Options())
    assert again is not None and again.places == first.places
    assert first.places.jumps and [place.states for place in first.places.held] == [("i",), ("u",)]


def test_a_transfer_function_has_letters_for_held_values(tmp_path):
    """The response of `x' = -k u x` to k, with a held u, is -u x/(s + k u)."""
    path = tmp_path / "m.bg"
    path.write_text(MODEL.replace("-x + u;", "-x*k*u;").replace("param T", "param k = 2;  param T"))
    function, _, _ = transfer_at(path, Options(), "x", "k", None)
    k, u, x = (sympy.Symbol(name) for name in ("k", "u", "x"))
    assert sympy.simplify(function.expression + u * x / (function.laplace + k * u)) == 0


AT_INSTANTS = model_text("sampled_at_instants")


@pytest.mark.parametrize("options", [{}, {"solver": "dopri5"}, {"solver": "rk4", "step": 0.01},
                                     {"solver": "ros34prw", "step": 0.013}])  # fmt: skip
def test_a_switch_of_time_at_an_instant_comes_before_it_whatever_the_rounding(options, tmp_path):
    """Multiples of the period lie before, at and after the time of the switch by rounding."""
    path = tmp_path / "m.bg"
    path.write_text(AT_INSTANTS)
    model = bgc.compile(path, preview=True)
    for period, k in itertools.product([0.05, 0.1, 0.2, 0.3, 0.7], [2, 3, 6, 7]):
        at = round(period * k, 6)
        run = model.simulate(
            at + 3 * period, every=period, parameters={"T": period, "at": at}, **options
        )
        rows = np.arange(len(run.time))
        np.testing.assert_array_equal(run["count"], rows + 1)
        for name in ("seen", "alone", "switched"):
            np.testing.assert_array_equal(run[name], np.repeat(rows[:, None] >= k, 4, axis=1))
        np.testing.assert_allclose(run["x"][-1], 3 * period, rtol=1e-9)
