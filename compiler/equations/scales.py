"""The unit in which each state's absolute tolerance counts.

A momentum counts in what moves its own flow by one unit. Alone that is its inertia at unit flow; of
several momenta that one matrix couples, M, it is 1/(M^-1)_ii, which does not grow with the lever
from a body's frame to its centre of mass, as M_ii does. A charge counts in that which gives the
compliance as much energy as the inertias beside it have at unit flow, `sqrt(m / k)`: an
oscillation of a stiff spring is then resolved as finely as the momentum it belongs to, neither
finer (which would cost small steps) nor coarser. A compliance without an inertia beside it
counts in its charge at unit effort. A momentum merged of several counts in the largest of them that
its flow moves in a fixed ratio. Everything else counts in its own unit. Where nothing comes near
unit flow, in a circuit of microamperes, step control makes all scales finer by as much
(`look_for_life` in `runtime/c/step.c`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bgc.algebra.dag import Dag, Level, Op
from bgc.equations.storage.kinds import IntegratedState, StorageElement, StoragePort
from bgc.ir.causal import CausalGraph, Role
from bgc.ir.graph import Node


@dataclass(frozen=True, slots=True)
class Scales:
    """Scales by element port, and of momenta that one independent flow merges."""

    of_port: Mapping[int, Node]
    of_flow: Mapping[int, Node]


def state_scale(scales: Scales, state: IntegratedState, one: Node) -> Node:
    """The scale of a state that stores, of PARAM level; `one` where nothing certain is known."""
    if state.port is not None:
        return scales.of_port[state.port]
    return one if state.flow is None else scales.of_flow.get(state.flow, one)


def storage_scales(causal: CausalGraph, elements: Sequence[StorageElement]) -> Scales:
    """What the states of a graph are measured by."""
    dag = causal.graph.dag
    inertia: dict[int, Node] = {}  # independent flow -> the largest certain inertia on it
    scales: dict[int, Node] = {}
    merged: dict[int, Node] = {}  # independent flow -> the largest inertia on it by a fixed ratio
    for element in elements:
        for position, port in enumerate(element.ports):
            if port.port.role is Role.INERTIA:
                size = _inertia(dag, element, position)
                scales[port.index] = size or dag.one
                for k in port.flow:
                    if size is not None:
                        inertia[k] = dag.call(Op.MAX, inertia[k], size) if k in inertia else size
                _note_flows(dag, merged, port, size)
    for element in elements:
        for position, port in enumerate(element.ports):
            if port.port.role is Role.COMPLIANCE:
                scales[port.index] = _of_compliance(dag, element, position, port, inertia)
    return Scales(scales, merged)


def _note_flows(dag: Dag, merged: dict[int, Node], port: StoragePort, size: Node | None) -> None:
    """What an inertia adds to that of the independent flows that move it in a fixed ratio."""
    for k, ratio in port.flow.items():
        if size is not None and dag.level[ratio] <= Level.PARAM:
            added = dag.mul(dag.mul(ratio, ratio), size)
            merged[k] = dag.call(Op.MAX, merged[k], added) if k in merged else added


def _inertia(dag: Dag, element: StorageElement, position: int) -> Node | None:
    """What resists one flow while the others of the element are free; None if that varies."""
    own = _diagonal(dag, element, position, capacity=True)
    free = _diagonal(dag, element, position, capacity=False)
    if own is None or free is None or _is_alone(dag, element, position):
        return own
    return dag.div(dag.one, free)


def _is_alone(dag: Dag, element: StorageElement, position: int) -> bool:
    """Whether no other momentum of the element moves the flow of this one."""
    row = (element.law.capacity or ())[position]
    return all(entry == dag.zero for k, entry in enumerate(row) if k != position)


def _diagonal(dag: Dag, element: StorageElement, position: int, *, capacity: bool) -> Node | None:
    """An entry on the diagonal of the law's matrix; None if it is zero, varies, or is missing."""
    matrix = element.law.capacity if capacity else element.law.response
    if matrix is None:
        return None
    entry = matrix[position][position]
    return None if entry == dag.zero or dag.level[entry] > Level.PARAM else entry


def _of_compliance(
    dag: Dag,
    element: StorageElement,
    position: int,
    port: StoragePort,
    inertia: dict[int, Node],
) -> Node:
    stiffness = _diagonal(dag, element, position, capacity=False)
    if stiffness is None:
        return dag.one
    beside = [inertia[k] for k in port.flow if k in inertia]
    if not beside:
        scale = dag.div(dag.one, stiffness)
    else:
        smallest = beside[0]
        for other in beside[1:]:
            smallest = dag.call(Op.MIN, smallest, other)
        scale = dag.call(Op.SQRT, dag.div(smallest, stiffness))
    if dag.level[stiffness] == Level.CONST:
        return scale
    return dag.select(dag.call(Op.LT, dag.zero, stiffness), scale, dag.one)
