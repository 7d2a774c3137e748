"""Whether the laws of a flat graph are those of passive parts: symmetric, positive, no free power.

Looked at are storage and resistors. Junctions, transformers and gyrators keep power by how they
are read: one equation is given and its dual derived. A gyristor's matrix is checked to be skew
where its law is read, as without that the element would not be what it says.

Sources: Karnopp, Margolis and Rosenberg, System Dynamics, on multiport fields (Maxwell
reciprocity, positive definite storage, passive resistors).
"""

from __future__ import annotations

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.report import Report
from bgc.ir.graph import FlatGraph, Resistor, Storage
from bgc.passivity.point import StartPoint
from bgc.passivity.resistors import check_resistor
from bgc.passivity.storage import check_storage


def check_physics(graph: FlatGraph) -> tuple[Diagnostic, ...]:
    """Warn of what no passive part does, with the numbers, at most once for each element.

    Constant and parameter matrices are looked at with the parameters at their values. Laws that
    vary are looked at where the run starts; nonlinear laws of one's own variables also at other
    values of these, as they must hold for all. Elements of pseudo domains are left out: their
    effort times flow is no power.

    Of this only the signs of single parameters are looked at again when a run changes them
    (`coefficients`): a range (`in 0 .. 10`) is what guards a parameter there.
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
