"""Check that storage has an energy, convex in the momenta, and not negative for linear fields."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.derivatives import gradient
from bgc.diagnostics.catalogue import physics as messages
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.ir.graph import EnergyLaw, ExplicitLaw, Form, LinearLaw, Matrix, Node, Storage
from bgc.passivity.definite import find_asymmetry, find_indefinite
from bgc.passivity.eigenvalue_text import pair_of, spectrum_of
from bgc.passivity.point import StartPoint

_VALUE = {
    Form.EFFORT: "stiffness",
    Form.DISPLACEMENT: "compliance",
    Form.MOMENTUM: "inertia",
    Form.FLOW: "inverse inertia",
}
# What the eigenvector of a matrix is made of: the law's right side.
_DIRECTION = {
    Form.EFFORT: "q",
    Form.DISPLACEMENT: "e",
    Form.MOMENTUM: "f",
    Form.FLOW: "p",
}


def check_storage(point: StartPoint, element: Storage) -> list[Diagnostic]:
    """Check a C, I or IC; at most one diagnostic."""
    match element.law:
        case LinearLaw():
            return _check_linear(point, element, element.law)
        case ExplicitLaw():
            return _check_explicit(point, element, element.law)
        case EnergyLaw():
            return _check_energy(point, element, element.law)


def _check_linear(point: StartPoint, element: Storage, law: LinearLaw) -> list[Diagnostic]:
    matrix = point.matrix(law.matrix)
    if matrix is None:
        return []
    when = point.phrase(node for row in law.matrix for node in row)
    uneven = find_asymmetry(matrix)
    if uneven is not None:
        place = (uneven.row, uneven.column)
        return [
            messages.not_symmetric(
                element.span, element.name, place, uneven.entry, uneven.mirror, when
            )
        ]
    bad = find_indefinite(matrix, strictly=element.kind == "I")
    if bad is None:
        return []
    if bad.direction.count(0.0) == len(matrix) - 1 and bad.pair is None:
        label = element.name
        if len(matrix) > 1:
            label += f" [{bad.direction.index(1.0) + 1}]"
        what = _VALUE[law.form]
        return [messages.negative_value(element.span, label, what, bad.eigenvalue, when)]
    spectrum = spectrum_of(bad, _DIRECTION[law.form])
    return [
        messages.indefinite_storage(
            element.span, element.name, element.kind, spectrum, pair_of(bad), when
        )
    ]


def _check_explicit(point: StartPoint, element: Storage, law: ExplicitLaw) -> list[Diagnostic]:
    """Check that slopes are symmetric, and positive for an I, at every trial point."""
    momentum = element.kind == "I"
    own = _own(element, Kind.MOMENTUM if momentum else Kind.DISPLACEMENT)
    if len(own) == 1 and not momentum:
        return []  # a spring may soften, snap through or hold in either way
    slopes = _derivatives(point.dag, law.nodes, own)
    return _check_slopes(point, element, slopes, own, momentum)


def _check_energy(point: StartPoint, element: Storage, law: EnergyLaw) -> list[Diagnostic]:
    """Check that the inverse inertia, the second derivative of H by the momenta, is positive."""
    if element.kind == "C":
        return []
    own = _own(element, Kind.MOMENTUM)
    dag = point.dag
    flows = gradient(dag, law.energy, [dag.symbol(s.kind, s.index) for s in own])
    return _check_slopes(point, element, _derivatives(dag, flows, own), own, True)


def _check_slopes(
    point: StartPoint,
    element: Storage,
    slopes: Matrix,
    own: Sequence[Symbol],
    momentum: bool,
) -> list[Diagnostic]:
    for state in point.states_near(own):
        matrix = point.matrix(slopes, state)
        if matrix is None or not all(math.isfinite(x) for row in matrix for x in row):
            continue
        where = _where(element, own, state)
        uneven = find_asymmetry(matrix)
        if uneven is not None:
            place = (uneven.row, uneven.column)
            return [
                messages.not_symmetric(
                    element.span, element.name, place, uneven.entry, uneven.mirror, f" {where}"
                )
            ]
        bad = find_indefinite(matrix) if momentum else None
        if bad is not None:
            what = f"d2H/dp2 has {spectrum_of(bad, 'p')}"
            if len(own) == 1:
                what = f"df/dp is {bad.eigenvalue:.6g}"
            return [messages.energy_not_convex(element.span, element.name, what, where)]
    return []


def _own(element: Storage, kind: Kind) -> list[Symbol]:
    return [Symbol(kind, element.first_state + k) for k in range(len(element.ports))]


def _derivatives(dag: Dag, nodes: Sequence[Node], own: Sequence[Symbol]) -> Matrix:
    symbols = [dag.symbol(symbol.kind, symbol.index) for symbol in own]
    return tuple(tuple(gradient(dag, node, symbols)) for node in nodes)


def _where(element: Storage, own: Sequence[Symbol], state: dict[Symbol, float]) -> str:
    if not state:
        return "at the start"
    letter = "p" if own[0].kind is Kind.MOMENTUM else "q"
    return f"at {messages.listed_direction(letter, [state[symbol] for symbol in own])}"
