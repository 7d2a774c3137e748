"""Moduli that vary within a range without zero are divisors where nothing else is left."""

import math

import numpy as np
import pytest
from model_files import compiled, model_text
from refusals import codes_of
from scipy.integrate import solve_ivp

from bgc.diagnostics.diagnostic import BgError

ROD = model_text("ranged_moduli_rod")

POLE = model_text("ranged_moduli_pole")

SPRINGS = model_text("ranged_moduli_springs")


@pytest.fixture(scope="module")
def rod(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("rod"), ROD.replace("RATIO", "(2 + play*cos(angle))"))


def test_a_driven_rod_moves_its_massless_crank(rod):
    result = rod.simulate(rtol=1e-10)
    angle, time = result["angle"], result["time"]
    assert np.allclose(2 * angle + np.sin(angle), 0.6 + np.sin(0.3) + time, rtol=1e-9)
    ratio = 2 + np.cos(angle)
    assert np.allclose(result["crank.f"], 1 / ratio, rtol=1e-9)
    assert np.allclose(np.abs(result["drive.e"]), 5 / ratio**2, rtol=1e-9)
    assert np.abs(result["energy.residual"]).max() < 1e-8


@pytest.mark.parametrize("play", [2.0, 3.0, -2.5])
def test_parameters_that_let_the_ratio_vanish_are_refused_when_they_are_set(rod, play):
    assert codes_of(rod.simulate, parameters={"play": play}) == ["BG707"]


def test_parameters_that_keep_the_ratio_from_zero_are_taken(rod):
    result = rod.simulate(rtol=1e-10, parameters={"play": -1.9})
    ratio = 2 - 1.9 * np.cos(result["angle"])
    assert np.allclose(result["crank.f"], 1 / ratio, rtol=1e-9)


def test_springs_on_a_massless_lever(tmp_path):
    result = compiled(tmp_path, SPRINGS).simulate(rtol=1e-10)

    def ratios(t):
        angle = 0.5 + t
        across = 0.3 + np.cos(angle) ** 2
        left, right = 2 + np.sin(angle), across**-0.5
        return left, right, np.cos(angle), across**-1.5 * np.cos(angle) * np.sin(angle)

    def flow(t, q):
        """From 3 = 2 left q1 + 3 right q2, whose derivative is zero."""
        left, right, left_rate, right_rate = ratios(t)
        turned = 2 * left_rate * q[0] + 3 * right_rate * q[1]
        return -turned / (2 * left**2 + 3 * right**2)

    def rates(t, q):
        left, right, _, _ = ratios(t)
        return [left * flow(t, q), right * flow(t, q)]

    left, right, _, _ = ratios(0.0)
    start = [0.1, (3 - 2 * left * 0.1) / (3 * right)]
    times = result["time"]
    q = solve_ivp(rates, (0, 4), start, "DOP853", times, rtol=1e-12, atol=1e-13).y
    assert np.allclose(result["spring.q"], q[0], rtol=1e-8, atol=1e-9)
    assert np.allclose(result["other.q"], q[1], rtol=1e-8, atol=1e-9)
    expected = [flow(t, x) for t, x in zip(times, q.T, strict=True)]
    assert np.allclose(result["lever.f"], expected, rtol=1e-7, atol=1e-8)
    assert np.abs(result["energy.residual"]).max() < 1e-8


def test_a_ratio_that_reaches_zero_is_refused(tmp_path):
    with pytest.raises(BgError) as caught:
        compiled(tmp_path, ROD.replace("RATIO", "(1 + play*cos(angle))"))
    assert [d.code for d in caught.value.diagnostics] == ["BG502"]


@pytest.mark.parametrize(
    ("ratio", "value"),
    [
        ("(2 + log1p(angle^2))", lambda x: 2 + np.log1p(x**2)),
        ("(3 + asin(0.5*sin(angle)))", lambda x: 3 + np.arcsin(np.sin(x) / 2)),
        ("(1 + expm1(angle^2))", lambda x: np.exp(x**2)),
        ("(4 - acos(tanh(angle)))", lambda x: 4 - np.arccos(np.tanh(x))),
        ("(2.5 - erfc(angle))", lambda x: 2.5 - np.array([math.erfc(y) for y in x])),
        ("(1 + acosh(1 + angle^2))", lambda x: 1 + np.arccosh(1 + x**2)),
        ("(3 + atanh(0.5*tanh(angle)))", lambda x: 3 + np.arctanh(np.tanh(x) / 2)),
        ("(1 + (angle^2)^0.3)", lambda x: 1 + (x**2) ** 0.3),
        ("(cos(0.5*sin(angle)) + fmod(angle^2, 1e3))", lambda x: np.cos(np.sin(x) / 2) + x**2),
    ],
)
def test_moduli_of_all_functions_that_keep_from_zero(tmp_path, ratio, value):
    result = compiled(tmp_path, ROD.replace("RATIO", ratio)).simulate(rtol=1e-10)
    assert np.allclose(result["crank.f"], 1 / value(result["angle"]), rtol=1e-9)


@pytest.mark.parametrize("ratio", ["sqrt(x^2)", "abs(x)", "(0.01*x^2)^0.5", "abs(x)^1.5"])
def test_a_run_ends_where_a_ratio_reaches_zero(tmp_path, ratio):
    """A size is no proof: as a proof it let the run go through the pole."""
    text = POLE.replace("RATIO", ratio)
    assert codes_of(compiled(tmp_path, text).simulate) == ["BG725"]
