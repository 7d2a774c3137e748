"""Parameters that alone are a resistance, stiffness or inertia, and must not be negative."""

from __future__ import annotations

from bgc.algebra.dag import Kind
from bgc.ir.graph import FlatGraph, Form, LinearLaw, Resistor, Storage

_RESISTANCE = {Form.EFFORT: "resistance", Form.FLOW: "conductance"}
_STORAGE = {
    Form.EFFORT: "stiffness",
    Form.DISPLACEMENT: "compliance",
    Form.MOMENTUM: "inertia",
    Form.FLOW: "inverse inertia",
}


def passive_coefficients(graph: FlatGraph) -> tuple[tuple[str, str, str], ...]:
    """List such parameters: the name, its meaning and its element.

    They are the diagonal entries of linear laws. A run checks the signs of values that are given
    to it, which the compiler has not seen.
    """
    names = {parameter.index: parameter.name for parameter in graph.parameters}
    found = []
    for element in graph.elements:
        match element:
            case Resistor(law=LinearLaw(form=form, matrix=matrix)):
                what = _RESISTANCE[form]
            case Storage(law=LinearLaw(form=form, matrix=matrix)):
                what = _STORAGE[form]
            case _:
                continue
        if not all(graph.bonds[port.bond].power for port in element.ports):
            continue
        for k, row in enumerate(matrix):
            symbol = graph.dag.symbol_of(row[k])
            if symbol is not None and symbol.kind is Kind.PARAM and symbol.index in names:
                label = f"{element.name} [{k + 1}]" if len(matrix) > 1 else element.name
                found.append((names[symbol.index], what, label))
    return tuple(found)
