"""The nodes that a program evaluates whatever its conditions are."""

from __future__ import annotations

from collections.abc import Iterable

from bgc.algebra.dag import Dag, Op
from bgc.ir.graph import Node


def always_evaluated(dag: Dag, node: Node) -> tuple[Node, ...]:
    """The operands of a node that its value always depends on; of a choice the condition only."""
    operands = dag.operands(node)
    return operands[:1] if dag.op[node] == Op.SELECT else operands


def evaluated_always(dag: Dag, roots: Iterable[Node]) -> list[Node]:
    """All nodes below roots that do not stand in branches of choices only."""
    seen = set(roots)
    stack = list(seen)
    while stack:
        for operand in always_evaluated(dag, stack.pop()):
            if operand not in seen:
                seen.add(operand)
                stack.append(operand)
    return sorted(seen)
