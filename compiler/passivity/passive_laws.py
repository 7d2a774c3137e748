"""Check that the laws of a flat graph are passive: symmetric, positive, without free power.

The checks cover storage and resistors. Junctions, transformers and gyrators conserve power by
construction: one equation is given and its dual derived. A gyristor's matrix is checked for skew
symmetry where its law is read.

Sources: Karnopp, Margolis and Rosenberg, System Dynamics, on multiport fields (Maxwell
reciprocity, positive definite storage, passive resistors).
"""

from __future__ import annotations

from bgc.diagnostics.collection import Report
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.ir.graph import FlatGraph, Resistor, Storage
from bgc.passivity.point import StartPoint
from bgc.passivity.resistors import check_resistor
from bgc.passivity.storage_energy import check_storage


def check_physics(graph: FlatGraph) -> tuple[Diagnostic, ...]:
    """Warn of laws that no passive part has, at most once for each element.

    Constant and parameter matrices are evaluated at the parameters' values, varying laws at the
    start of the run. Nonlinear laws in the element's own variables are also evaluated at other
    values of these, since they must be passive everywhere. Elements of pseudo domains are
    skipped, because their effort times flow is not a power.

    When a run changes parameters, only the signs of single parameters are checked again
    (`coefficients`); a declared range (`in 0 .. 10`) guards the others.
    """
    point, report = StartPoint(graph), Report()
    for element in graph.elements:
        match element:
            case Storage() if _carries_power(graph, element):
                report.add(*check_storage(point, element))
            case Resistor() if _carries_power(graph, element):
                report.add(*check_resistor(graph, point, element))
            case _:
                pass
    return report.warnings


def _carries_power(graph: FlatGraph, element: Storage | Resistor) -> bool:
    return all(graph.bonds[port.bond].power for port in element.ports)
