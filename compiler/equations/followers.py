"""Sources that follow their own reaction: resistances, written as sources.

`MSf(f = g*(a - node.e))` on a rigid mass gives the flow that `R { f = g*(a - e); }` would give. As
a source it leaves the mass without a state, and its value then depends on the rate of the momentum
that it gives (BG521). As a resistance it leaves the mass its state, and the value is solved for
the effort. Such a source is taken as a resistance where it cannot be taken as a source: so the
equations of all other models stay as they are.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.disjoint_sets import DisjointSets
from bgc.causality.assign import assign_causality
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.derive import derive_equations
from bgc.equations.variables.names import RateInLoop
from bgc.ir.causal import CausalGraph, Role
from bgc.ir.graph import FlatGraph, Junction, Source
from bgc.ir.program import Program


def causality_and_equations(graph: FlatGraph) -> tuple[CausalGraph, Program | None]:
    """Assign causality, with sources that follow their own reaction as resistances where needed.

    The program is None unless the equations had to be derived to decide.

    Raises
    ------
    BgError
        As `assign_causality` does. Errors in the equations are left to the caller, who derives
        them again.
    """
    own = _reading_their_own_bond(graph)
    refused: BgError | None = None
    while True:
        try:
            causal = assign_causality(graph)
        except BgError as err:
            refused = refused or err
            if not own:
                raise refused from None
            graph, own = _with_followers(graph, own), frozenset()
            continue
        if not refused and not _may_follow(causal):
            return causal, None
        try:
            return causal, derive_equations(causal)
        except RateInLoop as err:
            if not err.sources:
                return causal, None
            refused = err
            own -= err.sources
            graph = _with_followers(graph, err.sources)
        except BgError:
            return causal, None


def _with_followers(graph: FlatGraph, sources: Collection[int]) -> FlatGraph:
    elements = tuple(
        replace(element, follows=True) if k in sources and isinstance(element, Source) else element
        for k, element in enumerate(graph.elements)
    )
    return replace(graph, elements=elements)


def _reading_their_own_bond(graph: FlatGraph) -> frozenset[int]:
    """The sources whose value depends on the other variable of their own bond.

    The effort of a bond is that of all bonds joined to it by 0-junctions, its flow that of all
    joined by 1-junctions.
    """
    found = set()
    joined = {kind: _joined(graph, kind) for kind in ("J0", "J1")}
    for index, element in enumerate(graph.elements):
        if isinstance(element, Source):
            kind, what = ("J0", Kind.EFFORT) if element.kind == "Sf" else ("J1", Kind.FLOW)
            alike = joined[kind]
            own = alike.find(element.port.bond)
            if any(alike.find(bond) == own for bond in _read(graph.dag, element, what)):
                found.add(index)
    return frozenset(found)


def _joined(graph: FlatGraph, kind: str) -> DisjointSets:
    """The bonds that share an effort (J0) or a flow (J1)."""
    sets = DisjointSets(len(graph.bonds))
    for element in graph.elements:
        if isinstance(element, Junction) and element.kind == kind:
            sets.join(port.bond for port in element.ports)
    return sets


def _read(dag: Dag, source: Source, kind: Kind) -> set[int]:
    """The bonds whose effort or flow the value of a source holds."""
    if dag.level[source.value] < Level.STATE:
        return set()
    symbols = map(dag.symbol_of, dag.reachable([source.value]))
    return {s.index for s in symbols if s is not None and s.kind is kind}


def _may_follow(causal: CausalGraph) -> bool:
    """Return whether a source of a through variable depends on any across variable."""
    graph = causal.graph
    for port in causal.ports:
        source = graph.elements[port.element]
        if port.role is Role.FLOW_SOURCE and isinstance(source, Source):
            across = Kind.FLOW if port.dual else Kind.EFFORT
            if _read(graph.dag, source, across):
                return True
    return False
