"""Find the terms of time alone whose bounds the runtime watches.

Error control compares a few stages of a step, and a source that acts between two of them stays
unseen: a pulse of 1 ms in 10 s. Expressions of time, inputs and parameters need no integration to
be looked at. The runtime evaluates ranges of them and of their derivatives by time over windows
ahead (`runtime/c/timed.c`), and limits steps where one of them may move within a part of a step.

Each additive term of a largest such expression is bounded by itself, since the range of a sum of
many components is far wider than its values. Terms that are linear in time need no watching.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.derivatives import directional_derivative
from bgc.algebra.operations import ROWS
from bgc.ir.graph import Node
from bgc.ir.lowered import Switch
from bgc.ir.program import Program

TimedTerm = tuple[Node, Node]
"""A term of time alone, and its derivative by time."""


def find_timed_terms(program: Program, switches: Iterable[Switch]) -> tuple[TimedTerm, ...]:
    """The terms of time alone in the rates and in the arguments of timed switches.

    Their derivatives are added to the program's DAG.
    """
    dag = program.dag
    time = dag.symbol(Kind.TIME)
    roots = [state.derivative for state in program.states]
    roots += [switch.argument for switch in switches if switch.timed]
    moving = _moving(dag, roots)
    terms = {}
    for node in _largest(dag, roots):
        for term in _summands(dag, node, moving):
            rate = directional_derivative(dag, term, {time: dag.one})
            if dag.level[rate] > Level.PARAM:
                terms[term] = rate
    return tuple(terms.items())


def with_rates(program: Program, switches: Iterable[Switch]) -> tuple[Switch, ...]:
    """Timed switches with the derivatives of their arguments, where these do not jump.

    With its derivative the range of an argument is far narrower (`runtime/c/time_events.c`). The
    derivatives are added to the program's DAG.
    """
    dag = program.dag
    direction = {dag.symbol(Kind.TIME): dag.one}
    return tuple(
        replace(switch, rate=directional_derivative(dag, switch.argument, direction))
        if switch.timed and not _jumps(dag, switch.argument)
        else switch
        for switch in switches
    )


def _jumps(dag: Dag, argument: Node) -> bool:
    """Test whether an argument contains an operation that jumps; kinks do not."""
    rows = (ROWS[dag.op[node]] for node in dag.reachable([argument]))
    return any(row.jump is not None and not row.kink for row in rows)


def _moving(dag: Dag, roots: Iterable[Node]) -> frozenset[Node]:
    """The nodes that depend on time, and on states not at all."""
    moving: set[Node] = set()
    for node in dag.reachable(roots, Level.TIME):
        symbol = dag.symbol_of(node)
        if symbol is not None:
            if symbol.kind is Kind.TIME:
                moving.add(node)
        elif dag.level[node] == Level.TIME and not moving.isdisjoint(dag.operands(node)):
            moving.add(node)
    return frozenset(moving)


def _largest(dag: Dag, roots: Iterable[Node]) -> Iterator[Node]:
    """The expressions without states that no larger one contains, in the order of first use."""
    stack, seen = list(roots)[::-1], set[Node]()
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if dag.level[node] <= Level.TIME:
            yield node
        else:
            stack.extend(reversed(dag.operands(node)))


def _summands(dag: Dag, node: Node, moving: frozenset[Node]) -> Iterator[Node]:
    """The moving terms of a sum, without constant factors."""
    stack, seen = [node], set[Node]()
    while stack:
        top = stack.pop()
        if top in seen or top not in moving:
            continue
        seen.add(top)
        parts = [x for x in dag.operands(top) if x in moving]
        constant_divisor = dag.op[top] == Op.DIV and dag.b[top] not in moving
        scaled = (dag.op[top] == Op.MUL and len(parts) == 1) or constant_divisor
        if dag.op[top] in (Op.ADD, Op.SUB, Op.NEG) or (scaled and dag.a[top] != dag.b[top]):
            stack.extend(reversed(parts))
        else:
            yield top
