"""Expressions: the diagnostic of each thing that is wrong, its place and its words."""

from __future__ import annotations

import pytest
from fake_scope import World

WRONG = [
    ("1 + 5 Nm", "BG301", "5 Nm"),
    ("3 m + 2 kg", "BG303", "2 kg"),
    ("2 kg - v.x", "BG303", "v.x"),
    ("3 m < 2 s", "BG303", "2 s"),
    ("[1 m, 2 m] + [1 m, 2 s]", "BG303", "[1 m, 2 s]"),
    ("dot(v, [1 m, 2 s, 3 m])", "BG307", "dot(v, [1 m, 2 s, 3 m])"),
    ("norm([1 m, 2 s])", "BG307", "norm([1 m, 2 s])"),
    ("[[1 m, 1 s]]*v[1..2]", "BG307", "[[1 m, 1 s]]*v[1..2]"),
    ("if x > 0 then 1 m else 1 s", "BG303", "1 s"),
    ("max(1 m, 1 s)", "BG303", "1 s"),
    ("sin(3 m)", "BG304", "3 m"),
    ("2^(3 m)", "BG304", "3 m"),
    ("floor(3.5 m)", "BG304", "3.5 m"),
    ("if 3 m then 1 else 2", "BG304", "3 m"),
    ("(3 m)^k", "BG305", "k"),
    ("(3 m)^1000", "BG305", "1000"),
    ("v + [1, 2]", "BG310", "[1, 2]"),
    ("v + 1", "BG310", "1"),
    ("dot(v, [1, 2])", "BG310", "[1, 2]"),
    ("stack(K, [1, 2])", "BG310", "[1, 2]"),
    ("v*v", "BG311", "v"),
    ("v*K", "BG311", "K"),
    ("K*[1, 2]", "BG311", "[1, 2]"),
    ("1/v", "BG312", "v"),
    ("v^2", "BG312", "v"),
    ("2^v", "BG312", "v"),
    ("v < 1", "BG312", "v"),
    ("not v", "BG312", "v"),
    ("atan2(v, 1)", "BG312", "v"),
    ("cross([1, 2], v)", "BG313", "[1, 2]"),
    ("sin(K)", "BG313", "K"),
    ("norm(K)", "BG313", "K"),
    ("inv(K)", "BG313", "K"),
    ("diag(K)", "BG313", "K"),
    ("[[1, 2], [3]]", "BG314", "[3]"),
    ("[1, v]", "BG314", "v"),
    ("[K, K]", "BG314", "K"),
    ("block([[eye(3), zeros(2, 3)]])", "BG316", "zeros(2, 3)"),
    ("block([[eye(3)], [eye(2)]])", "BG316", "eye(2)"),
    ("block([[1, 2], [3]])", "BG316", "3"),
    ("block(v)", "BG316", "v"),
    ("block([v])", "BG316", "v"),
    ("zeros(1000000)", "BG317", "zeros(1000000)"),
    ("zeros(100000, 100000)", "BG317", "zeros(100000, 100000)"),
    ("outer(zeros(1000), zeros(1000))", "BG317", "outer(zeros(1000), zeros(1000))"),
    ("ones(300, 300)*ones(300, 300)", "BG317", "ones(300, 300)*ones(300, 300)"),
    ("v[0]", "BG320", "0"),
    ("v[2..4]", "BG320", "2..4"),
    ("K[3, 1]", "BG320", "3"),
    ("K[1]", "BG321", "K[1]"),
    ("x[1]", "BG321", "x[1]"),
    ("v[3..1]", "BG322", "3..1"),
    ("v.w", "BG323", "w"),
    ("x.x", "BG323", "x"),
    ("mass[1..2].p", "BG324", "1..2"),
    ("v[k]", "BG330", "k"),
    ("zeros(k)", "BG330", "k"),
    ("v[1.5]", "BG331", "1.5"),
    ("eye(0)", "BG331", "0"),
    ("1e300 GPa", "BG333", "1e300 GPa"),
    ("1/0", "BG334", "0"),
    ("x/(2 - 2)", "BG334", "2 - 2"),
    ("x/(sin(0)*k)", "BG334", "sin(0)*k"),
    ("0^-1", "BG334", "0^-1"),
    ("1/(sqrt(2) - 1.4142135623730951)", "BG333", "1/(sqrt(2) - 1.4142135623730951)"),
    ("log(0)", "BG333", "log(0)"),
    ("log(-1)", "BG335", "log(-1)"),
    ("sqrt(-1)", "BG335", "sqrt(-1)"),
    ("(-8)^(1/3)", "BG335", "(-8)^(1/3)"),
    ("9^9^9^9", "BG333", "9^9^9"),
    ("1e300*1e300", "BG333", "1e300*1e300"),
    ("exp(1000)", "BG333", "exp(1000)"),
    ("masse", "BG211", "masse"),
    ("coil", "BG340", "coil"),
    ("2*crane.boom", "BG340", "crane.boom"),
    ("coil + 1", "BG340", "coil"),
    ("arcsin(1)", "BG341", "arcsin(1)"),
    ("x(3)", "BG342", "x(3)"),
    ("atan2(1)", "BG343", "atan2(1)"),
    ("sin(1, 2)", "BG343", "sin(1, 2)"),
    ("min()", "BG343", "min()"),
    ("inv([[1, 2], [2, 4]])", "BG350", "[[1, 2], [2, 4]]"),
    ("inv([[k, k], [k, k]])", "BG350", "[[k, k], [k, k]]"),
    ("inv([[x, 0], [0, 1]])", "BG351", "[[x, 0], [0, 1]]"),
]


@pytest.mark.parametrize(("text", "code", "place"), WRONG)
def test_wrong_expressions(text: str, code: str, place: str) -> None:
    diagnostic = World().diagnostic(text)
    assert diagnostic.span is not None
    assert (diagnostic.code, diagnostic.span.text) == (code, place), diagnostic.message
    assert diagnostic.help


@pytest.mark.parametrize(
    ("functions", "text", "code"),
    [
        ("function f(a) = f(a - 1);", "f(3)", "BG344"),
        ("function f(a) = g(a); function g(a) = f(a);", "f(3)", "BG344"),
        ("function f(a, b) = a + b;", "f(3)", "BG343"),
        ("function f(a) = a + 1 m;", "f(3 s)", "BG303"),
    ],
)
def test_wrong_uses_of_functions(functions: str, text: str, code: str) -> None:
    assert World(functions).diagnostic(text).code == code


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
