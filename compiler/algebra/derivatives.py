"""The derivative rules: how each operation changes with its operands.

Where a function has no derivative (`abs` at 0, `sqrt` at 0, a switch), the derivative of one
side or zero is taken: always a finite number, so that `abs(v)*v` or a norm at rest is harmless.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction

from bgc.algebra.dag import Dag, Op
from bgc.algebra.nodes import Node

_TWO_OVER_SQRT_PI = Fraction("1.128379167095512573896158903121545171688101258657997")
_ONE_OVER_LN_10 = Fraction("0.4342944819032518276511289189166050822943970058036665")

CHOICES = frozenset(map(int, (Op.SELECT, Op.MIN, Op.MAX)))

Partials = tuple[tuple[Node, Node], ...]


def directional_derivative(dag: Dag, node: Node, direction: Mapping[Node, Node]) -> Node:
    """The sum over symbols s of d node / d s times `direction[s]`."""
    tangent: dict[Node, Node] = {}
    for inner in dag.reachable([node]):
        if inner in direction:
            tangent[inner] = direction[inner]
        elif not tangent.keys().isdisjoint(dag.operands(inner)):
            change = _change(dag, inner, tangent)
            if change != dag.zero:
                tangent[inner] = change
    return tangent.get(node, dag.zero)


def gradient(dag: Dag, node: Node, symbols: Iterable[Node]) -> list[Node]:
    """The derivatives of one node by several symbols, in reverse."""
    adjoint: dict[Node, Node] = {node: dag.one}
    for inner in reversed(dag.reachable([node])):
        weight = adjoint.get(inner)
        if weight is not None:
            for operand, share in adjoint_shares(dag, inner, weight):
                adjoint[operand] = dag.add(adjoint.get(operand, dag.zero), share)
    return [adjoint.get(symbol, dag.zero) for symbol in symbols]


def _change(dag: Dag, node: Node, tangent: Mapping[Node, Node]) -> Node:
    if dag.op[node] in CHOICES:
        condition, yes, no = choice(dag, node)
        zero = dag.zero
        return dag.select(condition, tangent.get(yes, zero), tangent.get(no, zero))
    return dag.sum(
        dag.mul(partial, tangent[operand])
        for operand, partial in partials(dag, node)
        if operand in tangent
    )


def adjoint_shares(dag: Dag, node: Node, weight: Node) -> Partials:
    """Operands of a node, each with what it gets of the node's adjoint `weight`."""
    if dag.op[node] in CHOICES:
        condition, yes, no = choice(dag, node)
        zero = dag.zero
        return (
            (yes, dag.select(condition, weight, zero)),
            (no, dag.select(condition, zero, weight)),
        )
    return tuple((operand, dag.mul(partial, weight)) for operand, partial in partials(dag, node))


def choice(dag: Dag, node: Node) -> tuple[Node, Node, Node]:
    """Of a node among `CHOICES`: the condition, what it is if that holds, and else."""
    a, b = dag.a[node], dag.b[node]
    match dag.op[node]:
        case Op.MIN:
            return dag.call(Op.LE, a, b), a, b
        case Op.MAX:
            return dag.call(Op.LE, b, a), a, b
        case _:
            return a, b, dag.c[node]


