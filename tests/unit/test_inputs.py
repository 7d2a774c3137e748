"""Inputs that a program gives to one run, against closed forms."""

from math import nan

import numpy as np
import pytest
from model_files import model_file
from refusals import refusals

import bgc


@pytest.fixture(scope="module")
def model():
    model = bgc.compile(model_file("inputs"), "longer", preview=True)
    model.parameters["part.tau"] = 0.5
    return model


def test_values_at_times_are_joined_by_straight_lines(model):
    """The answer of a lag to a triangle whose knots lie between rows; parameters are kept."""
    times, top, tau = np.array([0, 1.03, 2.51, 4]), 0.2, 0.5
    forces = np.array([["0 N", 1], [2, "4 kN"], [2, 2], [0, 0]], dtype=object)
    result = model.simulate(inputs={
        "part.level": (times, ["0 mm", "200 mm", 0.2, 0.2]), "part.pair": (times, forces),
    })  # fmt: skip
    t, rise = result.time, top / 1.03
    exact = rise * (t - tau + tau * np.exp(-t / tau))
    held = top + (rise * (1.03 - tau + tau * np.exp(-1.03 / tau)) - top) * np.exp((1.03 - t) / tau)
    np.testing.assert_allclose(result["x"], np.where(t < 1.03, exact, held), atol=1e-9)
    np.testing.assert_allclose(result["p[2]"], np.interp(t, times, [1, 4000, 2, 0]), rtol=1e-12)
    assert model.simulate("0.1 s")["x"][-1] == pytest.approx(7 * (1 - np.exp(-0.2)))


def test_a_function_is_sampled_at_the_rows(model):
    """pchip between rows 0.1 s apart: the third-order error of a smooth function."""
    asked = []

    def level(t):
        asked.append(t)
        return 0.1 * np.sin(t)

    given = {"part.level": level, "part.pair": [3, "2 kN"]}
    result = model.simulate("2 s", inputs=given, parameters={"part.tau": "1 s"})
    t = result.time
    assert asked == t.tolist()
    np.testing.assert_allclose(result["x"], (np.sin(t) - np.cos(t) + np.exp(-t)) / 20, atol=1e-5)
    assert result["p[2]"][0] == 2000 and result["p[1]"][-1] == 3


def test_a_start_at_rest_is_kept_where_the_model_is_compiled_again(model):
    given = model.simulate("1 s", inputs={"part.level": 2}, start="rest")
    assert given.at_rest is not None
    np.testing.assert_allclose(given["x"], 2, rtol=1e-9)
    shown = model.simulate("1 s", shapes=True, start="rest")
    np.testing.assert_allclose(shown["x"], 7, rtol=1e-9)


RISING = ([0, 3], [0, 1])


@pytest.mark.parametrize(("name", "value", "code"), [
    ("part.levl", 1, "BG210"),
    ("part", 1, "BG603"),
    ("part.tau", RISING, "BG603"),
    ("part.pair[1]", RISING, "BG603"),
    ("given.level", 1, "BG220"),
    ("part.level; x", 1, "BG101"),
    ("part.level", "1 N", "BG306"),
    ("part.level", ([0, 3], [0, "1 N"]), "BG306"),
    ("part.level", ([0, 3], ["1 m", "1 N"]), "BG306"),
    ("part.pair", [1, 2, 3], "BG315"),
    ("part.pair", ([0, 3], [[1, 2, 3], [1, 2, 3]]), "BG315"),
    ("part.level", "tau", "BG062"),
    ("part.level", ([0, "3 m"], [0, 1]), "BG063"),
    *(("part.level", bad, "BG260") for bad in ({0: 1}, None, True, 1j, object(), ("0 s", {}))),
    ("part.level", (3, [0, 1]), "BG260"),
    ("part.level", ([0, 3], 1), "BG260"),
    ("part.level", ([0, 2, 2, 3], [0, 1, 2, 3]), "BG261"),
    ("part.level", ([0], [1]), "BG261"),
    ("part.level", ([0, nan], [0, 1]), "BG261"),
    ("part.level", (range(10_001), range(10_001)), "BG261"),
    ("part.level", ([0, 2.9], [0, 1]), "BG262"),
    ("part.level", ([0.1, 3], [0, 1]), "BG262"),
    ("part.level", ([0, 3], [0, nan]), "BG263"),
    ("part.level", 10**400, "BG263"),
    ("part.level", lambda t: 1 / (t - 1) if abs(t - 1) > 0.01 else np.inf, "BG263"),
    ("part.level", ([0, 3], [0, 1, 2]), "BG264"),
    ("part.pair", ([0, 3], [[1, 2], [1]]), "BG264"),
])  # fmt: skip
def test_an_input_that_cannot_be_is_refused(model, name, value, code):
    with pytest.raises(bgc.BgError) as caught:
        model.simulate(inputs={name: value})
    assert [d.code for d in caught.value.diagnostics] == [code]
    assert all(d.help for d in caught.value.diagnostics)


