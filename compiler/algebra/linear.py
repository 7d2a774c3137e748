"""Coefficients of expressions that are linear in some symbols, read off the DAG exactly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from bgc.algebra.dag import Dag, Op

_Form: TypeAlias = dict[int, int]  # symbol -> coefficient; the key -1 is the rest


def linear_coefficients(
    dag: Dag, nodes: Sequence[int], symbols: Sequence[int]
) -> tuple[tuple[int, ...], ...] | None:
    """The matrix M with `nodes = M symbols`, row by row; None when there is none.

    Sums, differences, products with and quotients by what does not hold the symbols are seen
    through; an expression that is linear only after cancelling is not recognised.
    """
    wanted = set(symbols)
    forms: dict[int, _Form | None] = {}
    for node in dag.reachable(nodes):
        forms[node] = _form(dag, node, forms, wanted)
    rows = []
    for node in nodes:
        form = forms[node]
        if form is None or form.get(-1, dag.zero) != dag.zero:
            return None
        rows.append(tuple(form.get(symbol, dag.zero) for symbol in symbols))
    return tuple(rows)


def _form(dag: Dag, node: int, forms: dict[int, _Form | None], wanted: set[int]) -> _Form | None:
    """The coefficients of a node from those of its operands; None when it is not linear."""
    if node in wanted:
        return {node: dag.one}
    operands = dag.operands(node)
    found = [forms[x] for x in operands]
    if all(form is not None and set(form) <= {-1} for form in found):
        return {-1: node}  # holds none of the symbols
    if any(form is None for form in found):
        return None
    known = [form for form in found if form is not None]
    match Op(dag.op[node]):
        case Op.ADD:
            return _combine(dag, known[0], known[1], dag.add)
        case Op.SUB:
            return _combine(dag, known[0], known[1], dag.sub)
        case Op.NEG:
            return {k: dag.neg(v) for k, v in known[0].items()}
        case Op.MUL:
            for factor, form in ((operands[0], known[1]), (operands[1], known[0])):
                if set(forms[factor] or {}) <= {-1}:
                    return {k: dag.mul(factor, v) for k, v in form.items()}
            return None
        case Op.DIV if set(known[1]) <= {-1}:
            return {k: dag.div(v, operands[1]) for k, v in known[0].items()}
        case Op.SELECT if set(known[0]) <= {-1}:
            keys = dict.fromkeys([*known[1], *known[2]])
            return {
                k: dag.select(operands[0], known[1].get(k, dag.zero), known[2].get(k, dag.zero))
                for k in keys
            }
        case _:
            return None


def _combine(dag: Dag, left: _Form, right: _Form, operation: object) -> _Form:
    assert callable(operation)
    keys = dict.fromkeys([*left, *right])
    return {k: operation(left.get(k, dag.zero), right.get(k, dag.zero)) for k in keys}
