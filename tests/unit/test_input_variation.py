"""Inputs of models as inputs of linear models, against closed forms."""

import numpy as np
import pytest

import bgc

TEXT = """
model Servo {
  input ref : rad = 0;
  input pair[2] = [0, 3];
  input ratio = 1;
  param k : N*m = 8 N*m;
  disc : I(2 kg*m^2);
  drag : R(4);
  hub  : J1;
  state angle : rad;
  der(angle) = hub.f;
  motor : Se(k*(ref - angle)/1 rad + pair[2]*1 N*m);
  motor -> hub -> disc, drag;
}
model Pair { input both : rad = 0; one : Servo(ref = 3*both); two : Servo; hold : R(1); s : Se(0);
  s -> hold; }
scene s of Servo { drive ref = 0.1 rad; observe angle; run 1 s; }
scene two of Pair { observe one.angle as first, two.angle as second; run 1 s; }
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    found = tmp_path_factory.mktemp("inputs") / "a.bg"
    found.write_text(TEXT)
    return found


def transfer(linear, s):
    size = len(linear.A)
    return linear.C @ np.linalg.solve(s * np.eye(size) - linear.A, linear.B) + linear.D


def test_a_driven_input_is_varied(path):
    linear = bgc.compile(path, "s").linearise(["ref", "pair[2]"])
    assert linear.inputs == ("ref", "pair[2]")
    s = 0.7j
    wanted = 1 / (2 * s**2 + 4 * s + 8)
    np.testing.assert_allclose(transfer(linear, s)[0], [8 * wanted, wanted], rtol=1e-12)


def test_an_input_of_a_part_and_one_that_an_argument_gives(path):
    model = bgc.compile(path, "two")
    linear = model.linearise(["both", "one.ref", "two.ref"])
    assert linear.units["both"] == "rad"
    s = 0.3j
    wanted = 8 / (2 * s**2 + 4 * s + 8)
    expected = [[3 * wanted, wanted, 0], [0, 0, wanted]]
    np.testing.assert_allclose(transfer(linear, s), expected, rtol=1e-12, atol=1e-15)


def test_a_whole_input_means_its_components(path):
    assert bgc.compile(path, "s").linearise(["pair"]).inputs == ("pair[1]", "pair[2]")


def test_an_input_that_is_not_chosen_adds_nothing(path):
    assert "ref" not in bgc.compile(path, "s", whole=True).parameters
    linear = bgc.compile(path, "s").linearise(["k"])
    assert linear.inputs == ("k",)
    with pytest.raises(bgc.BgError, match="BG080"):
        bgc.compile(path, "s").linearise(["reff"])