# --- many runs and runs in steps ------------------------------------------------------------------


def test_one_set_of_inputs_is_for_all_runs(model):
    """Each run is that of `simulate` with its parameters, and a sweep's too."""
    inputs = {"part.level": ([0, 1.5, 4], [0, 0.3, 0.1]), "part.pair": [3, "2 kN"]}
    some = model.simulate_many({"part.tau": [0.4, 0.8]}, inputs=inputs)
    for k, tau in enumerate((0.4, 0.8)):
        alone = model.simulate(inputs=inputs, parameters={"part.tau": tau})
        np.testing.assert_allclose(some["x"][k], alone["x"], atol=1e-9)
    study = model.sweep({"part.tau": [0.4, 0.8]}, ["last(x)"], inputs=inputs)
    np.testing.assert_allclose(study["last(x)"], some["x"][:, -1], rtol=1e-12)
    assert list(study.parameters) == ["part.tau"] and model.parameters["part.tau"].value == 0.5


def test_a_recorded_input_is_given_to_an_estimation(model):
    inputs = {"part.level": ([0, 1.5, 4], [0, 0.3, 0.1])}
    motion = model.simulate(inputs=inputs, parameters={"part.tau": 0.8})
    found = model.fit(
        {"time": motion.time, "x": motion["x"]}, {"part.tau": "0.2..2 s"}, inputs=inputs
    )
    assert found["part.tau"] == pytest.approx(0.8, rel=1e-6)


def test_each_run_has_its_own_inputs(model):
    """Constants, pairs with times of their own and functions; each as a run of its own."""
    rising = [0, 0.5, 3.0], ["0 mm", "300 mm", 0.2]
    sets = [
        {"part.level": rising, "part.pair": [1, "1 kN"]},
        {"part.level": ([0, 1.2, 5], [0.3, -0.1, 0.1]), "part.pair": [2, 3]},
        {"part.level": "40 cm", "part.pair": [5, 4]},
    ]
    for vectorised in (False, True):
        some = model.simulate_many({}, inputs=sets, vectorised=vectorised)
        assert not some.failures and some.parameters == {}
        for k, inputs in enumerate(sets):
            alone = model.simulate(inputs=inputs)
            np.testing.assert_allclose(some["x"][k], alone["x"], atol=2e-9)
            np.testing.assert_array_equal(some["p[2]"][k], alone["p[2]"])
    sines = [{"part.level": lambda t, a=a: a * np.sin(t)} for a in (0.1, 0.2)]
    two = model.simulate_many({"part.tau": ["1 s", "1 s"]}, "2 s", inputs=sines)
    shape = (np.sin(two.time) - np.cos(two.time) + np.exp(-two.time)) / 2
    np.testing.assert_allclose(two["x"], np.outer((0.1, 0.2), shape), atol=1e-5)


PAIR = {"part.level": RISING}


