"""Every row of the table of operations, checked against independent answers.

No test names the functions it tries, so a new row is checked as soon as it stands there. Only
`SYMPY` has to know the functions that SymPy calls differently.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from fractions import Fraction

import numpy as np
import pytest
import sympy
from programs import CompiledModel, at, make_program, states

import bgc
from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.derivatives import CHOICES, directional_derivative, gradient
from bgc.algebra.evaluate import apply, evaluate_nodes, to_double
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.infix import infix_lines
from bgc.algebra.operation import Conic, Lanes, Parity
from bgc.emission.emit import emit_model
from bgc.emission.simplification import optimise
from bgc.values.functions import BUILTINS

OPERATIONS = [op for op in Op if op.row.arity and op.row.smooth]
NAMED = [op for op in OPERATIONS if op.row.name]
BINARY = [op for op in OPERATIONS if op.row.arity == 2]
UNARY = [op for op in OPERATIONS if op.row.arity == 1]
POOL = (-7.31, -1.42, -0.63, -0.27, 0.23, 0.44, 0.89, 1.37, 2.61)  # no whole numbers or ratios
EDGES = (math.nan, -math.inf, -1.0, -0.0, 0.0, 0.5, 1.0, 2.0, 800.0, math.inf)
STEP = 1e-5


def names(ops: list[Op]) -> list[str]:
    return [op.name for op in ops]


def points(op: Op, pool: tuple[float, ...] = POOL) -> list[tuple[float, ...]]:
    """Operands at which an operation is finite, away from the ends of its domain and from jumps."""
    found = [
        x
        for x in itertools.permutations(pool, op.row.arity)
        if all(math.isfinite(apply(op, *(v * s for v in x))) for s in (1, 1 - 1e-3, 1 + 1e-3))
    ]
    assert len(found) >= 2, f"{op.name} is finite at too few points"
    return found


def equal(found: float, expected: float, rel: float = 1e-14) -> bool:
    """Equality up to rounding; NaN equals NaN, an infinity only itself."""
    if math.isnan(expected) or math.isnan(found):
        return math.isnan(expected) and math.isnan(found)
    return found == expected or abs(found - expected) <= rel * abs(expected)


# --- derivatives ------------------------------------------------------------------------------

x_, y_, z_ = sympy.symbols("x y z", real=True)
SYMPY: dict[Op, Callable[..., sympy.Expr]] = {
    Op.ADD: lambda a, b: a + b,
    Op.SUB: lambda a, b: a - b,
    Op.MUL: lambda a, b: a * b,
    Op.DIV: lambda a, b: a / b,
    Op.NEG: lambda a: -a,
    Op.POW: lambda a, b: a**b,
    Op.SELECT: lambda c, a, b: sympy.Piecewise((a, sympy.Ne(c, 0)), (b, True)),
    Op.MAX: lambda a, b: sympy.Piecewise((a, a >= b), (b, True)),
    Op.MIN: lambda a, b: sympy.Piecewise((a, a <= b), (b, True)),
    Op.SIGN: lambda a: sympy.Piecewise((1, a > 0), (-1, a < 0), (0, True)),
    Op.LT: lambda a, b: sympy.Piecewise((1, a < b), (0, True)),
    Op.LE: lambda a, b: sympy.Piecewise((1, a <= b), (0, True)),
    Op.EQ: lambda a, b: sympy.Piecewise((1, sympy.Eq(a, b)), (0, True)),
    Op.AND: lambda a, b: sympy.Piecewise((1, sympy.Ne(a * b, 0)), (0, True)),
    Op.OR: lambda a, b: sympy.Piecewise((0, sympy.Eq(a**2 + b**2, 0)), (1, True)),
    Op.NOT: lambda a: sympy.Piecewise((1, sympy.Eq(a, 0)), (0, True)),
    Op.EXPM1: lambda a: sympy.exp(a) - 1,
    Op.LOG10: lambda a: sympy.log(a, 10),
    Op.LOG1P: lambda a: sympy.log(1 + a),
    Op.CBRT: lambda a: sympy.Piecewise((sympy.cbrt(a), a >= 0), (-sympy.cbrt(-a), True)),
    Op.HYPOT: lambda a, b: sympy.sqrt(a**2 + b**2),
    Op.ABS: lambda a: sympy.Piecewise((a, a >= 0), (-a, True)),
    Op.CEIL: sympy.ceiling,
    Op.FMOD: lambda a, b: a - b * sympy.sign(a / b) * sympy.floor(abs(a / b)),
}


def in_sympy(op: Op) -> tuple[sympy.Expr, list[sympy.Symbol]]:
    """An operation of symbols; SymPy's function of the same name unless `SYMPY` has another."""
    symbols = [x_, y_, z_][: op.row.arity]
    function = SYMPY.get(op) or getattr(sympy, op.row.name)
    return function(*symbols), symbols


