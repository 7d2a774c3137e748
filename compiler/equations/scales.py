"""The scale of each state: the unit of its absolute tolerance.

The scale of a momentum is the one that changes its own flow by one unit. For a single inertia that
is its momentum at unit flow. For momenta coupled by a matrix M it is 1/(M^-1)_ii, which, unlike
M_ii, does not grow with the lever from a body's frame to its centre of mass. The scale of a charge
gives the compliance as much energy as the inertias beside it have at unit flow, `sqrt(m / k)`: the
oscillation of a stiff spring is then resolved as finely as the momentum that takes part in it.
Without an inertia beside it, a compliance has its charge at unit effort as its scale. A merged
momentum has the scale of the largest inertia that its flow moves in a fixed ratio. All other states
have their own unit. Where no state comes near its scale, as in a circuit of microamperes, step
control reduces all scales by the same factor (`runtime/c/tolerance.h`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.algebra.dag import Dag, Level, Op
from bgc.equations.storage.kinds import IntegratedState, StorageElement, StoragePort
from bgc.ir.causal import CausalGraph, Role
from bgc.ir.graph import Form, LinearLaw, Node
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Scales:
    """Scales by element port, and of momenta that one independent flow merges."""

    of_port: Mapping[int, Node]
    of_flow: Mapping[int, Node]


def state_scale(scales: Scales, state: IntegratedState, one: Node) -> Node:
    """The scale of a storage state, of PARAM level; `one` where no certain scale is known."""
    if state.port is not None:
        return scales.of_port[state.port]
    return one if state.flow is None else scales.of_flow.get(state.flow, one)


def storage_scales(causal: CausalGraph, elements: Sequence[StorageElement]) -> Scales:
    """Find the scales of all storage states of a graph."""
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
    """Note an inertia at the independent flows that move it in a fixed ratio."""
    for k, ratio in port.flow.items():
        if size is not None and dag.level[ratio] <= Level.PARAM:
            added = dag.mul(dag.mul(ratio, ratio), size)
            merged[k] = dag.call(Op.MAX, merged[k], added) if k in merged else added


def _inertia(dag: Dag, element: StorageElement, position: int) -> Node | None:
    """The inertia against one flow while the element's others are free; None if it varies."""
    own = _diagonal(dag, element, position, capacity=True)
    free = _diagonal(dag, element, position, capacity=False)
    if own is not None:
        own = _magnitude(dag, own)
    if own is None or free is None:
        return own
    free = _magnitude(dag, free)
    size = own if _is_alone(dag, element, position) else dag.div(dag.one, free)
    law = element.storage.law
    given = isinstance(law, LinearLaw) and law.form is Form.MOMENTUM
    if given or dag.level[free] == Level.CONST:
        return size
    return dag.select(dag.call(Op.LT, dag.zero, free), size, dag.one)


def _is_alone(dag: Dag, element: StorageElement, position: int) -> bool:
    """Return whether no other momentum of the element moves the flow of this one."""
    row = (element.law.capacity or ())[position]
    return all(entry == dag.zero for k, entry in enumerate(row) if k != position)


def _magnitude(dag: Dag, size: Node) -> Node:
    """The magnitude of a known stiffness or inertia, which may be negative; others as they are."""
    value = dag.value(size)
    return dag.const(-value) if value is not None and value < 0 else size


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
    stiffness = _magnitude(dag, stiffness)
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