def partials(dag: Dag, node: Node) -> Partials:
    """Operands of a node (not one of `CHOICES`), each with the node's derivative by it.

    An operand that is there twice (`x * x`) is listed twice.
    """
    op, a, b = Op(dag.op[node]), dag.a[node], dag.b[node]
    one = dag.one
    match op:
        case Op.MUL:
            return ((a, b), (b, a))
        case Op.ADD:
            return ((a, one), (b, one))
        case Op.SUB:
            return ((a, one), (b, dag.const(-1)))
        case Op.NEG:
            return ((a, dag.const(-1)),)
        case Op.DIV:
            reciprocal = dag.div(one, b)
            return ((a, reciprocal), (b, dag.neg(dag.mul(node, reciprocal))))
        case Op.POW:
            return _power(dag, node, a, b)
        case Op.ATAN2:
            square = dag.div(one, dag.add(dag.mul(a, a), dag.mul(b, b)))
            return ((a, dag.mul(b, square)), (b, dag.neg(dag.mul(a, square))))
        case Op.HYPOT:
            reciprocal = _guarded(dag, node, one)
            return ((a, dag.mul(a, reciprocal)), (b, dag.mul(b, reciprocal)))
        case Op.FMOD:
            whole = dag.div(dag.sub(a, node), b)
            return ((a, one), (b, dag.neg(whole)))
        case (
            Op.LT | Op.LE | Op.EQ | Op.AND | Op.OR | Op.NOT | Op.SIGN | Op.FLOOR | Op.CEIL
            | Op.CONST | Op.SYMBOL
        ):  # fmt: skip
            return ()
        case Op.SELECT | Op.MIN | Op.MAX:
            raise AssertionError(f"{op.name} has the derivative of what it chooses")
        case _:
            return ((a, _of_function(dag, op, node, a)),)


def _of_function(
    dag: Dag,
    op: Op,
    y: Node,
    x: Node,
) -> Node:
    """The derivative of the function `y = op(x)`."""
    one = dag.one

    def reciprocal(node: Node) -> Node:
        return dag.div(one, node)

    def root_of(node: Node) -> Node:
        return dag.call(Op.SQRT, node)

    match op:
        case Op.SIN:
            return dag.call(Op.COS, x)
        case Op.COS:
            return dag.neg(dag.call(Op.SIN, x))
        case Op.TAN:
            return dag.add(one, dag.mul(y, y))
        case Op.ASIN:
            return reciprocal(root_of(dag.sub(one, dag.mul(x, x))))
        case Op.ACOS:
            return dag.neg(reciprocal(root_of(dag.sub(one, dag.mul(x, x)))))
        case Op.ATAN:
            return reciprocal(dag.add(one, dag.mul(x, x)))
        case Op.SINH:
            return dag.call(Op.COSH, x)
        case Op.COSH:
            return dag.call(Op.SINH, x)
        case Op.TANH:
            return dag.sub(one, dag.mul(y, y))
        case Op.EXP:
            return y
        case Op.LOG:
            return reciprocal(x)
        case Op.SQRT:
            return _guarded(dag, y, dag.const(Fraction(1, 2)))
        case Op.ABS:
            return dag.call(Op.SIGN, x)
        case Op.ASINH:
            return reciprocal(root_of(dag.add(dag.mul(x, x), one)))
        case Op.ACOSH:
            return reciprocal(root_of(dag.sub(dag.mul(x, x), one)))
        case Op.ATANH:
            return reciprocal(dag.sub(one, dag.mul(x, x)))
        case Op.CBRT:
            return dag.mul(dag.const(Fraction(1, 3)), _guarded(dag, dag.mul(y, y), one))
        case Op.ERF:
            bell = dag.call(Op.EXP, dag.neg(dag.mul(x, x)))
            return dag.mul(dag.const(_TWO_OVER_SQRT_PI), bell)
        case Op.LOG10:
            return dag.mul(dag.const(_ONE_OVER_LN_10), reciprocal(x))
        case Op.EXPM1:
            return dag.add(y, one)
        case Op.LOG1P:
            return reciprocal(dag.add(one, x))
        case _:
            raise AssertionError(f"{op.name} is not a function of one operand")


def _guarded(dag: Dag, divisor: Node, dividend: Node) -> Node:
    """`dividend / divisor`, and 0 where the divisor is 0 (a NaN is not)."""
    return dag.select(divisor, dag.div(dividend, divisor), dag.zero)


def _power(dag: Dag, node: Node, a: Node, b: Node) -> Partials:
    """Of `a^b`: by a, `b a^(b-1)`, right also at a = 0; by b, `a^b log a`, 0 at a = 0."""
    by_base = dag.mul(b, dag.pow(a, dag.sub(b, dag.one)))
    if dag.op[b] == Op.CONST:
        return ((a, by_base),)
    logarithm = dag.select(a, dag.call(Op.LOG, a), dag.zero)
    return ((a, by_base), (b, dag.mul(node, logarithm)))
