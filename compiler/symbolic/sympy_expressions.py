"""Nodes of a graph of expressions as SymPy expressions.

Constants are exact rationals (a multiple of `pi` where the constant is one). Each node is converted
once, so the time grows with the graph, not with the tree that it stands for.

The derivative rules guard divisions, `select(y, x/y, 0)`, so that a run gets a finite number where
a function has no derivative. Such a node is converted to `x/y`, which holds where y is not zero.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction

import sympy

from bgc.algebra.dag import TABLE_OPS, Dag, Op, Symbol
from bgc.algebra.linalg import spelled_out
from bgc.ir.graph import Node

_PI = Fraction(math.pi)  # the double that `pi`, `deg` and `rpm` stand for
_LONG = 40  # bits of a denominator, beyond which a constant may be a multiple of pi
_SIMPLE = 20  # bits of the numerator and denominator of such a multiple

_UNDEFINED = (sympy.zoo, sympy.nan, sympy.oo, -sympy.oo)


def expressions(
    dag: Dag, nodes: Iterable[Node], leaf: Callable[[Symbol], sympy.Expr]
) -> list[sympy.Expr]:
    """The SymPy expressions of some nodes; `leaf` gives that of a symbol.

    A function of C is written in SymPy's own: `hypot(x, y)` is `sqrt(x**2 + y**2)`, `fmod` and
    `cbrt` are spelled with `floor`, `sign` and powers so that they agree for negative numbers.
    """
    roots = spelled_out(dag, list(nodes))
    done: dict[Node, sympy.Basic] = {}
    for node in dag.reachable(roots):
        value, symbol = dag.value(node), dag.symbol_of(node)
        if value is not None:
            done[node] = constant(value)
        elif symbol is not None:
            done[node] = leaf(symbol)
        elif _is_guard(dag, node):
            done[node] = done[dag.b[node]]
        elif dag.op[node] in TABLE_OPS:
            source, marks, arguments = dag.shown_look_up(node)
            name = re.sub(r"\W+", "_", f"{source}_{len(marks) or ''}").strip("_")
            done[node] = sympy.Function(name)(*(done[x] for x in arguments))
        else:
            made = _made(Op(dag.op[node]), [done[x] for x in dag.operands(node)])
            if made in _UNDEFINED:
                raise ZeroDivisionError
            done[node] = made
    return [_number(done[root]) for root in roots]


def constant(value: Fraction) -> sympy.Expr:
    """An exact constant; a multiple of the double nearest to pi becomes one of `sympy.pi`."""
    exact = sympy.Rational(value.numerator, value.denominator)
    if value.denominator.bit_length() <= _LONG:
        return exact
    ratio = value / _PI
    longest = max(ratio.numerator.bit_length(), ratio.denominator.bit_length())
    return (
        sympy.Rational(ratio.numerator, ratio.denominator) * sympy.pi
        if longest <= _SIMPLE
        else exact
    )


def _is_guard(dag: Dag, node: Node) -> bool:
    """Test whether a choice only guards a division or a logarithm against a zero operand."""
    if dag.op[node] != Op.SELECT or dag.c[node] != dag.zero:
        return False
    condition, stack = dag.a[node], [dag.b[node]]
    while stack:
        inner = stack.pop()
        op = dag.op[inner]
        if op == Op.LOG and dag.a[inner] == condition:
            return True
        if op == Op.DIV:
            if dag.b[inner] == condition:
                return True
            stack.append(dag.a[inner])
        elif op in (Op.MUL, Op.NEG):
            stack.extend(dag.operands(inner))
    return False


def _made(op: Op, operands: list[sympy.Basic]) -> sympy.Basic:
    """An operation on operands that may be conditions."""
    if op is Op.SELECT:
        condition, yes, no = operands
        return sympy.Piecewise((_number(yes), _condition(condition)), (_number(no), True))
    if op in (Op.AND, Op.OR, Op.NOT):
        return _LOGIC[op](*map(_condition, operands))
    return _function(op)(*map(_number, operands))


def _condition(expression: sympy.Basic) -> sympy.Basic:
    """Return a condition; a number is true unless it is zero."""
    if isinstance(expression, sympy.logic.boolalg.Boolean) and not expression.is_Symbol:
        return expression
    return sympy.Ne(expression, 0)


def _number(expression: sympy.Basic) -> sympy.Expr:
    """Return a number; a condition is 1 where it holds and 0 elsewhere, as in C."""
    if isinstance(expression, sympy.logic.boolalg.Boolean) and not expression.is_Symbol:
        return sympy.Piecewise((sympy.Integer(1), expression), (sympy.Integer(0), True))
    return expression


def _cube_root(x: sympy.Expr) -> sympy.Expr:
    return sympy.sign(x) * sympy.Abs(x) ** sympy.Rational(1, 3)


def _remainder(x: sympy.Expr, y: sympy.Expr) -> sympy.Expr:
    return x - y * sympy.sign(x / y) * sympy.floor(sympy.Abs(x / y))


_LOGIC: Mapping[Op, Callable[..., sympy.Basic]] = {
    Op.AND: sympy.And,
    Op.OR: sympy.Or,
    Op.NOT: sympy.Not,
}

FUNCTIONS: Mapping[Op, Callable[..., sympy.Basic]] = {
    Op.ADD: lambda x, y: x + y,
    Op.SUB: lambda x, y: x - y,
    Op.MUL: lambda x, y: x * y,
    Op.DIV: lambda x, y: x / y,
    Op.NEG: lambda x: -x,
    Op.POW: lambda x, y: x**y,
    Op.LT: sympy.Lt,
    Op.LE: sympy.Le,
    Op.EQ: sympy.Eq,
    Op.EXPM1: lambda x: sympy.exp(x) - 1,
    Op.LOG10: lambda x: sympy.log(x) / sympy.log(10),
    Op.LOG1P: lambda x: sympy.log(1 + x),
    Op.CBRT: _cube_root,
    Op.HYPOT: lambda x, y: sympy.sqrt(x**2 + y**2),
    Op.ABS: sympy.Abs,
    Op.MIN: sympy.Min,
    Op.MAX: sympy.Max,
    Op.CEIL: sympy.ceiling,
    Op.FMOD: _remainder,
}
"""Operations that SymPy has no function of the same name and meaning for."""


def _function(op: Op) -> Callable[..., sympy.Basic]:
    """SymPy's version of an operation; a function that it does not know stays a mere name."""
    found = FUNCTIONS.get(op) or getattr(sympy, op.row.name, None) or sympy.Function(op.row.name)
    assert callable(found)
    return found
