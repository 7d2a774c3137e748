"""Ways to take a graph, from the plain one to those that models need which it refuses.

Sources that follow their own reaction are resistances, written as sources. On a rigid mass,
`MSf(f = g*(a - node.e))` gives the flow that `R { f = g*(a - e); }` would give. As a source it
leaves the mass without a state, and its value then depends on the rate of the momentum that it
gives (BG521). As a resistance it leaves the mass its state, and the value is solved for the effort.

Moduli that vary within a range without zero (`2 + sin(angle)`) are divisors where no other is left.

Both are tried where the plain way fails, so that the equations of all other models stay as they
are. If these fail too, the error is that of the plain way, unless only initial values are at fault.

Around a closed chain the plain way takes rows with constant coefficients first, which makes planar
linkages along the coordinate axes small. Where mounts are written in decimals, what rounding leaves
of a coefficient may stand between an independent flow and its inertia. The chain is then opened
where it is closed by a `Weld`: the coordinates of the open tree move inertias in any case.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.disjoint_sets import DisjointSets
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.assign import assign_causality, may_be_opened
from bgc.causality.certificates import Certifier
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.derive import derive_equations
from bgc.equations.variables.variable_names import RateInLoop
from bgc.ir.causal import CausalGraph, Role
from bgc.ir.graph import FlatGraph, Gyrator, Junction, Source, Transformer
from bgc.ir.program import Program

_INITIAL = frozenset({"BG516", "BG517"})  # the equations could be derived, and the start not
# Refusals of closed chains that depend on the flows chosen as independent.
_OF_THE_WAY = frozenset({"BG502", "BG513", "BG525", "BG528"})


def causality_of(graph: FlatGraph) -> tuple[CausalGraph, Program | None]:
    """Assign causality by the first way that works.

    The program is None unless the equations had to be derived to decide.

    Raises
    ------
    BgError
        As `assign_causality` does. Errors in the equations are left to `equations_of`.
    """
    try:
        return _with_resistances(graph, ranged=False)
    except BgError as err:
        if not _has_ranged_modulus(graph):
            raise
        refused = err
    try:
        return _with_resistances(graph, ranged=True)
    except BgError:
        raise refused from None


def equations_of(causal: CausalGraph, derived: Program | None) -> tuple[CausalGraph, Program]:
    """Derive the equations of a causal graph, or of another one of the same graph.

    Raises
    ------
    BgError
        As `derive_equations` does.
    """
    if derived is not None:
        return causal, derived
    try:
        return causal, derive_equations(causal)
    except BgError as err:
        refused = err
    if may_be_opened(causal) and not _OF_THE_WAY.isdisjoint(d.code for d in refused.diagnostics):
        causal = assign_causality(causal.graph, ranged=causal.ranged, opened=True)
        return causal, derive_equations(causal)
    for graph, ranged in _other_ways(causal, refused):
        try:
            other, program = _with_resistances(graph, ranged=ranged)
            return other, program or derive_equations(other)
        except BgError as err:
            if _INITIAL.issuperset(d.code for d in err.diagnostics):
                refused = err
    raise refused


def _other_ways(causal: CausalGraph, refused: BgError) -> Iterator[tuple[FlatGraph, bool]]:
    """Graphs to try after a refusal, each with whether divisors may vary within a range."""
    graph = causal.graph
    reading = _reading_an_answer(graph)
    if isinstance(refused, RateInLoop) and reading:
        yield _with_followers(graph, reading), causal.ranged
    if not causal.ranged and _has_ranged_modulus(graph):
        yield graph, True


def _with_resistances(graph: FlatGraph, *, ranged: bool) -> tuple[CausalGraph, Program | None]:
    """Assign causality, with sources that follow their own reaction as resistances where needed."""
    candidates = [_reading_their_own_bond(graph), _reading_an_answer(graph)]
    refused: BgError | None = None
    while True:
        try:
            causal = assign_causality(graph, ranged=ranged)
        except BgError as err:
            refused = refused or err
            while candidates and not candidates[0]:
                del candidates[0]
            if not candidates:
                raise refused from None
            graph = _with_followers(graph, candidates.pop(0))
            continue
        if not refused and not _may_follow(causal):
            return causal, None
        try:
            return causal, derive_equations(causal)
        except RateInLoop as err:
            if not err.sources:
                return causal, None
            refused = err
            graph = _with_followers(graph, err.sources)
        except BgError:
            return causal, None


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
