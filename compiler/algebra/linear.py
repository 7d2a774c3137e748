"""Linear forms: nodes as `sum coefficient * symbol + rest`, read off the DAG exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from bgc.algebra.dag import Dag, Op
from bgc.algebra.nodes import Matrix, Node

LinearForm: TypeAlias = tuple[dict[Node, Node], Node]
"""The coefficient of each symbol, and the rest."""


def linear_coefficients(dag: Dag, nodes: Sequence[Node], symbols: Sequence[Node]) -> Matrix | None:
    """Find the matrix M with `nodes = M symbols`, row by row; None where there is none.

    An expression that is linear only after terms cancel is not recognised.
    """
    forms: dict[Node, LinearForm | None] = {s: ({s: dag.one}, dag.zero) for s in symbols}
    for node in dag.reachable(nodes):
        if node not in forms:
            operands = [forms[x] for x in dag.operands(node)]
            known = [form for form in operands if form is not None]
            forms[node] = linear_form(dag, node, known) if len(known) == len(operands) else None
    rows = []
    for node in nodes:
        form = forms[node]
        if form is None or form[1] != dag.zero:
            return None
        rows.append(tuple(form[0].get(symbol, dag.zero) for symbol in symbols))
    return tuple(rows)


def linear_form(dag: Dag, node: Node, operands: Sequence[LinearForm]) -> LinearForm | None:
    """The form of a node from the forms of its operands; None where it is not linear.

    Handles sums, differences, products with and quotients by constants, and choices whose condition
    is a constant, where a constant is a form without symbols.
    """
    op = dag.op[node]
    if not any(coefficients for coefficients, _ in operands):
        rests = tuple(rest for _, rest in operands)
        return {}, node if rests == dag.operands(node) else dag.rebuild(node, rests)
    match operands:
        case [(a, x)] if op == Op.NEG:
            return _mapped(a, dag.neg), dag.neg(x)
        case [(a, x), (b, y)] if op == Op.ADD:
            return _sum(dag, a, b), dag.add(x, y)
        case [(a, x), (b, y)] if op == Op.SUB:
            return _sum(dag, a, _mapped(b, dag.neg)), dag.sub(x, y)
        case [(a, x), (b, y)] if op == Op.MUL and not b:
            return _mapped(a, lambda c: dag.mul(c, y)), dag.mul(x, y)
        case [(a, x), (b, y)] if op == Op.MUL and not a:
            return _mapped(b, lambda c: dag.mul(x, c)), dag.mul(x, y)
        case [(a, x), (b, y)] if op == Op.DIV and not b:
            return _mapped(a, lambda c: dag.div(c, y)), dag.div(x, y)
        case [(c, z), (a, x), (b, y)] if op == Op.SELECT and not c:
            zero = dag.zero
            chosen = {k: dag.select(z, a.get(k, zero), b.get(k, zero)) for k in {**a, **b}}
            return chosen, dag.select(z, x, y)
        case _:
            return None


def _mapped(a: Mapping[Node, Node], change: Callable[[Node], Node]) -> dict[Node, Node]:
    return {key: change(node) for key, node in a.items()}


def _sum(dag: Dag, a: Mapping[Node, Node], b: Mapping[Node, Node]) -> dict[Node, Node]:
    """The sum of coefficients, without those that cancel."""
    total = dict(a)
    for key, node in b.items():
        total[key] = dag.add(total[key], node) if key in total else node
        if total[key] == dag.zero:
            del total[key]
    return total
