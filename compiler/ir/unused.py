"""Remove from a program the divisors and jumps that no longer vary, or that nothing uses."""

from __future__ import annotations

from dataclasses import replace

from bgc.algebra.dag import Dag, Level, Op
from bgc.ir.fields import nodes_of
from bgc.ir.graph import Node
from bgc.ir.program import Divisor, Program


def without_unused_divisors(program: Program) -> Program:
    """Remove the divisors that are in no other node of the program, or no longer vary.

    The quotient by a divisor may divide by a part of it: `a / -b` is `-(a / b)`. Then that part
    takes its place.
    """
    if not program.divisors:
        return program
    dag = program.dag
    used = set(dag.reachable(nodes_of(replace(program, divisors=()))))
    below = {dag.b[node] for node in used if dag.op[node] == Op.DIV}
    left: dict[Node, Divisor] = {}
    for divisor in program.divisors:
        present = divisor.node in used
        for node in [divisor.node] if present else _factors_below(dag, divisor.node):
            if dag.level[node] > Level.PARAM and (present or node in below):
                left.setdefault(node, replace(divisor, node=node))
    return replace(program, divisors=tuple(left.values()))


def _factors_below(dag: Dag, node: Node) -> list[Node]:
    """The divisors of the factors of `1 / node`."""
    found: list[Node] = []
    stack = [dag.div(dag.one, node)]
    while stack:
        top = stack.pop()
        if dag.op[top] == Op.DIV:
            found.append(dag.b[top])
            stack.append(dag.a[top])
        elif dag.op[top] in (Op.NEG, Op.MUL):
            stack.extend(dag.operands(top))
    return found


def without_settled_jumps(program: Program) -> Program:
    """Remove the jumps whose conditions no longer vary: they never become true."""
    if not program.jumps:
        return program
    level = program.dag.level
    left = (jump for jump in program.jumps if level[jump.condition] > Level.PARAM)
    return replace(program, jumps=tuple(left))