def number(expression: sympy.Expr, symbols: list[sympy.Symbol], x: tuple[float, ...]) -> float:
    """An expression at a point, to 30 digits and then as a double."""
    exact = {s: sympy.Rational(*v.as_integer_ratio()) for s, v in zip(symbols, x, strict=True)}
    return float(expression.subs(exact).evalf(30))


def derivatives(op: Op, x: tuple[float, ...]) -> Iterator[tuple[float, float]]:
    """The derivatives by each operand in turn, in reverse and forward."""
    dag = Dag()
    symbols = states(dag, len(x))
    node = dag.apply(op, tuple(symbols))
    for symbol, back in zip(symbols, gradient(dag, node, symbols), strict=True):
        along = directional_derivative(dag, node, {symbol: dag.one})
        first, second = evaluate_nodes(dag, [back, along], at(x))
        yield first, second


@pytest.mark.parametrize("op", OPERATIONS, ids=names(OPERATIONS))
def test_values_and_derivatives_are_those_of_sympy(op: Op) -> None:
    expression, symbols = in_sympy(op)
    held = expression.replace(sympy.floor, lambda a: sympy.Symbol("held"))  # its slope is zero
    held = held.replace(sympy.ceiling, lambda a: sympy.Symbol("held"))
    slopes = [sympy.diff(held.replace(sympy.sign, lambda a: 1), s) for s in symbols]
    for x in points(op)[::7] if op.row.arity > 1 else points(op):
        assert equal(apply(op, *x), number(expression, symbols, x), 1e-13), x
        for slope, found in zip(slopes, derivatives(op, x), strict=True):
            if slope.has(sympy.Symbol("held")):
                continue  # of `fmod` by its divisor: against differences only
            expected = number(slope, symbols, x)
            assert found == (pytest.approx(expected, 1e-12), pytest.approx(expected, 1e-12)), x


@pytest.mark.parametrize("op", OPERATIONS, ids=names(OPERATIONS))
def test_derivatives_are_those_of_differences(op: Op) -> None:
    def central(x: tuple[float, ...], k: int, h: float) -> float:
        ahead, behind = ((*x[:k], x[k] + s, *x[k + 1 :]) for s in (h, -h))
        return (apply(op, *ahead) - apply(op, *behind)) / (2 * h)

    for x in points(op):
        for k, found in enumerate(derivatives(op, x)):
            difference = (4 * central(x, k, STEP) - central(x, k, 2 * STEP)) / 3
            expected = pytest.approx(difference, rel=1e-6, abs=1e-8)
            assert found == (expected, expected), x


ENDS = [
    (Op.SQRT, (0.0,)),
    (Op.CBRT, (0.0,)),
    (Op.POW, (0.0, 0.3)),
    (Op.ASIN, (1.0,)),
    (Op.ASIN, (-1.0,)),
    (Op.ACOS, (1.0,)),
    (Op.ACOS, (-1.0,)),
    (Op.ACOSH, (1.0,)),
    (Op.HYPOT, (0.0, 0.0)),
    (Op.ATAN2, (0.0, 0.0)),
]


@pytest.mark.parametrize(("op", "x"), ENDS, ids=[f"{op.name}{x}" for op, x in ENDS])
def test_an_infinite_slope_at_the_end_of_a_domain_counts_as_zero(
    op: Op, x: tuple[float, ...]
) -> None:
    """Times a rate of zero, as behind a clamp or at rest, it would be NaN."""
    assert list(derivatives(op, x)) == [(0.0, 0.0)] * len(x)


@pytest.mark.parametrize(("exponent", "slope"), [(0.3, 0.0), (1.0, 1.0), (1.5, 0.0), (2.0, 0.0)])
def test_the_slope_of_a_power_at_zero(exponent: float, slope: float) -> None:
    """Also where the exponent is a constant of the model, not a variable."""
    assert next(derivatives(Op.POW, (0.0, exponent))) == (slope, slope)
    dag = Dag()
    (x,) = states(dag, 1)
    power = dag.pow(x, dag.const(Fraction(exponent).limit_denominator(10)))
    (found,) = evaluate_nodes(dag, gradient(dag, power, [x]), at((0.0,)))
    assert found == slope