@pytest.mark.parametrize(("parameters", "inputs", "code"), [
    ({"part.tau": [1, 2, 3]}, [PAIR, PAIR], "BG560"),
    ({}, [PAIR, {}], "BG560"),
    ({}, [PAIR, {"part.pair": [1, 2]}], "BG560"),
    ({}, [{"part.pair": [1, 2]}, {"part.pair": 1}], "BG560"),
    ({}, [PAIR, {"part.level": np.sin}], "BG561"),
    ({}, [{"part.level": (np.linspace(0, 3, n), np.zeros(n))} for n in (4999, 5003)], "BG562"),
    ({}, [PAIR, {"part.level": ([0, 3], [0])}], "BG264"),
    ({}, [PAIR, {"part.level": ([0, 2], [0, 1])}], "BG262"),
    ({}, [PAIR, {"part.level": nan}], "BG263"),
    ({}, [PAIR, {"part.level": {}}], "BG260"),
    ({}, [PAIR, {"part.level": "1 N"}], "BG306"),
    ({}, [PAIR, {"part.level": "much"}], "BG062"),
    ({}, [{"part.levl": 1}, {"part.levl": 2}], "BG210"),
])  # fmt: skip
def test_wrong_inputs_of_many_runs_are_refused(model, parameters, inputs, code):
    assert refusals(model.simulate_many, parameters, inputs=inputs)[0].code == code


def test_an_input_is_held_until_a_run_in_steps_changes_it(model):
    """The answer of a lag to a staircase, and a pair that goes on behind its last time."""
    tau, x = 0.5, 0.0
    inputs = {"part.level": "20 cm", "part.pair": ([0, 0.5], [[0, 0], [1, 2]])}
    with model.step(inputs=inputs) as run:
        for level, interval in ((None, 0.3), (1.0, 0.25), ("-300 mm", 0.45), (0, 1.0)):
            given = {} if level is None else {"part.level": level}
            values = run.advance(interval, inputs=given)
            metres = {None: 0.2, "-300 mm": -0.3}.get(level, level)
            x = metres + (x - metres) * np.exp(-interval / tau)
            assert values["x"] == pytest.approx(x, abs=1e-8)
        assert run.time == 2.0 and values["p[2]"] == 2
        with model.step(inputs={"part.pair": 3}) as spread:
            assert spread.advance(0.1, inputs={"part.pair": 4})["p[2]"] == 4
        for wrong, code in (
            ({"part.pair": [1, 2]}, "BG564"),
            ({"part.tau": 1}, "BG564"),
            ({"part.level": "1 N"}, "BG063"),
            ({"part.level": "much"}, "BG062"),
        ):
            assert refusals(run.advance, 0.1, inputs=wrong)[0].code == code
        assert run.advance(0.1)["x"] == pytest.approx(x * np.exp(-0.1 / tau), abs=1e-8)


def test_a_run_in_steps_keeps_its_energies_where_an_input_changes(tmp_path):
    path = tmp_path / "a.bg"
    path.write_text("""
model Push {
  input force : N = 0 N; push : Se(force); m : I(2 kg); r : R(1 N*s/m); j : J1; push -> j -> m, r;
}
scene s of Push {
  observe m.f as v, energy.supplied, energy.residual, energy.stored; run 1 s;
  solver rodas5p(rtol = 1e-9, atol = 1e-12);
}
""")
    model = bgc.compile(path, preview=True)
    with model.step(inputs={"force": 1.0}) as run:
        run.advance(0.7)
        values = run.advance(0.5, inputs={"force": 3})
    v1 = 1 - np.exp(-0.35)
    v = 3 + (v1 - 3) * np.exp(-0.25)
    moved = (0.7 - 2 * v1, 3 * 0.5 - 2 * (v - v1))  # (F*t - m*dv)/r
    assert values["v"] == pytest.approx(v, rel=1e-8)
    with model.step(inputs={"force": "1 kN"}) as run:
        assert run.advance(0.1, inputs={"force": 0})["v"] == 0
    assert values["energy.stored"] == pytest.approx(v * v, rel=1e-7)
    assert values["energy.supplied"] == pytest.approx(moved[0] + 3 * moved[1], rel=1e-6)
    assert abs(values["energy.residual"]) < 1e-7


@pytest.mark.parametrize(("inputs", "code"), [
    ({"part.level": np.sin}, "BG563"),
    ({"part.level": nan}, "BG263"),
    ({"part.levl": 1}, "BG210"),
    ({"part.tau": 1}, "BG603"),
    ({"part.pair": [1, 2, 3]}, "BG315"),
    ({"part.level": "1 N"}, "BG063"),
])  # fmt: skip
def test_wrong_inputs_of_a_run_in_steps_are_refused(model, inputs, code):
    assert refusals(model.step, inputs=inputs)[0].code == code
