"""SymPy as an independent judge of the compiler's own algebra.

What the graph of expressions computes, differentiates, inverts and prints is compared with what
SymPy makes of the same formulas, which shares no code with it.
"""

from __future__ import annotations

import random

import pytest
import sympy
from programs import at, make_program, states
from sympy.parsing.latex import parse_latex
from test_latex import equations_of
from test_operations import OPERATIONS, points

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.derivatives import CHOICES, gradient
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.inversion import solve_for
from bgc.algebra.linalg import inverse
from bgc.printing.latex import latex_equations
from bgc.printing.stages import symbol_names
from bgc.symbolic.sympy_expressions import expressions

LETTERS = {
    Kind.STATE: sympy.symbols("x:9", real=True),
    Kind.PARAM: sympy.symbols("p:9", real=True),
    Kind.INPUT: sympy.symbols("u:3", real=True),
    Kind.TIME: sympy.symbols("t:1", real=True),
}


def leaf(symbol: Symbol) -> sympy.Symbol:
    return LETTERS[symbol.kind][symbol.index]


def numbers(values: dict[Symbol, float]) -> dict[sympy.Symbol, sympy.Float]:
    return {leaf(symbol): sympy.Float(value, 30) for symbol, value in values.items()}


def number(expression: sympy.Expr, values: dict[Symbol, float]) -> float:
    return float(expression.subs(numbers(values)).evalf(20))


# --- values and derivatives -------------------------------------------------------------------


