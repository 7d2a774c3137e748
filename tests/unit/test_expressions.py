"""Expressions: values, shapes and units, and that whatever is written has an answer."""

from __future__ import annotations

import math
import re
from fractions import Fraction

import numpy as np
import pytest
from fake_scope import METRE, World, expression, unit
from hypothesis import given, settings
from hypothesis import strategies as st

from bgc.algebra.dag import Kind, Level, Symbol
from bgc.diagnostics.diagnostic import BgError
from bgc.values.expressions import (
    evaluate_condition,
    evaluate_whole,
)
from bgc.values.units import DIMENSIONLESS
from bgc.values.value import Value

# --- numbers, paths, components ---------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2*3 - 4/8", [6.5]),
        ("-2^2", [-4]),
        ("[1, transpose([2, 3])*[1, 1], zeros(1)]", [1, 5, 0]),
        ("[[7], zeros(1)][1, 1]", [7]),
        ("2^-2", [0.25]),
        ("2^3^2", [512]),
        ("8 t", [8000]),
        ("2 kN*m", [2000]),
        ("180 deg", [math.pi]),
        ("pi", [math.pi]),
        ("x", [2]),
        ("time", [7]),
        ("coil.p", [2]),
        ("crane.boom.mass", [5]),
        ("crane.boom.r.z", [4]),
        ("crane.boom.r[2]", [3]),
        ("mass[3].p", [2]),
        ("mass[1 + 1].p", [2]),
        ("v.x", [2]),
        ("v[2..3]", [3, 4]),
        ("v[2..2]", [3]),
        ("K[1, 2]", [5]),
        ("[[1, 2, 3], [4, 5, 6]][2, 2..3]", [5, 6]),
        ("[[1, 2, 3], [4, 5, 6]][1..2, 3]", [3, 6]),
        ("[[1, 2, 3], [4, 5, 6]][1..2, 1..2]", [1, 2, 4, 5]),
        ("[1, x, 3]", [1, 2, 3]),
        ("not (x < 1)", [1]),
        ("x < 3 and x >= 2 or 0", [1]),
        ("x == 2", [1]),
        ("x != 2", [0]),
        ("if x > 1 then [1, 2] else [3, 4]", [1, 2]),
        ("if 1 > 2 then 1/0 else 3", [3]),
        ("if sqrt(2) > 1 then 4 else v[9]", [4]),
    ],
)
def test_values(text: str, expected: list[float]) -> None:
    assert World().numbers(text) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("3", ()),
        ("[1, 2, 3]", (3,)),
        ("[[1, 2], [3, 4], [5, 6]]", (3, 2)),
        ("v[2..2]", (1,)),
        ("K[1..2, 3]", (2,)),
        ("K[1..1, 2..3]", (1, 2)),
        ("K*v", (2,)),
        ("transpose(K)", (3, 2)),
        ("K*transpose(K)", (2, 2)),
        ("transpose(v)", (1, 3)),
        ("transpose(v)*v", (1,)),
        ("2*K", (2, 3)),
        ("v/2", (3,)),
        ("zeros(4)", (4,)),
        ("ones(2, 3)", (2, 3)),
        ("eye(3)", (3, 3)),
        ("diag(v)", (3, 3)),
        ("diag(eye(3))", (3,)),
        ("stack(1, v, [2, 3])", (6,)),
        ("stack(K, K)", (4, 3)),
        ("block([[eye(3), 0], [0, K]])", (5, 6)),
        ("block([[eye(3), v], [transpose(v), 0]])", (4, 4)),
        ("outer(v, [1, 2])", (3, 2)),
        ("skew(v)", (3, 3)),
    ],
)
def test_shapes(text: str, shape: tuple[int, ...]) -> None:
    assert World().evaluate(text).shape == shape


def test_a_single_component_goes_for_a_scalar() -> None:
    world = World()
    assert world.numbers("1 + (transpose(v)*eye(3)*v)/2 + [3]") == [18.5]
    assert world.numbers("[2]*[3]") == [6]
    assert world.numbers("[2]*K[1, 1..3]") == [10, 10, 10]
    assert world.numbers("if [1] > 0 then [2]^2 else 0") == [4]


def test_literals_are_exact() -> None:
    world = World()
    third = world.evaluate("0.1 + 0.2")
    assert world.dag.value(third.node) == Fraction(3, 10)
    assert world.dag.value(world.evaluate("10^9*(1 mm)").node) == 10**6
    assert world.dag.value(world.evaluate("10^20").node) == 10**20


