"""Choose the causality of a graph: the first choice for which there are equations.

Sources that follow their own reaction are resistances, written as sources. On a rigid mass,
`MSf(f = g*(a - node.e))` gives the flow that `R { f = g*(a - e); }` would give. As a source it
leaves the mass without a state, and its value then depends on the rate of the momentum that it
gives (BG521). As a resistance it leaves the mass its state, and the value is solved for the effort.

Moduli that vary within a range without zero (`2 + sin(angle)`) are divisors where no other is left.
Transformers and gyrators that are solved whole keep the coordinates of storage behind them, which
the order of single rows may mix with moduli that vanish.

These are tried where the plain choice fails, so that the equations of all other models stay as
they are. If these fail too, the error is that of the first choice with independent flows, unless
only initial values are at fault.

Around a closed chain the plain choice takes rows with constant coefficients first, which makes
planar linkages along the coordinate axes small. Where mounts are written in decimals, what rounding
leaves of a coefficient may stand between an independent flow and its inertia. The chain is then
opened where it is closed by a `Weld`: the coordinates of the open tree move inertias in any case.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.disjoint_sets import DisjointSets
from bgc.causality.assign import assign, may_be_opened
from bgc.diagnostics.diagnostic import BgError, Fault, Refused
from bgc.equations.derive import derive_equations
from bgc.ir.causal import CausalGraph
from bgc.ir.graph import FlatGraph, Gyrator, Junction, Source, Transformer
from bgc.ir.program import Program
from bgc.record_class import dataclass, replace


@dataclass(frozen=True, slots=True)
class Derived:
    """A causal graph, and its equations or their refusal."""

    causal: CausalGraph
    equations: Program | Refused


def derive(graph: FlatGraph) -> Derived | Refused:
    """Derive the equations by the first choice that has any; else by the first with flows.

    Refused where no choice has independent flows.
    """
    first: Refused | None = None
    found: Derived | None = None
    for choice, ranged, whole in _choices(graph):
        causal = assign(choice, ranged=ranged, whole=whole)
        if isinstance(causal, Refused):
            first = first or causal
            continue
        derived = _derived(causal)
        if isinstance(derived.equations, Program):
            return derived
        if found is None or derived.equations.faults == {Fault.START}:
            found = derived
    outcome = found or first
    assert outcome is not None
    return outcome


def _derived(causal: CausalGraph) -> Derived:
    """The equations of a causal graph, or of the same one opened where the choice is at fault."""
    equations = _attempted(causal)
    if isinstance(equations, Refused) and Fault.CHOICE in equations.faults:
        opened = may_be_opened(causal) and assign(causal.graph, ranged=causal.ranged, opened=True)
        if isinstance(opened, CausalGraph):
            return Derived(opened, _attempted(opened))
    return Derived(causal, equations)


def _attempted(causal: CausalGraph) -> Program | Refused:
    try:
        return derive_equations(causal)
    except BgError as err:
        return Refused(err)


def _choices(graph: FlatGraph) -> Iterator[tuple[FlatGraph, bool, bool]]:
    """Graphs whose sources may be resistances, each with the arguments `ranged` and `whole`.

    First no source is a resistance, then the likely ones, then all that may be; then the same with
    divisors that vary in a range, and with transformers solved whole.
    """
    graphs = [graph]
    for sources in (_reading_their_own_bond(graph), _reading_an_answer(graph)):
        if sources:
            graphs.append(_with_followers(graphs[-1], sources))
    ways = [(False, False)]
    if _has_varying_modulus(graph):
        ways += [(True, False), (False, True)]
    for ranged, whole in ways:
        yield from ((choice, ranged, whole) for choice in graphs)


def _has_varying_modulus(graph: FlatGraph) -> bool:
    """Return whether a modulus varies: alone or with others it may keep off zero."""
    level = graph.dag.level
    return any(
        level[node] > Level.PARAM
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
    return {symbol.index for symbol in dag.symbols_in([source.value], kind).values()}
