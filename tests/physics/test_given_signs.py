"""A parameter that a run makes negative is warned of as one that is written negative."""

import math

import pytest
from model_files import model_file

import bgc


@pytest.fixture(scope="module")
def model():
    return bgc.compile(model_file("given_signs"))


def test_a_resistance_that_is_set_negative_is_warned_of(model):
    (warning,) = model.simulate(parameters={"R": -5}).warnings
    assert warning.code == "BG460"
    assert "resistance of `r`" in warning.message and "-5" in warning.message


def test_what_may_be_negative_is_not(model):
    assert not model.simulate(parameters={"E": -1}).warnings
    assert not model.simulate(parameters={"R": 0.5}).warnings
    assert not model.simulate().warnings


def test_a_constant_stiffness_that_is_negative_runs(tmp_path):
    """It was refused with BG540: the scale of the charge was the root of a negative number."""
    path = tmp_path / "m.bg"
    path.write_text(
        "model M { j : J1; m : I(2 kg); k : C(stiffness = -8 N/m, q0 = 0.1 m); j -> m, k; }"
        "scene s of M { observe k.q as x; run 2 s; }"
    )
    result = bgc.compile(path).simulate()
    assert result["x"][-1] == pytest.approx(0.1 * math.cosh(2 * 2), rel=1e-5)
