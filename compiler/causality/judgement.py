"""Errors and warnings of causality: sources in conflict, redundant rows, chains without inertia."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from bgc.algebra.dag import Level
from bgc.causality.certificates import Certifier
from bgc.causality.paths import connections, holding, rigid_path
from bgc.causality.regions import Structure
from bgc.causality.working_rows import Elimination
from bgc.diagnostics.catalogue import causality as catalogue
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.ir.causal import Basis, BasisKind, BondClass, Closure, Role, Row
from bgc.ir.graph import FlatGraph, Gyrator, Node, Transformer

Flows = list[dict[int, Node]]
"""Of each class: index in the basis -> entry of N."""


def shared_flows(graph: FlatGraph, structure: Structure) -> list[Diagnostic]:
    """The errors for two flow sources on bonds that share one flow."""
    errors = []
    for members in structure.classes:
        sources = [k for k in members.ports if structure.ports[k].role is Role.FLOW_SOURCE]
        for k in sources[1:]:
            pair = [structure.ports[sources[0]].element, structure.ports[k].element]
            dual = structure.dual[members.bonds[0]]
            errors.append(_conflict(graph, pair, members.bonds, dual=dual))
    return errors


def effort_conflict(
    graph: FlatGraph,
    structure: Structure,
    number: int,
    elements: Sequence[int],
    through: Sequence[int],
) -> Diagnostic:
    """The error for an independent flow, in the classes `through`, with effort sources only."""
    dual = structure.dual[structure.classes[number].bonds[0]]
    bonds = {bond for n in through for bond in structure.classes[n].bonds}
    return _conflict(graph, elements, bonds, dual=not dual)


def _conflict(
    graph: FlatGraph, sources: Sequence[int], bonds: Collection[int], *, dual: bool
) -> Diagnostic:
    """The error for sources that set one variable, with the path between them along some bonds."""
    what = "effort" if dual else "flow"
    if len(sources) == 1:
        (source,) = connections(graph, sources)
        return catalogue.source_without_load(source.span, source.name, what)
    start, end = sorted(sources)[:2]
    first, second = connections(graph, (start, end))
    path = rigid_path(graph, start, end, bonds)
    return catalogue.causal_conflict(first, second, what, connections(graph, path))


def judge_remaining(
    graph: FlatGraph,
    structure: Structure,
    certifier: Certifier,
    elimination: Elimination,
    cut: Collection[int],
) -> tuple[list[Diagnostic], list[Closure], list[Diagnostic]]:
    """Warnings of redundant rows, those that close a chain, and errors for contradictory ones.

    The rows of junctions in `cut` close one in any case.
    """
    warnings, errors, closures = [], [], []
    for row, left in elimination.remaining:
        elements = sorted({elimination.rows[r].element for r in elimination.origins[row]})
        span = graph.elements[elimination.rows[row].element].span
        if elimination.rows[row].element in cut:
            closures.append(Closure(row, (elimination.rows[row].element,)))
            continue
        if not left:
            names = _names(graph, elements)
            warnings.append(catalogue.redundant_structure(span, names))
            continue
        sources = [_flow_source(structure, number) for number, _ in left]
        certain = all(certifier.certify(entry) is not None for _, entry in left)
        if certain and left and len(left) <= 2 and None not in sources:
            dual = structure.dual[elimination.rows[row].ends[0].bond]
            met = _bonds_of(structure, elimination, elimination.origins[row])
            errors.append(_conflict(graph, [s for s in sources if s is not None], met, dual=dual))
            continue
        moduli = _moduli(graph, elements)
        parametric = all(graph.dag.level[entry] <= Level.PARAM for _, entry in left)
        if parametric and moduli:
            element = graph.elements[moduli[0]]
            errors.append(catalogue.zero_modulus(element.span, element.name))
        else:
            closures.append(Closure(row, tuple(elements)))
    return warnings, closures, errors


def moves_inertias_only(
    structure: Structure, row: Row, basis: Sequence[Basis], flows: Flows
) -> bool:
    """Test whether the flows in a row are those of inertias and sources, none of them dual."""
    allowed = {BasisKind.INERTIA, BasisKind.FLOW_SOURCE}
    dual = any(structure.dual[end.bond] for end in row.ends)
    return not dual and all(basis[k].kind in allowed for k in _columns(structure, row, flows))


def _columns(structure: Structure, row: Row, flows: Flows) -> set[int]:
    """The independent flows that a row depends on."""
    return {k for end in row.ends for k in flows[structure.class_of[end.bond]]}


def without_inertia(
    structure: Structure, rows: Iterable[Row], basis: Sequence[Basis], flows: Flows
) -> frozenset[int]:
    """The classes of the independent flows in some rows that move no inertia."""
    taking_part = {k for row in rows for k in _columns(structure, row, flows)}
    given = {BasisKind.INERTIA, BasisKind.FLOW_SOURCE}
    return frozenset(basis[k].bond_class for k in taking_part if basis[k].kind not in given)


def without_any_inertia(
    graph: FlatGraph,
    structure: Structure,
    rows: Sequence[Row],
    closures: Sequence[Closure],
    basis: Sequence[Basis],
    flows: Flows,
) -> list[Diagnostic]:
    """The errors for closed chains that move something without inertia, or lie in a dual region."""
    errors = []
    for closure in closures:
        row = rows[closure.row]
        columns = _columns(structure, row, flows)
        moduli = _moduli(graph, closure.elements)
        met = {bond for k in columns for bond in structure.classes[basis[k].bond_class].bonds}
        others = [k for k in (*closure.elements, *holding(graph, met)) if k not in moduli]
        chain = connections(graph, moduli), connections(graph, others)
        errors.append(catalogue.rigid_chain(graph.elements[row.element].span, *chain))
    return errors


def _moduli(graph: FlatGraph, elements: Iterable[int]) -> list[int]:
    return [k for k in elements if isinstance(graph.elements[k], Transformer | Gyrator)]


def _bonds_of(structure: Structure, elimination: Elimination, rows: Iterable[int]) -> set[int]:
    """The bonds that share a variable with an end of some rows."""
    numbers = {structure.class_of[end.bond] for row in rows for end in elimination.rows[row].ends}
    return {bond for number in numbers for bond in structure.classes[number].bonds}


def _flow_source(structure: Structure, number: int) -> int | None:
    for k in structure.classes[number].ports:
        if structure.ports[k].role is Role.FLOW_SOURCE:
            return structure.ports[k].element
    return None


def _names(graph: FlatGraph, elements: Iterable[int]) -> list[str]:
    return list(dict.fromkeys(graph.elements[index].name for index in elements))


def warnings_of(graph: FlatGraph, structure: Structure, basis: Sequence[Basis]) -> list[Diagnostic]:
    """Warnings of bonds in a loop, and of flows that nothing determines."""
    warnings = [
        catalogue.bond_loop(graph.bonds[bond].span, graph.bonds[bond].name)
        for bond in structure.bond_loops
    ]
    for independent in basis:
        if independent.kind is BasisKind.INDETERMINATE:
            members: BondClass = structure.classes[independent.bond_class]
            bond = graph.bonds[members.bonds[0]]
            what = "effort" if structure.dual[bond.index] else "flow"
            warnings.append(catalogue.indeterminate(bond.span, bond.name, what))
    return warnings
