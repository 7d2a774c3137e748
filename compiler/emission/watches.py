"""Find the nonlinear functions of states behind which a step may hide a pulse.

`exp(-((x - a)/w)^2)` differs from zero for a moment while x passes a. A step that jumps over it
has no stage there, and error control sees nothing. The arguments of functions that may do so are
watched along the dense output of each step (`runtime/c/watch.c`): exponentials, functions that
saturate, and quotients by divisors that vary.

The arguments are evaluated several times a step, so quotients are watched only if all arguments
together take few operations in comparison with the right-hand sides, or these are small.
"""

from __future__ import annotations

from collections.abc import Iterable

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.operation import Watch
from bgc.algebra.operations import ROWS
from bgc.ir.graph import Node
from bgc.ir.program import Program

_PART = 0.01  # operations of all arguments up to which quotients are watched, over those of f
_CHEAP_OPERATIONS = 200  # operations of f up to which they are watched anyway

WatchedArgument = tuple[Watch, Node]
"""A function of a state, and its argument."""


def find_watches(program: Program) -> tuple[WatchedArgument, ...]:
    """The arguments that depend on states of functions that may hide pulses, in order of nodes."""
    dag = program.dag
    nodes = dag.reachable((state.derivative for state in program.states), Level.STATE)
    found = {
        (row.watch, dag.b[node] if row.watch is Watch.RECIPROCAL else dag.a[node]): None
        for node in nodes
        if (row := ROWS[dag.op[node]]).watch is not None
    }
    varying = [pair for pair in found if dag.level[pair[1]] == Level.STATE]
    own = [pair for pair in varying if pair[0] is not Watch.RECIPROCAL]
    total = _operations(dag, nodes)
    cost = _operations(dag, dag.reachable((node for _, node in varying), Level.STATE))
    affordable = total <= _CHEAP_OPERATIONS or cost <= _PART * total
    return tuple(varying if affordable else own)


def _operations(dag: Dag, nodes: Iterable[Node]) -> int:
    return sum(1 for n in nodes if dag.op[n] > Op.SYMBOL)
