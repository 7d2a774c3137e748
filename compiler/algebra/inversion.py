"""Solve one equation for one variable in closed form.

Only one-to-one operations are inverted, so that a solution is the only one: sums and products with
terms that do not depend on the variable, functions with an inverse, signed powers such as
`k x abs(x)` and `k sign(x) sqrt(abs(x))` (flow through an orifice), and `a x + b x abs(x)` and
`a x + b x^3` with coefficients of equal sign. Everything else becomes an algebraic state (`loops`).
The value is NaN where the equation has no real solution.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.interpretation import Intervals
from bgc.algebra.nodes import Node
from bgc.algebra.polynomials import terms_in
from bgc.record_class import dataclass


def solve_for(
    dag: Dag,
    node: Node,
    target: Node,
    symbol: Node,
    limits: Callable[[Node], tuple[float, float]] | None = None,
    note: Callable[[Node], None] = lambda node: None,
) -> Node | None:
    """Solve `node = target` for a symbol; None where no closed form is known.

    `limits` gives the least and the largest value of a node, at the parameters' defaults; without
    it these hold for all parameters. `note` is called with nodes of PARAM level that have to be
    positive for the solution to be unique.
    """
    limits = limits or Intervals(dag).limits
    while node != symbol:
        inner = _undo_sum_of_powers(dag, node, target, symbol, limits, note)
        if inner is not None:
            return inner
        undone = _undo_signed_power(dag, node, target, symbol) or _undo(
            dag, node, target, _dependent(dag, node, symbol)
        )
        if undone is None:
            return None
        node, target = undone
    return target


def _dependent(dag: Dag, node: Node, symbol: Node) -> list[bool]:
    """For each operand of a node, whether it depends on the symbol."""
    return [symbol in dag.reachable([operand]) for operand in dag.operands(node)]


def _undo(dag: Dag, node: Node, target: Node, dependent: list[bool]) -> tuple[Node, Node] | None:
    """The operand that depends on the symbol, and the value it has to have."""
    op = Op(dag.op[node])
    operands = dag.operands(node)
    match op, dependent:
        case Op.ADD, [True, False]:
            return operands[0], dag.sub(target, operands[1])
        case Op.ADD, [False, True]:
            return operands[1], dag.sub(target, operands[0])
        case Op.SUB, [True, False]:
            return operands[0], dag.add(target, operands[1])
        case Op.SUB, [False, True]:
            return operands[1], dag.sub(operands[0], target)
        case Op.MUL, [True, False] if _is_fixed(dag, operands[1]):
            return operands[0], dag.div(target, operands[1])
        case Op.MUL, [False, True] if _is_fixed(dag, operands[0]):
            return operands[1], dag.div(target, operands[0])
        case Op.DIV, [True, False]:
            return operands[0], dag.mul(target, operands[1])
        case _ if op.row.inverse is not None:
            return operands[0], op.row.inverse(dag, target)
        case _:
            return None


def _is_fixed(dag: Dag, node: Node) -> bool:
    """Test whether a factor is constant during a run, so that it does not pass through zero."""
    return dag.level[node] <= Level.PARAM


# --- powers with a sign -------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Power:
    """`factor * sign(base)^sign * abs(base)^degree`; base None: the factor alone."""

    base: Node | None
    sign: int
    degree: Fraction
    factor: Node


def _undo_signed_power(
    dag: Dag, node: Node, target: Node, symbol: Node
) -> tuple[Node, Node] | None:
    """The base of an odd power, fractional ones included, and the value it has to have."""
    if dag.op[node] not in {Op.MUL, Op.DIV, Op.POW}:
        return None
    power = _power_in(dag, node, symbol)
    if power is None or power.base is None or power.degree <= 0 or power.base == node:
        return None
    if power.sign % 2 == 0 or not _is_fixed(dag, power.factor):
        return None
    value = dag.div(target, power.factor)
    return power.base, _signed_root(dag, value, power.degree)


def _signed_root(dag: Dag, value: Node, degree: Fraction) -> Node:
    """`sign(value) abs(value)^(1 / degree)`."""
    size = dag.call(Op.ABS, value)
    if degree == 1:
        return value
    if degree == 3:
        return dag.call(Op.CBRT, value)
    if degree == 2:
        return dag.mul(dag.call(Op.SIGN, value), dag.call(Op.SQRT, size))
    if degree == Fraction(1, 2):
        return dag.mul(value, size)
    return dag.mul(dag.call(Op.SIGN, value), dag.pow(size, dag.const(1 / degree)))


def _power_in(dag: Dag, node: Node, symbol: Node) -> _Power | None:
    """A product as a power of one base; None for anything else."""
    if symbol not in dag.reachable([node]):
        return _Power(None, 0, Fraction(0), node)
    operands = dag.operands(node)
    match Op(dag.op[node]):
        case Op.MUL | Op.DIV as op:
            left, right = (_power_in(dag, x, symbol) for x in operands)
            return None if left is None or right is None else _product(dag, op, left, right)
        case Op.SIGN:
            return _Power(operands[0], 1, Fraction(0), dag.one)
        case Op.ABS:
            return _Power(operands[0], 0, Fraction(1), dag.one)
        case Op.SQRT if dag.op[operands[0]] == Op.ABS:
            return _Power(dag.a[operands[0]], 0, Fraction(1, 2), dag.one)
        case Op.POW if dag.op[operands[0]] == Op.ABS and dag.value(operands[1]) is not None:
            return _Power(dag.a[operands[0]], 0, Fraction(dag.value(operands[1]) or 0), dag.one)
        case _:
            return _Power(node, 1, Fraction(1), dag.one)


def _product(dag: Dag, op: Op, left: _Power, right: _Power) -> _Power | None:
    if left.base is not None and right.base is not None and left.base != right.base:
        return None
    direction = 1 if op == Op.MUL else -1
    combine = dag.mul if op == Op.MUL else dag.div
    return _Power(
        left.base if left.base is not None else right.base,
        left.sign + right.sign,
        left.degree + direction * right.degree,
        combine(left.factor, right.factor),
    )


# --- sums of powers -----------------------------------------------------------------------------


def _undo_sum_of_powers(
    dag: Dag,
    node: Node,
    target: Node,
    symbol: Node,
    limits: Callable[[Node], tuple[float, float]],
    note: Callable[[Node], None],
) -> Node | None:
    """Solve `a x + b x abs(x)`, `a x + b x^3` or one odd power, plus a constant, for x."""
    terms = terms_in(dag, node, symbol)
    if terms is None:
        return None
    value = dag.sub(target, terms.pop((0, 0), dag.zero))
    if not all(_is_fixed(dag, factor) for factor in terms.values()):
        return None
    if len(terms) == 1:
        ((power, absolute), factor) = next(iter(terms.items()))
        if power % 2 == 0:
            return None
        return _signed_root(dag, dag.div(value, factor), Fraction(power + absolute))
    linear = terms.pop((1, 0), None)
    if linear is None or len(terms) != 1:
        return None
    (key, factor) = next(iter(terms.items()))
    if limits(linear)[1] < 0:
        linear, factor, value = dag.neg(linear), dag.neg(factor), dag.neg(value)
    if key not in {(1, 1), (3, 0)} or not all(limits(node)[0] > 0 for node in (linear, factor)):
        return None
    for positive in (linear, factor):
        if dag.value(positive) is None:
            note(positive)
    if key == (1, 1):
        return _quadratic(dag, linear, factor, value)
    return _cubic(dag, linear, factor, value)


def _quadratic(dag: Dag, a: Node, b: Node, y: Node) -> Node:
    """The solution 2 y / (a + root) of `a x + b x abs(x) = y`, free of cancellation."""
    under = dag.add(dag.mul(a, a), dag.mul(dag.mul(dag.const(4), b), dag.call(Op.ABS, y)))
    return dag.div(dag.mul(dag.const(2), y), dag.add(a, dag.call(Op.SQRT, under)))


def _cubic(dag: Dag, a: Node, b: Node, y: Node) -> Node:
    """The solution of `a x + b x^3 = y` with a, b > 0, by hyperbolic functions (Cardano)."""
    size = dag.mul(dag.const(2), dag.call(Op.SQRT, dag.div(a, dag.mul(dag.const(3), b))))
    argument = dag.div(dag.mul(dag.const(3), y), dag.mul(a, size))
    third = dag.div(dag.call(Op.ASINH, argument), dag.const(3))
    return dag.mul(size, dag.call(Op.SINH, third))
