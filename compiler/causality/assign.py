"""Assign causality: from the flat graph to its independent flows, strokes and reasons.

The algorithm is certified elimination. Regions are dualised so that gyrators become transformers
(`regions`), the rows are solved without dividing by anything that may vanish (`elimination`), and
the element that determines each independent flow follows from the result. A graph without such an
assignment is refused with the elements at fault.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.modular import rank_of
from bgc.causality.certificates import Certifier
from bgc.causality.elimination import eliminate
from bgc.causality.judgement import (
    Flows,
    effort_conflict,
    judge_remaining,
    moves_inertias_only,
    shared_flows,
    warnings_of,
    without_any_inertia,
    without_inertia,
)
from bgc.causality.regions import Structure, junction_structure
from bgc.causality.sequence import sequence_rows
from bgc.causality.strokes import place_strokes
from bgc.causality.working_rows import Elimination
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Refused
from bgc.ir.causal import (
    Basis,
    BasisKind,
    CausalGraph,
    Closure,
    ElementPort,
    Role,
    Row,
    Step,
)
from bgc.ir.graph import FlatGraph, Junction, Node, Source
from bgc.ir.program import PositiveParameter
from bgc.record_class import dataclass, replace

_ROUNDING = 1e-6  # of the largest coefficient of a row: less is zero, but for data in seven digits


@dataclass(frozen=True, slots=True)
class _Way:
    """A way to take the rows of a graph.

    The rows of the junctions `cut` close chains. The classes `carrying` stay independent where
    possible, and those in `following` follow from the rows that close chains
    (`elimination.eliminate`). With `whole`, transformers and gyrators are solved whole, one after
    the other. With `ranged`, moduli that vary within a range without zero are
    divisors too, where no other is left. The junctions `weak` are cut if what rounded data leave of
    zero would be a divisor otherwise.
    """

    cut: frozenset[int] = frozenset()
    weak: frozenset[int] = frozenset()
    carrying: frozenset[int] = frozenset()
    following: frozenset[int] = frozenset()
    ranged: bool = False
    whole: bool = False


def assign(
    graph: FlatGraph, *, ranged: bool = False, opened: bool = False, whole: bool = False
) -> CausalGraph | Refused:
    """Find the independent flows of a graph and everything that follows from them.

    Guarantees that N satisfies every row (proven at random points), and that every divisor is a
    nonzero number or a parameter listed in `positive`. Does not derive equations, and does not use
    the laws of elements. With `ranged`, moduli that vary within a range without zero are divisors
    too, where no other is left. With `whole`, transformers and gyrators are solved whole, one after
    the other. With `opened`, the rows of the parts that close chains (`Weld`) are left out of the
    elimination, so that the coordinates of an open tree are independent; without it that is done
    where the graph is refused otherwise. A graph is refused if sources contradict
    each other, or if rigid connections form a closed chain.
    """
    cut, way = _closing_junctions(graph), _Way(ranged=ranged, whole=whole)
    if not (opened and cut):
        found = _assigned(graph, replace(way, weak=cut))
        if isinstance(found, CausalGraph):
            return found if ranged or whole else _sparing(graph, found)
        if not cut:
            return found
    return _assigned(graph, replace(way, cut=cut))


def may_be_opened(causal: CausalGraph) -> bool:
    """Test whether `opened` may give another assignment of a graph."""
    return bool(causal.closures) and not causal.opened and bool(_closing_junctions(causal.graph))


def _sparing(graph: FlatGraph, found: CausalGraph) -> CausalGraph:
    """The same graph with fewer independent flows that move inertias, if some are too many.

    Where a modulus may vanish, the inertia behind it depends on the flow before it, and that flow,
    which powers no element, on the flows of the elements beside it. All of those would then move
    the inertia, and all but one move no inertia. So one of them becomes dependent in its place.
    """
    surplus = _surplus(found)
    if not surplus or found.closures:
        return found
    certifier = Certifier(graph.dag, found.fingerprints, graph.parameters)
    carrying = frozenset(
        found.class_of[end.bond]
        for row in found.rows
        for end in row.ends
        if certifier.may_vanish(end.coefficient)
    )
    other = _assigned(graph, _Way(carrying=carrying))
    if isinstance(other, CausalGraph) and _surplus(other) < surplus:
        return other
    return found


def _surplus(causal: CausalGraph) -> int:
    """The number of independent flows of inertias, less those that the inertias determine."""
    columns = {k for k, basis in enumerate(causal.basis) if basis.kind is BasisKind.INERTIA}
    residue = causal.fingerprints.residue
    moved = [
        {k: residue(node) for k, node in causal.flows[number] if k in columns}
        for number, members in enumerate(causal.classes)
        if any(causal.ports[k].role is Role.INERTIA for k in members.ports)
    ]
    return len(columns) - rank_of(moved)


def _closing_junctions(graph: FlatGraph) -> frozenset[int]:
    """The junctions of the parts that hold a condition: a chain may be cut there.

    Which of the rows around a chain closes it does not matter to the motion; that the chain,
    cut there, is solved by certified pivots does.
    """
    parts = {c.name.rpartition(".")[0] for c in graph.conditions} - {""}
    return frozenset(
        index
        for index, element in enumerate(graph.elements)
        if isinstance(element, Junction) and element.name.rpartition(".")[0] in parts
    )


def _assigned(graph: FlatGraph, way: _Way) -> CausalGraph | Refused:
    """Assign causality in one way."""
    fingerprints = Fingerprints(graph.dag)
    structure = junction_structure(graph, way.cut)
    certifier = Certifier(graph.dag, fingerprints, graph.parameters, ranged=way.ranged)
    errors = shared_flows(graph, structure)
    if errors:
        return Refused(BgError(errors))
    elimination = eliminate(
        graph.dag,
        fingerprints,
        certifier,
        structure,
        way.carrying,
        way.following,
        whole=way.whole,
    )
    if way.weak and elimination.unsolved and elimination.weakest < _ROUNDING:
        return _assigned(graph, replace(way, cut=way.weak, weak=frozenset()))
    warnings, closures, errors = judge_remaining(graph, structure, certifier, elimination, way.cut)
    if errors:
        return Refused(BgError(errors))
    steps, watched = sequence_rows(
        graph.dag,
        fingerprints,
        certifier,
        structure.class_of,
        elimination.rows,
        elimination.steps,
    )
    independent, flows = _back_substitute(graph.dag, structure, steps)
    late = () if way.following else structure.closing
    rows = (*elimination.rows, *late)
    closing = {closure.row for closure in closures}
    _verify(fingerprints, graph.dag, structure, elimination.rows, flows, closing)
    basis, errors = _basis(graph, structure, independent, flows)
    errors = errors or _hidden_conflict(graph, structure, fingerprints, basis, flows)
    if errors:
        return Refused(BgError(errors))
    closures += [
        Closure(number, (row.element,)) for number, row in enumerate(late, len(elimination.rows))
    ]
    still = [c for c in closures if not moves_inertias_only(structure, rows[c.row], basis, flows)]
    if still and way.cut and not way.following:
        following = without_inertia(structure, [rows[c.row] for c in still], basis, flows)
        return _assigned(graph, replace(way, following=following))
    errors = without_any_inertia(graph, structure, rows, still, basis, flows)
    if errors:
        return Refused(BgError(errors))
    warnings += warnings_of(graph, structure, basis)
    return CausalGraph(
        graph=graph,
        fingerprints=fingerprints,
        dual=structure.dual,
        ports=structure.ports,
        classes=structure.classes,
        class_of=structure.class_of,
        rows=rows,
        steps=steps,
        redundant=frozenset(
            origin
            for row, left in elimination.remaining
            if not left and elimination.rows[row].element not in way.cut
            for origin in elimination.origins[row]
        ),
        closures=tuple(closures),
        cut=way.cut,
        basis=basis,
        flows=tuple(tuple(entries.items()) for entries in flows),
        strokes=place_strokes(
            graph,
            structure.dual,
            structure.ports,
            structure.classes,
            structure.class_of,
            elimination.rows,
            elimination.steps,
            basis,
            way.cut,
        ),
        positive=_positive(graph, certifier, elimination, watched),
        warnings=tuple(warnings),
        ranged=way.ranged,
        opened=bool(way.cut),
    )


# --- independent flows ------------------------------------------------------------------------


def _back_substitute(
    dag: Dag, structure: Structure, steps: Sequence[Step]
) -> tuple[list[int], Flows]:
    """The independent classes, and the sparse row of N of every class."""
    dependent = {step.dependent for step in steps}
    independent = [c for c in range(len(structure.classes)) if c not in dependent]
    flows: Flows = [{} for _ in structure.classes]
    for k, number in enumerate(independent):
        flows[number] = {k: dag.one}
    for step in reversed(steps):
        pivot = next(entry for number, entry in step.working if number == step.dependent)
        row: dict[int, Node] = {}
        for number, entry in step.working:
            if number != step.dependent:
                weight = dag.neg(dag.div(entry, pivot))
                for k, node in flows[number].items():
                    row[k] = dag.add(row.get(k, dag.zero), dag.mul(weight, node))
        flows[step.dependent] = row
    return independent, flows


def _verify(
    fingerprints: Fingerprints,
    dag: Dag,
    structure: Structure,
    rows: Sequence[Row],
    flows: Flows,
    closing: Collection[int],
) -> None:
    """Check every raw row but the closing ones against N; drop entries of N that are zero."""
    for entries in flows:
        for k in [k for k, node in entries.items() if fingerprints.is_zero(node)]:
            del entries[k]
    for number, row in enumerate(rows):
        if number in closing:
            continue
        residual: dict[int, Node] = {}
        for end in row.ends:
            for k, node in flows[structure.class_of[end.bond]].items():
                term = dag.mul(end.coefficient, node)
                residual[k] = dag.add(residual.get(k, dag.zero), term)
        assert all(fingerprints.is_zero(node) for node in residual.values()), (
            f"the flows do not satisfy the rows of element {row.element}"
        )


def _basis(
    graph: FlatGraph, structure: Structure, independent: Sequence[int], flows: Flows
) -> tuple[tuple[Basis, ...], list[Diagnostic]]:
    """Decide what determines each independent flow, by the elements that it powers.

    Where these are sources only, there is an error for each.
    """
    found: list[set[tuple[int, Role]]] = [set() for _ in independent]  # element, role
    for number, members in enumerate(structure.classes):
        for k in members.ports:
            port = structure.ports[k]
            held = columns_in_value(graph, structure, port, flows)
            for column in flows[number]:
                role = Role.RESISTANCE if column in held else port.role
                found[column].add((port.element, role))
    errors: list[Diagnostic] = []
    basis: list[Basis] = []
    for number, elements in zip(independent, found, strict=True):
        own = {structure.ports[k].role for k in structure.classes[number].ports}
        roles = {role for _, role in elements}
        if Role.FLOW_SOURCE in own:
            kind = BasisKind.FLOW_SOURCE
        elif Role.INERTIA in roles:
            kind = BasisKind.INERTIA
        elif Role.RESISTANCE in roles:
            kind = BasisKind.RESISTANCE
        elif Role.COMPLIANCE in roles:
            kind = BasisKind.COMPLIANCE
        else:
            kind = BasisKind.INDETERMINATE
            if elements:
                column = len(basis)
                through = [n for n, entries in enumerate(flows) if column in entries]
                sources = sorted({element for element, _ in elements})
                errors.append(effort_conflict(graph, structure, number, sources, through))
        basis.append(Basis(number, kind))
    return tuple(basis), errors


def _hidden_conflict(
    graph: FlatGraph,
    structure: Structure,
    fingerprints: Fingerprints,
    basis: Sequence[Basis],
    flows: Flows,
) -> list[Diagnostic]:
    """The error for a motion that powers effort sources only, if several flows make it up.

    Where a modulus may vanish, the flow behind it is no pivot: two sources on one junction then
    have a flow each, both of which reach other elements through that modulus.
    """
    sources: dict[int, list[dict[int, int]]] = {}  # element -> its flows
    others: list[dict[int, int]] = []
    for number, members in enumerate(structure.classes):
        row = {k: fingerprints.residue(node) for k, node in flows[number].items()}
        ports = [structure.ports[k] for k in members.ports]
        setting = [
            port.element
            for port in ports
            if port.role is Role.EFFORT_SOURCE
            and not columns_in_value(graph, structure, port, flows)
        ]
        for element in setting:
            sources.setdefault(element, []).append(row)
        if len(setting) < len(ports):
            others.append(row)
    moving = sum(independent.kind is not BasisKind.INDETERMINATE for independent in basis)
    rank = rank_of(others)
    if rank == moving:
        return []
    free = {e: rows for e, rows in sources.items() if rank_of([*others, *rows]) > rank}
    if not free:
        return []  # the motion powers no element at all
    columns = {k for rows in free.values() for row in rows for k in row}
    through = [n for n, entries in enumerate(flows) if not columns.isdisjoint(entries)]
    return [effort_conflict(graph, structure, through[0], list(free), through)]


def columns_in_value(
    graph: FlatGraph, of: Structure | CausalGraph, port: ElementPort, flows: Flows
) -> set[int]:
    """The independent flows in the value of an effort source, which is a resistance to them."""
    source = graph.elements[port.element]
    if port.role is not Role.EFFORT_SOURCE or not isinstance(source, Source):
        return set()
    read = graph.dag.symbols_in([source.value], Kind.EFFORT, Kind.FLOW).values()
    through = (s.index for s in read if (s.kind is Kind.EFFORT) == of.dual[s.index])
    return {k for bond in through for k in flows[of.class_of[bond]]}


def _positive(
    graph: FlatGraph,
    certifier: Certifier,
    elimination: Elimination,
    watched: Sequence[tuple[Node, int]],
) -> tuple[PositiveParameter, ...]:
    """The parameters that were divided by, each listed once."""
    found: dict[Node, PositiveParameter] = {}
    for node, row in (*elimination.watched, *watched):
        name = graph.elements[elimination.rows[row].element].name
        message = f"the modulus of `{name}` must not be zero"
        found.setdefault(node, certifier.check(node, message))
    return tuple(found.values())
