"""Simplifications of a scene: other parts in slots, elements switched off; those that were kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.elaboration.scenes.variants import Change, variants_of
from bgc.ir.defaults import default_values
from bgc.ir.fields import nodes_of
from bgc.ir.graph import FlatGraph, Resistor, Storage
from bgc.record_class import dataclass
from bgc.resolution.modules import Package
from bgc.runtime.activity.powers import Activity, below
from bgc.runtime.measuring.measured_store import Store, open_store
from bgc.runtime.running.loaded_model import LoadedModel


@dataclass(frozen=True, slots=True)
class Candidate:
    """A change to try, and the activity of the elements concerned, J."""

    change: Change
    activity: float


def possible_changes(
    package: Package,
    graph: FlatGraph,
    present: Mapping[str, float],
    found: Sequence[Activity],
    negligible: float,
) -> tuple[Candidate, ...]:
    """List changes that concern at most a share `negligible` of all activity, the least first.

    A change puts another part into a slot, or sets a parameter to zero that switches elements off.
    `present` has the values of the run-time parameters, SI; others have their defaults.
    """
    most = negligible * sum(activity.activity for activity in found)
    candidates = [*_uses(package, graph, found), *_zeros(graph, present, found)]
    fitting = [candidate for candidate in candidates if candidate.activity <= most]
    return tuple(sorted(fitting, key=lambda candidate: candidate.activity))


def _uses(package: Package, graph: FlatGraph, found: Sequence[Activity]) -> Iterator[Candidate]:
    for variant in variants_of(package, graph):
        if (activity := below(found, variant.name)) is not None:
            yield Candidate(variant, activity)


def _zeros(
    graph: FlatGraph, present: Mapping[str, float], found: Sequence[Activity]
) -> Iterator[Candidate]:
    """Find parameters that only switch elements off.

    At zero, such a parameter makes all nodes of some laws zero, and no other law contains it.
    """
    by_name = {activity.element: activity.activity for activity in found}
    values = default_values(graph.dag, graph.parameters) | {
        Symbol(Kind.PARAM, p.index): present[p.name] for p in graph.parameters if p.name in present
    }
    switched, others = _holders(graph, values)
    for parameter in graph.parameters:
        elements = switched.get(parameter.index, ())
        if not elements or parameter.index in others:
            continue
        given = values[Symbol(Kind.PARAM, parameter.index)]
        if (parameter.low is None or parameter.low <= 0) and given != 0:
            activity = sum(by_name.get(name, 0.0) for name in elements)
            yield Candidate(Change(parameter.name, "0", is_use=False), activity)


def _holders(
    graph: FlatGraph, values: Mapping[Symbol, float]
) -> tuple[dict[int, list[str]], set[int]]:
    """Find the elements that each parameter switches off, and parameters of other laws."""
    dag = graph.dag
    switched: dict[int, list[str]] = {}
    others: set[int] = set()
    for element in graph.elements:
        if not isinstance(element, (Storage, Resistor)):
            continue
        nodes = nodes_of(element.law)
        symbols = [s for s in map(dag.symbol_of, dag.reachable(nodes)) if s is not None]
        constant = all(s.kind is Kind.PARAM for s in symbols)
        for symbol in symbols:
            if symbol.kind is not Kind.PARAM:
                continue
            zeroed = {**values, symbol: 0.0}
            if constant and not any(evaluate_nodes(dag, nodes, zeroed)):
                switched.setdefault(symbol.index, []).append(element.name)
            else:
                others.add(symbol.index)
    return switched, others


# --- kept for `bgc trade` ---------------------------------------------------------------------


def open_variants(model: LoadedModel) -> Store:
    """The store of the variants that were found for a scene with its present parameters."""
    return open_store(model, "activity", model.facts.requirements)


def stored_variants(model: LoadedModel) -> tuple[tuple[Change, ...], ...] | None:
    """Read the variants that were kept; None if the scene in this form was not examined."""
    return open_variants(model).read(tuple[tuple[Change, ...], ...])