@pytest.mark.parametrize("op", OPERATIONS, ids=lambda op: op.name)
def test_operations_are_converted_with_their_values(op):
    """Also their slopes, which hold the guards that a formula leaves out."""
    dag = Dag()
    x = states(dag, op.row.arity)
    node = dag.apply(op, tuple(x))
    choice = op in CHOICES or not op.row.partials
    slopes = [] if choice else gradient(dag, node, x)
    converted = expressions(dag, [node, *slopes], leaf)
    for point in points(op)[:: max(1, len(points(op)) // 5)]:
        values = at(list(point))
        found = [number(expression, values) for expression in converted]
        assert found == pytest.approx(evaluate_nodes(dag, [node, *slopes], values), rel=1e-12)


def test_a_choice_is_piecewise():
    dag = Dag()
    x, y = states(dag, 2)
    both = dag.call(Op.AND, dag.call(Op.LT, x, y), y)
    node = dag.select(dag.call(Op.OR, both, dag.call(Op.NOT, x)), dag.mul(x, x), dag.add(x, both))
    (expression,) = expressions(dag, [node], leaf)
    for point in ([1.0, 2.0], [2.0, 1.0], [0.0, -1.0], [-1.0, 0.0]):
        values = at(point)
        assert number(expression, values) == evaluate_nodes(dag, [node], values)[0]


def test_a_guard_against_a_division_by_zero_is_not_shown():
    dag = Dag()
    (x,) = states(dag, 1)
    (slope,) = gradient(dag, dag.call(Op.SQRT, x), [x])
    assert dag.op[slope] == Op.SELECT
    assert expressions(dag, [slope], leaf) == [1 / (2 * sympy.sqrt(leaf(Symbol(Kind.STATE, 0))))]


def random_node(seed: int, operations: int) -> tuple[Dag, list[int], int]:
    """A smooth expression in three states, of so many operations with shared parts."""
    rng = random.Random(seed)
    dag = Dag()
    x = states(dag, 3)
    nodes = [*x, dag.symbol(Kind.PARAM, 0), dag.const(0.3)]
    for _ in range(operations):
        a, b = rng.choice(nodes[-6:]), rng.choice(nodes)
        one = dag.add(dag.one, dag.mul(b, b))
        nodes.append(
            rng.choice(
                [
                    lambda a=a, b=b: dag.add(a, dag.call(Op.SIN, b)),
                    lambda a=a, b=b: dag.sub(dag.call(Op.TANH, a), b),
                    lambda a=a, b=b: dag.mul(dag.call(Op.COS, a), b),
                    lambda a=a, one=one: dag.div(a, one),
                    lambda a=a, one=one: dag.mul(a, dag.call(Op.SQRT, one)),
                    lambda a=a, one=one: dag.sub(a, dag.call(Op.LOG, one)),
                    lambda a=a, one=one: dag.pow(one, dag.call(Op.SIN, a)),
                    lambda a=a, b=b: dag.add(dag.call(Op.ATAN, a), dag.call(Op.ERF, b)),
                ]
            )()
        )
    return dag, x, nodes[-1]


@pytest.mark.parametrize("seed", range(25))
def test_random_expressions_have_sympys_derivatives(seed):
    dag, x, node = random_node(seed, 7)
    values = at([0.4, -0.7, 1.1], p=[0.8])
    (expression,) = expressions(dag, [node], leaf)
    (expected,) = evaluate_nodes(dag, [node], values)
    assert number(expression, values) == pytest.approx(expected, rel=1e-12)
    for k, slope in enumerate(evaluate_nodes(dag, gradient(dag, node, x), values)):
        derivative = sympy.diff(expression, LETTERS[Kind.STATE][k])
        assert slope == pytest.approx(number(derivative, values), rel=1e-10, abs=1e-14)


# --- inverses ---------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("symmetric", [False, True])
def test_inverses_of_letters_are_sympys(size, symmetric):
    """Exactly: with rational numbers for the letters, and as formulas up to 3 x 3."""
    rng = random.Random(size)
    dag = Dag()
    p = [dag.symbol(Kind.PARAM, k) for k in range(6)]
    entries = [[dag.zero] * size for _ in range(size)]
    for i in range(size):
        for j in range(size):
            if i == j:
                entries[i][j] = dag.add(p[rng.randrange(6)], dag.const(rng.randint(1, 3)))
            elif j > i and rng.random() < 0.6:
                entries[i][j] = dag.mul(p[rng.randrange(6)], dag.const(rng.randint(1, 3)))
                if symmetric or rng.random() < 0.3:
                    entries[j][i] = entries[i][j]
    matrix = tuple(map(tuple, entries))
    inverted = [node for row in inverse(dag, matrix) for node in row]
    flat = [node for row in matrix for node in row]
    for _ in range(3):
        point = {
            Symbol(Kind.PARAM, k): sympy.Rational(rng.randint(1, 99), 7) for k in range(len(p))
        }
        values, found = (
            sympy.Matrix(size, size, expressions(dag, nodes, point.__getitem__))
            for nodes in (flat, inverted)
        )
        assert found == values.inv()
    if size <= 3:
        letters, found = (
            sympy.Matrix(size, size, expressions(dag, nodes, leaf)) for nodes in (flat, inverted)
        )
        assert (letters * found).applyfunc(sympy.cancel) == sympy.eye(size)


LAWS = {
    "affine": lambda d, x, p: d.sub(d.const(3), d.div(d.mul(p[0], x), d.const(5))),
    "root": lambda d, x, p: d.mul(p[0], d.call(Op.SQRT, d.add(x, p[1]))),
    "exponential": lambda d, x, p: d.sub(d.call(Op.EXP, d.div(x, p[1])), p[0]),
    "logarithm": lambda d, x, p: d.mul(p[0], d.call(Op.LOG, d.mul(p[1], x))),
    "saturation": lambda d, x, p: d.mul(p[0], d.call(Op.TANH, d.mul(p[1], x))),
    "cube": lambda d, x, p: d.mul(p[0], d.mul(x, d.mul(x, x))),
}


@pytest.mark.parametrize("name", LAWS)
def test_laws_turned_round_are_solutions_by_sympy(name):
    """The inverse put into the law gives back what the law was to be, formula by formula."""
    dag = Dag()
    x, y = states(dag, 2)
    p = [dag.symbol(Kind.PARAM, k) for k in range(2)]
    law = LAWS[name](dag, x, p)
    found = solve_for(dag, law, y, x, lambda node: 1.0)
    assert found is not None
    (back,) = dag.substitute([law], {x: found})
    (expression,) = expressions(dag, [back], leaf)
    for point in (0.31, 0.77):
        values = at([0.5, point], p=[1.3, 0.9])
        assert number(expression, values) == pytest.approx(point, rel=1e-14)


# --- LaTeX ------------------------------------------------------------------------------------

NAMES = ["a", "b", "k", "m", "n"]


@pytest.mark.parametrize("seed", range(10))
def test_equations_in_latex_are_read_by_sympy_as_they_are(seed):
    """SymPy's own parser of LaTeX, with Lark's grammar, gives back the formula of the nodes."""
    rng = random.Random(seed)
    dag = Dag()
    nodes = [dag.symbol(Kind.PARAM, k) for k in range(5)]
    leaves = [*nodes, dag.const(2), dag.const(7)]
    for _ in range(8):
        left, right = rng.choice(nodes), rng.choice([*nodes, *leaves])
        made = rng.choice([dag.add, dag.sub, dag.mul, dag.div])(left, right)
        nodes.append(dag.call(Op.SQRT, made) if rng.random() < 0.2 else made)
    root = nodes[-1]
    program = make_program(dag, [root], parameters=[(name, dag.one) for name in NAMES])
    known: dict[sympy.Symbol, sympy.Expr] = {}
    right = ""
    for left, right in equations_of(latex_equations(program, symbol_names(program))):
        name = sympy.Symbol(left.replace("{", "").replace("}", ""))
        known[name] = read(right).subs(known)
    (expected,) = expressions(dag, [root], lambda symbol: sympy.Symbol(NAMES[symbol.index]))
    found = known[name]
    values = {sympy.Symbol(name): 0.3 + 0.4 * k for k, name in enumerate(NAMES)}
    assert complex(found.subs(values)) == pytest.approx(complex(expected.subs(values)), rel=1e-12)


def read(text: str) -> sympy.Expr:
    """A formula in LaTeX as SymPy reads it, names of auxiliary quantities without braces."""
    plain = text.replace(r"\,", r" \cdot ").replace("&\\quad", "").replace("{}", "")
    return parse_latex(plain, backend="lark")
