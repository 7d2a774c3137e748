"""Retry causality with other choices where the plain one is refused.

Sources that follow their own reaction are resistances, written as sources. On a rigid mass,
`MSf(f = g*(a - node.e))` gives the flow that `R { f = g*(a - e); }` would give. As a source it
leaves the mass without a state, and its value then depends on the rate of the momentum that it
gives (BG521). As a resistance it leaves the mass its state, and the value is solved for the effort.

Moduli that vary within a range without zero (`2 + sin(angle)`) are divisors where no other is left.

Both are tried where the plain choice fails, so that the equations of all other models stay as
they are. If these fail too, the error is that of the plain choice, unless only initial values are
at fault.

Around a closed chain the plain choice takes rows with constant coefficients first, which makes
planar linkages along the coordinate axes small. Where mounts are written in decimals, what rounding
leaves of a coefficient may stand between an independent flow and its inertia. The chain is then
opened where it is closed by a `Weld`: the coordinates of the open tree move inertias in any case.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import TypeAlias

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.disjoint_sets import DisjointSets
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.assign import assign, assign_causality, may_be_opened
from bgc.causality.certificates import Certifier
from bgc.diagnostics.diagnostic import BgError, Fault, Refused
from bgc.equations.derive import derive_equations
from bgc.equations.variables.variable_names import RateInLoop
from bgc.ir.causal import CausalGraph, Role
from bgc.ir.graph import FlatGraph, Gyrator, Junction, Source, Transformer
from bgc.ir.program import Program

Outcome: TypeAlias = Program | Refused | None
"""The equations of a causal graph or their refusal; None before they are derived."""

Assigned: TypeAlias = tuple[CausalGraph, Outcome]


def causality_of(graph: FlatGraph) -> Assigned:
    """Assign causality by the first choice that works.

    Equations are derived only where they have to decide.

    Raises
    ------
    BgError
        As `assign_causality` does. Errors in the equations are left to `equations_of`.
    """
    found = plain = _by_first_choice(graph, ranged=False)
    if isinstance(plain, Refused) and _has_ranged_modulus(graph):
        found = _by_first_choice(graph, ranged=True)
    if isinstance(found, Refused):
        raise plain.error if isinstance(plain, Refused) else found.error
    return found


def equations_of(causal: CausalGraph, outcome: Outcome) -> tuple[CausalGraph, Program]:
    """Derive the equations of a causal graph, or of another one of the same graph.

    Raises
    ------
    BgError
        As `derive_equations` does.
    """
    refused = outcome or _derived(causal)
    if isinstance(refused, Program):
        return causal, refused
    if Fault.CHOICE in refused.faults and may_be_opened(causal):
        causal = assign_causality(causal.graph, ranged=causal.ranged, opened=True)
        return causal, derive_equations(causal)
    for graph, ranged in _other_choices(causal, refused):
        found = _by_first_choice(graph, ranged=ranged)
        other, outcome = (causal, found) if isinstance(found, Refused) else found
        outcome = outcome or _derived(other)
        if isinstance(outcome, Program):
            return other, outcome
        if outcome.faults == {Fault.START}:
            refused = outcome
    raise refused.error


def _derived(causal: CausalGraph) -> Program | Refused:
    """The equations of a causal graph, or why there are none."""
    try:
        return derive_equations(causal)
    except BgError as err:
        return Refused(err)


def _by_first_choice(graph: FlatGraph, *, ranged: bool) -> Assigned | Refused:
    """Assign causality with as few sources as resistances as needed; else the first refusal."""
    refused: Refused | None = None
    for choice in _with_more_resistances(graph):
        found = _assigned(choice, ranged=ranged, decide=refused is not None)
        if not isinstance(found, Refused):
            return found
        refused = refused or found
    assert refused is not None
    return refused


def _assigned(graph: FlatGraph, *, ranged: bool, decide: bool) -> Assigned | Refused:
    """Assign causality, with sources in the loop of a rate as resistances.

    Such a loop is looked for where a source may be in one, or if `decide` is set.
    """
    causal = assign(graph, ranged=ranged)
    if isinstance(causal, Refused):
        return causal
    if not decide and not _may_follow(causal):
        return causal, None
    outcome = _derived(causal)
    refused = outcome.error if isinstance(outcome, Refused) else None
    if not isinstance(refused, RateInLoop) or not refused.sources:
        return causal, outcome
    found = _assigned(_with_followers(graph, refused.sources), ranged=ranged, decide=True)
    return Refused(refused) if isinstance(found, Refused) else found


def _with_more_resistances(graph: FlatGraph) -> Iterator[FlatGraph]:
    """A graph, then with sources as resistances that may be ones: first the likely, then all."""
    yield graph
    for sources in (_reading_their_own_bond(graph), _reading_an_answer(graph)):
        if sources:
            graph = _with_followers(graph, sources)
            yield graph


def _other_choices(causal: CausalGraph, refused: Refused) -> Iterator[tuple[FlatGraph, bool]]:
    """Graphs to try after a refusal, each with whether divisors may vary within a range."""
    graph = causal.graph
    reading = _reading_an_answer(graph)
    if isinstance(refused.error, RateInLoop) and reading:
        yield _with_followers(graph, reading), causal.ranged
    if not causal.ranged and _has_ranged_modulus(graph):
        yield graph, True


def _has_ranged_modulus(graph: FlatGraph) -> bool:
    """Return whether a modulus varies within a range that is proven to exclude zero."""
    dag = graph.dag
    certifier = Certifier(dag, Fingerprints(dag), graph.parameters, ranged=True)
    return any(
        dag.level[node] > Level.PARAM and certifier.certify(node) is not None
        for element in graph.elements
        if isinstance(element, Transformer | Gyrator)
        for row in element.matrix
        for node in row
    )


def _with_followers(graph: FlatGraph, sources: Collection[int]) -> FlatGraph:
    """The graph with some sources as resistances."""
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


def _reading_an_answer(graph: FlatGraph) -> frozenset[int]:
    """The sources of flow whose value depends on any effort, and of effort on any flow."""
    return frozenset(
        index
        for index, element in enumerate(graph.elements)
        if isinstance(element, Source)
        and _read(graph.dag, element, Kind.EFFORT if element.kind == "Sf" else Kind.FLOW)
    )


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