def test_choices_are_those_with_a_condition() -> None:
    assert {op for op in Op if op in CHOICES} == {Op.SELECT, Op.MIN, Op.MAX}
    for op in OPERATIONS:
        assert (op.row.partials is None) == (op.row.choice is not None), op.name


# --- exact values, symmetry, inverses ---------------------------------------------------------

RATIONALS = [Fraction(n, d) for n in range(-9, 10) for d in (1, 2, 4)]


@pytest.mark.parametrize("op", OPERATIONS, ids=names(OPERATIONS))
def test_exact_values_are_those_of_doubles(op: Op) -> None:
    dag = Dag()
    for x in itertools.product(RATIONALS, repeat=min(op.row.arity, 2)):
        operands = (*x, *[Fraction(3)] * (op.row.arity - len(x)))
        if op is Op.DIV and x[1] == 0:
            continue  # left as it is, for whoever builds it to report
        node = dag.apply(op, tuple(map(dag.const, operands)))
        exact = dag.value(node)
        expected = apply(op, *map(to_double, operands))
        if exact is not None:
            assert to_double(exact) == pytest.approx(expected, rel=1e-15, abs=0), operands
        (found,) = evaluate_nodes(dag, [node], {})
        assert equal(found, expected, 1e-13), operands


@pytest.mark.parametrize("op", UNARY, ids=names(UNARY))
def test_parity_is_what_the_function_has(op: Op) -> None:
    pairs = [(apply(op, x), apply(op, -x)) for x in (0.0, *POOL)]
    pairs = [pair for pair in pairs if all(map(math.isfinite, pair))]
    is_odd = len(pairs) > 1 and all(b == pytest.approx(-a, rel=1e-15) for a, b in pairs)
    is_even = len(pairs) > 1 and all(a == b for a, b in pairs)
    found = Parity.ODD if is_odd else Parity.EVEN if is_even else Parity.NONE
    assert op.row.parity is found


@pytest.mark.parametrize("op", UNARY, ids=names(UNARY))
def test_fingerprints_know_the_parity(op: Op) -> None:
    dag = Dag()
    prints = Fingerprints(dag)
    x = dag.symbol(Kind.STATE)
    there, back = dag.apply(op, (x,)), dag.apply(op, (dag.neg(x),))
    assert prints.equal(back, dag.neg(there)) == (op.row.parity is Parity.ODD)
    assert prints.equal(back, there) == (op.row.parity is Parity.EVEN)


@pytest.mark.parametrize("op", UNARY, ids=names(UNARY))
def test_fingerprints_know_the_value_at_zero(op: Op) -> None:
    """`sin^2 + cos^2 - 1` is zero for all values of x, but only fingerprints see it."""
    dag = Dag()
    x = dag.symbol(Kind.STATE)
    sine, cosine = dag.call(Op.SIN, x), dag.call(Op.COS, x)
    zero = dag.sub(dag.add(dag.mul(sine, sine), dag.mul(cosine, cosine)), dag.one)
    exact = dag.value(dag.apply(op, (dag.zero,)))
    if exact is not None:
        assert Fingerprints(dag).constant(dag.apply(op, (zero,))) == exact


@pytest.mark.parametrize("op", BINARY, ids=names(BINARY))
def test_symmetry_is_what_the_function_has(op: Op) -> None:
    is_symmetric = all(apply(op, a, b) == apply(op, b, a) for a, b in points(op))
    assert op.row.symmetric == is_symmetric


@pytest.mark.parametrize("op", OPERATIONS, ids=names(OPERATIONS))
def test_values_are_within_the_image_and_operands_within_the_domain(op: Op) -> None:
    pool = itertools.product((*POOL, *EDGES), repeat=op.row.arity)
    for x in pool:
        value = apply(op, *x)
        if not math.isnan(value):
            low, high = op.row.image
            assert low is None or low <= value, x
            assert high is None or value <= high, x
        if op.row.arity == 1 and not math.isnan(x[0]):
            low, high = op.row.domain
            inside = (low is None or low <= x[0]) and (high is None or x[0] <= high)
            assert inside or math.isnan(value), x


CURVES = [op for op in OPERATIONS if op.row.curve is not None]


@pytest.mark.parametrize("op", CURVES, ids=names(CURVES))
def test_curves_pass_through_the_function(op: Op) -> None:
    curve = op.row.curve
    assert curve is not None
    parameter = {Conic.CIRCLE: math.tan, Conic.HYPERBOLA: math.tanh}[curve.conic]
    for x in POOL:
        dividend, divisor = curve.point(parameter(x / 2))  # type: ignore[arg-type]
        assert dividend / divisor == pytest.approx(apply(op, x), rel=1e-9)


