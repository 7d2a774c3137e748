"""Inputs that a program gives to one run, against closed forms."""

from math import nan

import numpy as np
import pytest

import bgc

TEXT = """
model Lag {
  param tau : s = 1 s;
  input level : m = 0 m;
  input pair[2] : N = [1, 1];
  state x : m = 0 m;
  der(x) = (level - x)/tau;
}
model Two { param far = 1; part : Lag; given : Lag(level = far*1 m); }
scene plain of Two {
  drive part.level = 7 m;
  observe part.x as x, part.pair as p;
  run 3 s every 0.1 s;
}
scene longer is plain { solver rodas5p(rtol = 1e-9, atol = 1e-12); }
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    path = tmp_path_factory.mktemp("inputs") / "a.bg"
    path.write_text(TEXT)
    model = bgc.compile(path, "longer", preview=True)
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
