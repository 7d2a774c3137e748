"""Solve one equation for one variable in closed form, where its law can be turned round.

Only operations that are one to one are undone, so that a solution found is the only one; the
laws `k x abs(x)` of flow through an orifice and odd powers are among them. Everything else is
left to the integrators (`loops`).
"""

from __future__ import annotations

from fractions import Fraction

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.polynomials import terms_in
from bgc.graph import Node

_INVERSES = {
    Op.EXP: Op.LOG,
    Op.LOG: Op.EXP,
    Op.EXPM1: Op.LOG1P,
    Op.LOG1P: Op.EXPM1,
    Op.SINH: Op.ASINH,
    Op.ASINH: Op.SINH,
    Op.TANH: Op.ATANH,
    Op.ATANH: Op.TANH,
}


def solve_for(dag: Dag, node: Node, target: Node, symbol: Node) -> Node | None:
    """The value of a symbol at which `node = target`; None where no closed form is known.

    Where there is no real solution the value is not a number.
    """
    while node != symbol:
        inner = _undo_sum_of_powers(dag, node, target, symbol)
        if inner is not None:
            return inner
        undone = _undo(dag, node, target, _dependent(dag, node, symbol))
        if undone is None:
            return None
        node, target = undone
    return target


def _dependent(dag: Dag, node: Node, symbol: Node) -> list[bool]:
    """Which operands of a node hold the symbol."""
    return [symbol in dag.reachable([operand]) for operand in dag.operands(node)]


def _undo(dag: Dag, node: Node, target: Node, dependent: list[bool]) -> tuple[Node, Node] | None:
    """The operand that holds the symbol, and what it has to be."""
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
        case Op.NEG, _:
            return operands[0], dag.neg(target)
        case Op.MUL, [True, False] if _is_fixed(dag, operands[1]):
            return operands[0], dag.div(target, operands[1])
        case Op.MUL, [False, True] if _is_fixed(dag, operands[0]):
            return operands[1], dag.div(target, operands[0])
        case Op.DIV, [True, False]:
            return operands[0], dag.mul(target, operands[1])
        case Op.CBRT, _:
            return operands[0], dag.pow(target, dag.const(3))
        case _ if op in _INVERSES:
            return operands[0], dag.call(_INVERSES[op], target)
        case _:
            return None


def _is_fixed(dag: Dag, node: Node) -> bool:
    """Whether a factor does not vanish on the way: no state changes it."""
    return dag.level[node] <= Level.PARAM


def _undo_sum_of_powers(dag: Dag, node: Node, target: Node, symbol: Node) -> Node | None:
    """Solve `c x^n + d = target`, or with `x^n abs(x)`, where the power is odd."""
    terms = terms_in(dag, node, symbol)
    if terms is None:
        return None
    rest = terms.pop((0, 0), dag.zero)
    if len(terms) != 1:
        return None
    ((power, absolute), factor) = next(iter(terms.items()))
    if power % 2 == 0 or not _is_fixed(dag, factor):
        return None
    value = dag.div(dag.sub(target, rest), factor)
    degree = power + absolute
    match degree:
        case 1:
            return value
        case 3:
            return dag.call(Op.CBRT, value)
        case 2:
            root = dag.call(Op.SQRT, dag.call(Op.ABS, value))
        case _:
            root = dag.pow(dag.call(Op.ABS, value), dag.const(Fraction(1, degree)))
    return dag.mul(dag.call(Op.SIGN, value), root)