INVERTIBLE = [op for op in OPERATIONS if op.row.inverse is not None]


@pytest.mark.parametrize("op", INVERTIBLE, ids=names(INVERTIBLE))
def test_inverses_invert(op: Op) -> None:
    dag = Dag()
    (y,) = states(dag, 1)
    assert op.row.inverse is not None
    inverse = op.row.inverse(dag, y)
    tried = [x for x in POOL if math.isfinite(apply(op, x))]
    for x in tried:
        (found,) = evaluate_nodes(dag, [inverse], at([apply(op, x)]))
        assert found == pytest.approx(x, rel=1e-9)
    for value in (*POOL, -4.2, 4.2):  # what is not in the range of the function has no inverse
        (x,) = evaluate_nodes(dag, [inverse], at([value]))
        if math.isfinite(x):
            assert apply(op, x) == pytest.approx(value, rel=1e-9)
        else:
            assert all(abs(apply(op, t) - value) > 1e-3 for t in tried)


# --- C ----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("op", OPERATIONS, ids=names(OPERATIONS))
def test_compiled_c_gives_what_python_gives(op: Op, tmp_path) -> None:
    dag = Dag()
    symbols = states(dag, op.row.arity)
    node = dag.apply(op, tuple(symbols))
    program = optimise(make_program(dag, [dag.zero] * len(symbols), outputs=[node]))
    model = CompiledModel(emit_model(program, ""), tmp_path)
    for x in (*points(op), *itertools.product(EDGES, repeat=op.row.arity)):
        if op is Op.EQ and math.isnan(x[0]) and math.isnan(x[1]):
            continue  # Python answers for `x == x`, which asks whether x is a number
        (found,) = model.outputs(0.0, np.array(x), np.zeros(0))
        assert equal(found, apply(op, *x), 1e-14), x


def test_lanes_have_every_function_of_c() -> None:
    for op in OPERATIONS:
        if op.row.c_formula:
            assert op.row.lanes in {Lanes.FORMULA, Lanes.HEADER}, op.name


# --- text -------------------------------------------------------------------------------------


@pytest.mark.parametrize("op", OPERATIONS, ids=names(OPERATIONS))
def test_every_operation_can_be_read(op: Op) -> None:
    dag = Dag()
    node = dag.apply(op, tuple(states(dag, op.row.arity)))
    text = infix_lines(dag, [("r", node)], lambda symbol: "xyz"[symbol.index])[-1]
    sign = op.row.infix.symbol if op.row.infix else op.row.name or "if"
    assert sign in text
    assert all(letter in text for letter in "xyz"[: op.row.arity])
    assert op.row.latex.count("#") in {0, op.row.arity}


@pytest.mark.parametrize("name", BUILTINS)
def test_every_function_is_documented(name: str) -> None:
    row = BUILTINS[name]
    assert row.arguments and row.doc.endswith(".") and "\n" not in row.doc
    for text in (row.shapes, row.units):
        assert " -> " in text and "\n" not in text
    least = row.least if row.most is None else row.most
    if name != "block":
        assert len(row.arguments.replace(", ..", "").split(", ")) >= least


def test_every_function_of_reals_is_one_of_the_language() -> None:
    assert {op.row.name for op in NAMED} <= BUILTINS.keys()
    assert len(NAMED) == len({op.row.name for op in NAMED})


@pytest.mark.slow
def test_erf_and_erfc_from_text_to_a_run(tmp_path) -> None:
    """x' = -2/sqrt(pi) exp(-t^2) from 1 is erfc(t), which far out is not lost beside 1."""
    (tmp_path / "diffusion.bg").write_text(
        "model Diffusion { state x = 1; der(x) = -2/sqrt(pi)*exp(-time^2); }\n"
        "scene spread of Diffusion {\n"
        "  observe x, erfc(time) as exact, erf(time) + erfc(time) as one, erfc(9*time) as far;\n"
        "  run 3 every 0.5;\n}\n"
    )
    result = bgc.compile(tmp_path / "diffusion.bg").simulate(rtol=1e-10)
    exact = np.array([math.erfc(t) for t in result.time])
    np.testing.assert_allclose(result["x"], exact, atol=1e-9)
    np.testing.assert_allclose(result["exact"], exact, rtol=1e-13)
    np.testing.assert_allclose(result["one"], 1, rtol=1e-15)
    np.testing.assert_allclose(result["far"], [math.erfc(9 * t) for t in result.time], rtol=1e-12)
