"""Inputs of models as inputs of linear models, against closed forms."""

import numpy as np
import pytest
from model_files import model_file

import bgc

FILE = model_file("input_variation")


def transfer(linear, s):
    size = len(linear.A)
    return linear.C @ np.linalg.solve(s * np.eye(size) - linear.A, linear.B) + linear.D


def test_a_driven_input_is_varied():
    linear = bgc.compile(FILE, "s").linearise(["ref", "pair[2]"])
    assert linear.inputs == ("ref", "pair[2]")
    s = 0.7j
    wanted = 1 / (2 * s**2 + 4 * s + 8)
    np.testing.assert_allclose(transfer(linear, s)[0], [8 * wanted, wanted], rtol=1e-12)


def test_an_input_of_a_part_and_one_that_an_argument_gives():
    model = bgc.compile(FILE, "two")
    linear = model.linearise(["both", "one.ref", "two.ref"])
    assert linear.units["both"] == "rad"
    s = 0.3j
    wanted = 8 / (2 * s**2 + 4 * s + 8)
    expected = [[3 * wanted, wanted, 0], [0, 0, wanted]]
    np.testing.assert_allclose(transfer(linear, s), expected, rtol=1e-12, atol=1e-15)


def test_a_whole_input_means_its_components():
    assert bgc.compile(FILE, "s").linearise(["pair"]).inputs == ("pair[1]", "pair[2]")


def test_an_input_that_is_not_chosen_adds_nothing():
    assert "ref" not in bgc.compile(FILE, "s", whole=True).parameters
    linear = bgc.compile(FILE, "s").linearise(["k"])
    assert linear.inputs == ("k",)
    with pytest.raises(bgc.BgError, match="BG080"):
        bgc.compile(FILE, "s").linearise(["reff"])
