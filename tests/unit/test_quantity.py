import math

import pytest
from refusals import refusals

from bgc.runtime.running.quantity import read_quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("7", "kg", 7.0),
        (" -2.5e3 ", "", -2500.0),
        (".5", "m", 0.5),
        ("7 t", "kg", 7000.0),
        ("10 ms", "s", 0.01),
        ("3 kN*m", "N*m", 3000.0),
        ("45 deg", "", math.pi / 4),
        ("45 deg", "rad", math.pi / 4),
    ],
)
def test_numbers_with_and_without_units(text, unit, value):
    assert read_quantity(text, "x", unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["", "t", "7t", "1 2", "nan", "inf", "1e999", "7 blargs", "1+1"])
def test_what_is_no_value(text):
    assert refusals(read_quantity, text, "x", "kg")[0].code == "BG062"


@pytest.mark.parametrize(("text", "unit"), [("7 m", "kg"), ("7 m", ""), ("1 s", "N*m")])
def test_units_of_another_kind(text, unit):
    assert refusals(read_quantity, text, "x", unit)[0].code == "BG063"
