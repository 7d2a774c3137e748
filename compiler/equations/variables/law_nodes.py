"""The laws of storage elements and resistors as nodes, in each element's own sense.

The *answer* of a storage port is the variable its law gives: the effort of a C, the flow of an
I, in terms of the element's charges and momenta. An IC answers with `f = dH/dp` where its energy
holds the port's momentum, and `dH/dq` is then an effort on top of `p'`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.derivatives import gradient
from bgc.algebra.linalg import SingularMatrixError, apply, inverse, transpose
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.fields import nodes_of
from bgc.ir.graph import (
    EnergyLaw,
    ExplicitLaw,
    Form,
    Gyrator,
    Gyristor,
    LinearLaw,
    Matrix,
    Node,
    Port,
    Resistor,
    Source,
    Storage,
)
from bgc.ir.program import PositiveParameter
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class StorageLaw:
    """The answer of a storage element at each port, as a function of its state.

    `states` are the symbols of the charges (C) or momenta (I) that the answers belong to;
    `answers` the nodes in them; `bias` the effort beside the momentum's rate (IC, else zero);
    `charges` the symbols of the charges beside them (IC, else None).
    `response` (answer = response * state) and `capacity` (state = capacity * answer) are the
    matrices of a linear law, each None where it is not linear or has no such form. Those of an
    IC may vary with its charges; one with inertias and compliances has a capacity of the
    inertias alone, whose other rows are zero.
    """

    states: tuple[Node, ...]
    answers: tuple[Node, ...]
    bias: tuple[Node, ...]
    charges: tuple[Node | None, ...]
    response: Matrix | None
    capacity: Matrix | None


def storage_law(
    dag: Dag,
    storage: Storage,
    has_momentum: Sequence[bool],
    inertial: Sequence[bool],
    even: Matrix | None,
) -> StorageLaw:
    """The law of a C, I or IC. `has_momentum` lists the ports that answer with a flow,
    `inertial` those that are inertias in the terms of their region. `even`, if given, is inverted
    in place of the matrix of a linear law, from which it differs by rounding only.

    Raises
    ------
    BgError
        The law holds a variable that is not the element's own, or cannot be inverted.
    """
    indices = range(storage.first_state, storage.first_state + len(storage.ports))
    charges = [dag.symbol(Kind.DISPLACEMENT, k) for k in indices]
    momenta = [dag.symbol(Kind.MOMENTUM, k) for k in indices]
    states = tuple(
        p if momentum else q for q, p, momentum in zip(charges, momenta, has_momentum, strict=True)
    )
    _refuse_foreign(dag, storage, {*charges, *momenta})
    nothing = (dag.zero,) * len(states)
    plain = (None,) * len(states)
    match storage.law:
        case LinearLaw(form=form, matrix=matrix):
            if form in {Form.DISPLACEMENT, Form.MOMENTUM}:
                response = _inverted(dag, storage, even or matrix)
                answers = apply(dag, response, states)
                return StorageLaw(states, answers, nothing, plain, response, matrix)
            answers = apply(dag, matrix, states)
            capacity = _inverse_if_any(dag, matrix)
            return StorageLaw(states, answers, nothing, plain, matrix, capacity)
        case ExplicitLaw(nodes=nodes):
            return StorageLaw(states, nodes, nothing, plain, None, None)
        case EnergyLaw(energy=energy):
            answers = tuple(gradient(dag, energy, states))
            matrices = _matrices_of_energy(dag, answers, states, inertial)
            if storage.kind != "IC":
                return StorageLaw(states, answers, nothing, plain, *matrices)
            slopes = gradient(dag, energy, charges)
            bias = tuple(
                slope if momentum else dag.zero
                for slope, momentum in zip(slopes, has_momentum, strict=True)
            )
            own = tuple(
                q if momentum else None for q, momentum in zip(charges, has_momentum, strict=True)
            )
            return StorageLaw(states, answers, bias, own, *matrices)


def _matrices_of_energy(
    dag: Dag, answers: Sequence[Node], states: Sequence[Node], inertial: Sequence[bool]
) -> tuple[Matrix | None, Matrix | None]:
    """Response and capacity, where the energy is quadratic in what the answers belong to."""
    if len(set(inertial)) > 1:
        return None, _capacity_of_inertias(dag, answers, states, inertial)
    response = _quadratic(dag, answers, states)
    return response, None if response is None else _inverse_if_any(dag, response)


def _quadratic(dag: Dag, answers: Sequence[Node], states: Sequence[Node]) -> Matrix | None:
    """The matrix of answers that are linear in the states (an IC's may vary with its charges)."""
    response = tuple(tuple(gradient(dag, answer, states)) for answer in answers)
    held = set(dag.reachable([node for row in response for node in row]))
    if not held.isdisjoint(states):
        return None
    rest = dag.substitute(answers, dict.fromkeys(states, dag.zero))
    return response if all(node == dag.zero for node in rest) else None


def _capacity_of_inertias(
    dag: Dag, answers: Sequence[Node], states: Sequence[Node], inertial: Sequence[bool]
) -> Matrix | None:
    """The capacity of the inertial ports of an IC, zero elsewhere."""
    places = [k for k, chosen in enumerate(inertial) if chosen]
    response = _quadratic(dag, [answers[k] for k in places], [states[k] for k in places])
    inner = None if response is None else _inverse_if_any(dag, response)
    if inner is None:
        return None
    whole = [[dag.zero] * len(states) for _ in states]
    for i, row in zip(places, inner, strict=True):
        for j, node in zip(places, row, strict=True):
            whole[i][j] = node
    return tuple(map(tuple, whole))


def _refuse_foreign(dag: Dag, storage: Storage, own: set[Node]) -> None:
    for node, symbol in dag.symbols_in(nodes_of(storage.law)).items():
        if dag.level[node] > Level.PARAM and node not in own:
            what = _in_words(symbol.kind)
            raise BgError([storage_messages.variable_storage(storage.span, storage.name, what)])


def _in_words(kind: Kind) -> str:
    words = {
        Kind.TIME: "time",
        Kind.INPUT: "a device's input or a sampled value",
        Kind.STATE: "a declared state",
        Kind.EFFORT: "an effort",
        Kind.FLOW: "a flow",
        Kind.DISPLACEMENT: "another element's charge",
        Kind.MOMENTUM: "another element's momentum",
    }
    return words.get(kind, "an unknown")


def _inverted(dag: Dag, storage: Storage, matrix: Matrix) -> Matrix:
    what = "inertia" if storage.kind == "I" else "compliance"
    value = dag.value(matrix[0][0])
    if len(matrix) == 1 and value is not None and value <= 0:
        raise BgError([storage_messages.storage_not_positive(storage.span, storage.name, what)])
    try:
        return inverse(dag, matrix)
    except SingularMatrixError:
        diagnostic = storage_messages.storage_not_positive(storage.span, storage.name, what)
        raise BgError([diagnostic]) from None


def _inverse_if_any(dag: Dag, matrix: Matrix) -> Matrix | None:
    try:
        return inverse(dag, matrix)
    except SingularMatrixError:
        return None


def positive_values(dag: Dag, storage: Storage) -> tuple[PositiveParameter, ...]:
    """The parameters that must stay positive because a law divides by them."""
    law = storage.law
    if not isinstance(law, LinearLaw) or law.form in {Form.EFFORT, Form.FLOW}:
        return ()
    what = "inertia" if storage.kind == "I" else "compliance"
    names = (
        [storage.name]
        if len(law.matrix) == 1
        else [f"{storage.name}[{k + 1}]" for k in range(len(law.matrix))]
    )
    return tuple(
        PositiveParameter(
            row[k], f"the {what} of `{names[k]}` must be positive", strictly_positive=True
        )
        for k, row in enumerate(law.matrix)
        if dag.level[row[k]] == Level.PARAM
    )


def resistor_law(dag: Dag, resistor: Resistor) -> tuple[Form, tuple[Node, ...]]:
    """The law of an R as one node a port, for efforts or flows in the element's own sense."""
    ports, law = resistor.ports, resistor.law
    given = Kind.FLOW if law.form is Form.EFFORT else Kind.EFFORT
    match law:
        case LinearLaw(matrix=matrix):
            variables = [_own(dag, given, port) for port in ports]
            return law.form, apply(dag, matrix, variables)
        case ExplicitLaw(nodes=nodes):
            return law.form, tuple(in_own_sense(dag, nodes, ports))


def following_law(dag: Dag, source: Source) -> tuple[Form, tuple[Node, ...]]:
    """The law of a source that follows its own bond, in the element's own sense."""
    form = Form.EFFORT if source.kind == "Se" else Form.FLOW
    turned = form is Form.FLOW and source.port.sign < 0
    return form, (dag.neg(source.value) if turned else source.value,)


def gyristor_law(dag: Dag, gyristor: Gyristor) -> tuple[Node, ...]:
    """The efforts of a one-sided gyrator (eq. 13 of the paper) from its own flows."""
    flows = [_own(dag, Kind.FLOW, port) for port in gyristor.ports]
    return apply(dag, gyristor.matrix, flows)


def gyrator_law(dag: Dag, gyrator: Gyrator) -> tuple[Node, ...]:
    """The efforts of a gyrator's ports 1, then 2, from the flows of the other side."""
    flows1 = [dag.symbol(Kind.FLOW, port.bond) for port in gyrator.ports1]
    flows2 = [dag.symbol(Kind.FLOW, port.bond) for port in gyrator.ports2]
    back = apply(dag, transpose(gyrator.matrix), flows2)
    return (*back, *apply(dag, gyrator.matrix, flows1))


def gyrator_matrix(dag: Dag, gyrator: Gyrator) -> Matrix:
    """The skew matrix from a gyrator's own flows, of ports 1, then 2, to its efforts."""
    ports = (*gyrator.ports1, *gyrator.ports2)
    first = len(gyrator.ports1)

    def entry(i: int, j: int) -> Node:
        if (i < first) == (j < first):
            return dag.zero
        node = gyrator.matrix[j - first][i] if i < first else gyrator.matrix[i - first][j]
        return node if ports[j].sign > 0 else dag.neg(node)

    return tuple(tuple(entry(i, j) for j in range(len(ports))) for i in range(len(ports)))


def _own(dag: Dag, kind: Kind, port: Port) -> Node:
    """An effort or flow in the sense of power into the element."""
    symbol = dag.symbol(kind, port.bond)
    return dag.neg(symbol) if kind is Kind.FLOW and port.sign < 0 else symbol


def in_own_sense(dag: Dag, nodes: Iterable[Node], ports: Iterable[Port]) -> list[Node]:
    """Nodes that mean the element's own flows, in terms of its bonds' flows."""
    turned = {
        dag.symbol(Kind.FLOW, p.bond): dag.neg(dag.symbol(Kind.FLOW, p.bond))
        for p in ports
        if p.sign < 0
    }
    return dag.substitute(nodes, turned) if turned else list(nodes)
