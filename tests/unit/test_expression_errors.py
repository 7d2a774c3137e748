"""Expressions: nesting, and the words of messages."""

from __future__ import annotations

import pytest
from fake_scope import World


def test_endless_nesting_is_reported() -> None:
    chain = "".join(f"function f{k}(a) = f{k - 1}(a);" for k in range(1, 100))
    assert World("function f0(a) = a;" + chain).diagnostic("f99(x)").code == "BG318"


def test_long_sums_are_no_nesting() -> None:
    world = World()
    assert world.numbers("+".join(["x"] * 150)) == [300]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("2 kg + 3 m", "cannot add a length (m) to a mass (kg)"),
        ("2 kg - 3 m", "cannot subtract a length (m) from a mass (kg)"),
        ("2 kg == 3 m", "cannot compare a mass (kg) with a length (m)"),
        ("v + [1, 2]", "a vector of 3 and a vector of 2 have different shapes in a sum"),
        (
            "[1 m, 2 m] - [1 m, 2 s]",
            "cannot subtract a time (s) from a length (m), in component [2]",
        ),
        ("atan2(1)", "`atan2` takes 2 arguments, not 1"),
        ("zeros(1, 2, 3)", "`zeros` takes 1 or 2 arguments, not 3"),
        ("eye(0.5)", "an argument of `eye` must be a whole number from 1 to 1000000000, not 0.5"),
        ("K[1]", "a 2 x 3 matrix takes two indices, not 1"),
    ],
)
def test_messages_are_in_words(text: str, message: str) -> None:
    assert World().diagnostic(text).message == message
