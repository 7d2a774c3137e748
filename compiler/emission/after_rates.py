"""Values that the rates keep, so that the arguments of switches cost little behind them.

At the end of a step both are wanted: the arguments show whether a switch has left its mode, and the
next step begins with the rates. An argument such as the force of a rope, which has to be found from
all momenta, costs a large part of the rates by itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Set

from bgc.algebra.dag import Dag
from bgc.ir.graph import Node

_EVALUATIONS = 8  # of the rates in a step, at most: each stores what is kept
_WORTHWHILE = 0.5  # of the operations of the arguments by themselves


def kept_for(dag: Dag, rates: Iterable[Node], arguments: Sequence[Node]) -> tuple[Node, ...]:
    """The operations of the rates to keep for the arguments; none where that saves little.

    An operation that takes more others than the stores of its result cost is kept, or, if the rates
    do not contain it, what is to be kept of its operands.
    """
    own = dag.repeated(arguments)
    shared = own & dag.repeated(rates)
    kept: dict[Node, None] = {}
    behind: set[Node] = set()  # operations that the arguments take behind the rates
    stack = list(reversed(arguments))
    while stack:
        node = stack.pop()
        if node in kept or node in behind or node not in own:
            continue
        few = _few_operations(dag, node, own)
        if few:
            behind |= few
        elif node in shared:
            kept[node] = None
        else:
            behind.add(node)
            stack.extend(reversed(dag.operands(node)))
    cost = _EVALUATIONS * len(kept) + len(behind)
    return tuple(kept) if cost < _WORTHWHILE * len(own) else ()


def _few_operations(dag: Dag, root: Node, among: Set[Node]) -> set[Node]:
    """Those of a node with its operands, where they are fewer than stores; else none."""
    found: set[Node] = set()
    stack = [root]
    while stack and len(found) <= _EVALUATIONS:
        node = stack.pop()
        if node in among and node not in found:
            found.add(node)
            stack.extend(dag.operands(node))
    return found if len(found) <= _EVALUATIONS else set()
