"""What a scene could do without: parts made simpler or rigid, elements switched off."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.defaults import default_values
from bgc.elaboration.modules import Package
from bgc.graph import FlatGraph, Resistor, Storage
from bgc.options import Options
from bgc.runtime.activity.powers import Activity, below
from bgc.runtime.stress.drives import law_nodes
from bgc.variants import variants_of


@dataclass(frozen=True, slots=True)
class Change:
    """A statement for the scene: `use slot = type;` or `set parameter = 0;`.

    `activity` is that of the elements it concerns, J.
    """

    name: str
    value: str
    is_use: bool
    activity: float

    @property
    def statement(self) -> str:
        """The line that a scene would say."""
        return f"{'use' if self.is_use else 'set'} {self.name} = {self.value};"


def with_changes(options: Options, changes: Sequence[Change]) -> Options:
    """The options with the changes made."""
    uses = tuple((c.name, c.value) for c in changes if c.is_use)
    sets = tuple((c.name, c.value) for c in changes if not c.is_use)
    return replace(options, uses=(*options.uses, *uses), overrides=(*options.overrides, *sets))


def possible_changes(
    package: Package, graph: FlatGraph, found: Sequence[Activity], negligible: float
) -> tuple[Change, ...]:
    """What concerns no more than a share `negligible` of all activity, the least first.

    Slots filled otherwise, and parameters which at zero leave an element without an effect.
    """
    most = negligible * sum(activity.activity for activity in found)
    changes = [*_uses(package, graph, found), *_zeros(graph, found)]
    fitting = [change for change in changes if change.activity <= most]
    return tuple(sorted(fitting, key=lambda change: change.activity))


def _uses(package: Package, graph: FlatGraph, found: Sequence[Activity]) -> Iterator[Change]:
    for variant in variants_of(package, graph):
        if (activity := below(found, variant.slot)) is not None:
            yield Change(variant.slot, variant.type, True, activity)


def _zeros(graph: FlatGraph, found: Sequence[Activity]) -> Iterator[Change]:
    """Parameters that switch elements off, and nothing else.

    One whose value of zero makes all nodes of some laws zero, and which no other law holds.
    """
    by_name = {activity.element: activity.activity for activity in found}
    values = default_values(graph.dag, graph.parameters)
    offs, others = _holders(graph, values)
    for parameter in graph.parameters:
        elements = offs.get(parameter.index, ())
        if not elements or parameter.index in others:
            continue
        if (parameter.low is None or parameter.low <= 0) and _given(parameter.index, values) != 0:
            activity = sum(by_name.get(name, 0.0) for name in elements)
            yield Change(parameter.name, "0", False, activity)


def _given(index: int, values: Mapping[Symbol, float]) -> float:
    return values[Symbol(Kind.PARAM, index)]


def _holders(
    graph: FlatGraph, values: Mapping[Symbol, float]
) -> tuple[dict[int, list[str]], set[int]]:
    """Parameters by the elements they switch off, and those that laws of others hold."""
    dag = graph.dag
    offs: dict[int, list[str]] = {}
    others: set[int] = set()
    for element in graph.elements:
        if not isinstance(element, (Storage, Resistor)):
            continue
        nodes = law_nodes(element.law)
        symbols = [s for s in map(dag.symbol_of, dag.reachable(nodes)) if s is not None]
        constant = all(s.kind is Kind.PARAM for s in symbols)
        for symbol in symbols:
            if symbol.kind is not Kind.PARAM:
                continue
            zeroed = {**values, symbol: 0.0}
            if constant and not any(evaluate_nodes(dag, nodes, zeroed)):
                offs.setdefault(symbol.index, []).append(element.name)
            else:
                others.add(symbol.index)
    return offs, others