# --- functions --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    "sin cos tan asin acos atan sinh cosh tanh asinh exp expm1".split(),
)
@given(x=st.floats(-1, 1))
def test_functions_of_one_number(name: str, x: float) -> None:
    world = World()
    (found,) = world.numbers(f"{name}({Fraction(x).limit_denominator(10**6)})")
    exact = float(Fraction(x).limit_denominator(10**6))
    assert found == pytest.approx(getattr(math, name)(exact), rel=1e-14, abs=1e-300)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("acosh(2)", [math.acosh(2)]),
        ("atanh(0.5)", [math.atanh(0.5)]),
        ("log(x) + log10(x) + log1p(x)", [math.log(2) + math.log10(2) + math.log1p(2)]),
        ("cbrt(27)", [3]),
        ("erf(x)", [math.erf(2)]),
        ("floor(2.7) + ceil(2.1) + abs(-1) + sign(-4)", [5]),
        ("fmod(7.5, 2)", [1.5]),
        ("hypot(3, 4) + atan2(0, 1)", [5]),
        ("min(3, x, 8) + max(v)", [6]),
        ("max([1, 5], [2, 3])", [2, 5]),
        ("sin([0, 1])", [0, math.sin(1)]),
        ("dot(v, [1, 10, 100])", [432]),
        ("cross([1, 0, 0], v)", [0, -4, 3]),
        ("skew([1, 0, 0])*v", [0, -4, 3]),
        ("norm([3, 4])", [5]),
        ("sum(K) + length(v)", [33]),
        ("inv([[2, 1], [1, 2]])*[3, 3]", [1, 1]),
        ("inv(4)", [0.25]),
        ("inv([[k, 1], [1, k]])*[6, 6]", [1, 1]),
    ],
)
def test_functions(text: str, expected: list[float]) -> None:
    assert World().numbers(text) == pytest.approx(expected, rel=1e-14)


def test_block_places_its_parts() -> None:
    found = np.array(World().numbers("block([[1, [[2, 3]]], [[4, 5], eye(2)]])"))
    np.testing.assert_array_equal(found.reshape(3, 3), [[1, 2, 3], [4, 1, 0], [5, 0, 1]])


def test_user_functions_see_their_arguments_only() -> None:
    world = World("function twice(a) = 2*a; function quad(a, x) = twice(twice(a)) + x;")
    assert world.numbers("quad(v, ones(3))") == [9, 13, 17]
    hidden = World("function f(a) = a + x;")
    assert hidden.diagnostic("f(1)").code == "BG211"


def test_user_function_wins_over_a_built_in_one() -> None:
    world = World("function skew(v) = 2*v;")
    assert world.numbers("skew(x)") == [4]


def test_functions_of_functions_cost_what_they_make() -> None:
    chain = "".join(f"function f{k}(a) = f{k - 1}(a) + f{k - 1}(a);" for k in range(1, 60))
    world = World("function f0(a) = a;" + chain)
    assert world.numbers("f59(x)") == [2.0**60]


def test_rates_stand_in_equations_only() -> None:
    world = World()
    assert world.diagnostic("der(x)").code == "BG345"
    world.scope.allows_rates = True
    value = world.evaluate("2*der(v)")
    assert value.unit is None
    rate = world.evaluate("der(v)")
    assert rate.unit == unit("m/s")
    assert [world.dag.symbol_of(n) for n in rate.nodes] == [Symbol(Kind.RATE, k) for k in range(3)]
    assert world.diagnostic("der(2*x)").code == "BG346"


# --- units ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("3 m + 2", "m"),
        ("2 + 3 m", "m"),
        ("3 m * 2 N", "J"),
        ("3 m / (2 s)", "m/s"),
        ("(2 m)^3", "m^3"),
        ("(4 m^2)^0.5", "m"),
        ("sqrt(4 m^2)", "m"),
        ("cbrt(8 m^3)", "m"),
        ("norm(v)", "m"),
        ("dot(v, v)", "m^2"),
        ("cross(v, [1 N, 2 N, 3 N])", "J"),
        ("inv([[2 N, 0 N], [0 N, 1 N]])", "N^-1"),
        ("atan2(1 m, 2 m)", "rad"),
        ("hypot(3 m, 4 m)", "m"),
        ("min(3 m, 2)", "m"),
        ("sin(30 deg)", "rad"),
        ("if x > 0 then 3 m else 0", "m"),
        ("sign(-3 m)", "rad"),
        ("twist[4..6]", "m"),
        ("sum(diag([1 m, 2 m])*[1 s, 2 s])", "m*s"),
    ],
)
def test_units(text: str, expected: str) -> None:
    assert World().evaluate(text).unit == unit(expected)


