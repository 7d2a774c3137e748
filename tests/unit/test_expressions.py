"""Expressions: values, shapes and units, and the diagnostic of each thing that is wrong."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bgc.algebra.dag import Dag, Kind, Level, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.grammar import syntax
from bgc.grammar.catalogue.names import unknown_name
from bgc.grammar.catalogue.shapes import index_out_of_range
from bgc.grammar.diagnostics import BgError, Diagnostic
from bgc.grammar.parse import parse
from bgc.grammar.source import Source, Span
from bgc.values.expressions import (
    FunctionUse,
    Namespace,
    evaluate,
    evaluate_condition,
    evaluate_whole,
)
from bgc.values.units import DIMENSIONLESS, Dimension, parse_unit
from bgc.values.value import Value

METRE: Dimension = (0, 1, 0, 0, 0, 0, 0)


@dataclass
class Part:
    """A namespace with members and, as an array, elements."""

    members: dict[str, Value | Namespace] = field(default_factory=dict)
    elements: tuple[Namespace, ...] = ()

    @property
    def description(self) -> str:
        return "a part"

    def member(self, name: str, span: Span) -> Value | Namespace:
        if name not in self.members:
            raise BgError([unknown_name(span, name, self.members)])
        return self.members[name]

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        if not 1 <= indices[0] <= len(self.elements):
            raise BgError([index_out_of_range(span, indices[0], len(self.elements), "a part")])
        return self.elements[indices[0] - 1]


@dataclass
class FakeScope:
    values: dict[str, Value | Namespace]
    functions: dict[str, syntax.Function]
    allows_rates: bool = False

    def lookup(self, name: str, span: Span) -> Value | Namespace | None:
        return self.values.get(name)

    def names(self) -> Collection[str]:
        return self.values

    def is_value(self, name: str) -> bool:
        return isinstance(self.values.get(name), Value)

    def function(self, name: str) -> FunctionUse | None:
        found = self.functions.get(name)
        return FunctionUse(found, FakeScope({}, self.functions)) if found else None

    def function_names(self) -> Collection[str]:
        return self.functions


class World:
    """A DAG, some names, and texts evaluated among them."""

    def __init__(self, functions: str = "") -> None:
        self.dag = dag = Dag()
        x = [dag.symbol(Kind.STATE, k) for k in range(3)]
        k = dag.symbol(Kind.PARAM)
        coil = Part({"p": Value.scalar(x[0])})
        twist = Value((6,), tuple(x + x), (None, None, None, METRE, METRE, METRE))
        self.scope = FakeScope(
            {
                "x": Value.scalar(x[0]),
                "states": Value.vector(x),
                "v": Value.vector(x, METRE),
                "k": Value.scalar(k),
                "K": Value.uniform((2, 3), [k] * 6),
                "twist": twist,
                "coil": coil,
                "crane": Part({"boom": Part({"mass": Value.scalar(k), "r": Value.vector(x)})}),
                "mass": Part(elements=(coil, coil, coil)),
            },
            {f.name: f for f in _declarations(functions) if isinstance(f, syntax.Function)},
        )

    def evaluate(self, text: str) -> Value:
        return evaluate(expression(text), self.scope, self.dag)

    def numbers(self, text: str) -> list[float]:
        symbols = {Symbol(Kind.STATE, k): k + 2.0 for k in range(3)}
        values = {**symbols, Symbol(Kind.PARAM, 0): 5.0, Symbol(Kind.TIME, 0): 7.0}
        return evaluate_nodes(self.dag, self.evaluate(text).nodes, values)

    def diagnostic(self, text: str) -> Diagnostic:
        with pytest.raises(BgError) as caught:
            self.evaluate(text)
        (diagnostic,) = caught.value.diagnostics
        return diagnostic


def _declarations(text: str) -> tuple[syntax.Declaration, ...]:
    file, diagnostics = parse(Source("test.bg", text))
    assert not diagnostics, diagnostics
    return file.declarations


def expression(text: str) -> syntax.Expr:
    (declaration,) = _declarations(f"const result = {text};")
    assert isinstance(declaration, syntax.Value) and declaration.value is not None
    return declaration.value


def unit(text: str) -> Dimension:
    found = parse_unit(text)
    assert found is not None
    return found.dimension


# --- numbers, paths, components ---------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2*3 - 4/8", [6.5]),
        ("-2^2", [-4]),
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


# --- what is wrong ----------------------------------------------------------------------

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


def test_a_unit_that_is_also_a_name() -> None:
    world = World()
    world.scope.values["m"] = world.scope.values["x"]
    diagnostic = world.diagnostic("3 kg*m")
    assert diagnostic.code == "BG302"
    assert "`m`" in diagnostic.message


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
        ("v + [1, 2]", "a vector of 3 and a vector of 2 do not go together in a sum"),
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