@pytest.mark.parametrize(
    "text", ["2", "2*(3 m)", "x", "x*(3 m)", "time", "eye(3)", "stack(1 m, 1 s)"]
)
def test_unknown_and_mixed_units_are_none(text: str) -> None:
    assert World().evaluate(text).unit is None


def test_components_keep_their_own_units() -> None:
    value = World().evaluate("stack([1 m, 2 m], 3 s) + [1, 2 m, 3]")
    assert value.units == (METRE, METRE, unit("s"))


def test_time_fits_any_unit() -> None:
    world = World()
    assert world.evaluate("sin(time)").unit == DIMENSIONLESS
    assert world.evaluate("3 m + time").unit == METRE


def test_angles_are_plain_numbers() -> None:
    assert World().evaluate("30 deg + 1").unit == DIMENSIONLESS


# --- compile time -----------------------------------------------------------------------


def test_whole_numbers() -> None:
    world = World()
    for text, expected in (("2^10", 1024), ("floor(sqrt(17))", 4), ("length(v) - 5", -2)):
        assert evaluate_whole(expression(text), world.scope, world.dag, "n", -9, 9999) == expected
    for text, code in (("1/2", "BG331"), ("k", "BG330"), ("10", "BG331"), ("2 m", "BG304")):
        with pytest.raises(BgError) as caught:
            evaluate_whole(expression(text), world.scope, world.dag, "a width", 1, 9)
        assert caught.value.diagnostics[0].code == code
        assert caught.value.diagnostics[0].message.startswith("a width must be")


def test_conditions() -> None:
    world = World()
    what = "the condition of `if`"
    assert evaluate_condition(expression("2 > 1"), world.scope, world.dag, what)
    assert not evaluate_condition(expression("log(2) > 1"), world.scope, world.dag, what)
    with pytest.raises(BgError) as caught:
        evaluate_condition(expression("k > 1"), world.scope, world.dag, what)
    assert caught.value.diagnostics[0].code == "BG330"


def test_levels_follow_what_is_used() -> None:
    world = World()
    levels = {"2*pi": Level.CONST, "2*k": Level.PARAM, "k*time": Level.TIME, "k*x": Level.STATE}
    for text, level in levels.items():
        assert world.dag.level[world.evaluate(text).node] == level


# --- whatever is written ----------------------------------------------------------------

_LEAVES = "0 1 2 0.5 1e300 x k v K time pi coil 3*m 2*s v.x K[1,2] twist [1,2,3] eye(3)".split()
_WRAPPERS = (
    "({})", "-({})", "not ({})", "sin({})", "sqrt({})", "inv({})", "norm({})", "transpose({})",
    "skew({})", "diag({})", "sum({})", "zeros({})", "length({})", "v[{}]", "({})[1]", "({}).y",
    "[{0}, {0}]", "abs({})", "min({})", "log({})", "coil.p*({})", "1/({})",
)  # fmt: skip
_JOINERS = (
    "({})+({})", "({})-({})", "({})*({})", "({})/({})", "({})^({})", "({})<({})", "({})==({})",
    "({}) and ({})", "if {} then {} else 1", "stack({}, {})", "block([[{}, {}]])", "dot({}, {})",
    "cross({}, {})", "outer({}, {})", "max({}, {})", "atan2({}, {})", "zeros({}, {})",
    "v[{}..{}]",
)  # fmt: skip

texts = st.recursive(
    st.sampled_from(_LEAVES),
    lambda inner: st.one_of(
        st.builds(str.format, st.sampled_from(_WRAPPERS), inner),
        st.builds(str.format, st.sampled_from(_JOINERS), inner, inner),
    ),
    max_leaves=12,
)


@given(texts)
@settings(max_examples=300, deadline=None)
def test_any_expression_has_a_value_or_one_diagnostic(text: str) -> None:
    world = World()
    world.scope.values |= {
        "m": Value.scalar(world.dag.one, METRE),
        "s": Value.scalar(world.dag.one, unit("s")),
    }
    try:
        value = world.evaluate(text)
    except BgError as err:
        (diagnostic,) = err.diagnostics
        assert re.fullmatch("BG3..|BG211", diagnostic.code) and diagnostic.span and diagnostic.help
    else:
        assert len(value.nodes) == math.prod(value.shape)
