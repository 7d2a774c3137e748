"""Results of the compiler by the declarations of a text: units, values, strokes, equations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeAlias, TypeVar

from bgc.algebra.dag import Dag
from bgc.algebra.infix import infix_lines
from bgc.diagnostics.source import Span
from bgc.driver import Stages
from bgc.editing.moves import moving
from bgc.ir.graph import Node
from bgc.printing.causality_table import element_ends
from bgc.printing.stages import left_sides, symbol_names
from bgc.record_class import dataclass, field
from bgc.values.shown_units import Shown

Place: TypeAlias = tuple[str, int, int]
"""The name of a source with the start and end of a span."""

_NODES = 40  # of an equation that is shown
_PARTS = 8  # parts of one declaration whose facts are kept


@dataclass(frozen=True, slots=True)
class BondFact:
    """A component of a bond; `at_head` is the end where its stroke stands."""

    name: str
    component: int
    width: int
    effort_unit: str
    flow_unit: str
    at_head: bool
    rule: str
    reason: str


@dataclass(frozen=True, slots=True)
class ValueFact:
    """A parameter or state: its path, its unit, its value where it is a number."""

    path: str
    unit: str
    value: str


@dataclass(frozen=True, slots=True)
class PartFact:
    """An element: its path, and the equations of its states."""

    path: str
    equations: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Facts:
    """Facts by the places of declarations; a declaration that is used several times has several."""

    bonds: Mapping[Place, tuple[BondFact, ...]] = field(default_factory=dict)
    values: Mapping[Place, tuple[ValueFact, ...]] = field(default_factory=dict)
    parts: Mapping[Place, tuple[PartFact, ...]] = field(default_factory=dict)


def place_of(span: Span) -> Place:
    """Return the place of a span."""
    return span.source.name, span.start, span.end


def facts_of(stages: Stages) -> Facts:
    """Collect the facts of a scene that was compiled up to its equations."""
    return Facts(_bonds(stages), _values(stages), _parts(stages))


_T = TypeVar("_T")


def merged(all_facts: Iterable[Facts]) -> Facts:
    """Merge the facts of several scenes; equal ones are kept once."""
    bonds: dict[Place, dict[BondFact, None]] = {}
    values: dict[Place, dict[ValueFact, None]] = {}
    parts: dict[Place, dict[PartFact, None]] = {}
    for facts in all_facts:
        _add(bonds, facts.bonds)
        _add(values, facts.values)
        _add(parts, facts.parts)
    return Facts(_tuples(bonds), _tuples(values), _tuples(parts))


def _add(into: dict[Place, dict[_T, None]], found: Mapping[Place, tuple[_T, ...]]) -> None:
    for place, some in found.items():
        into.setdefault(place, {}).update(dict.fromkeys(some))


def _tuples(found: Mapping[Place, Mapping[_T, None]]) -> dict[Place, tuple[_T, ...]]:
    return {place: tuple(some) for place, some in found.items()}


def shifted_facts(facts: Facts, name: str, old: str, new: str) -> Facts:
    """Move the places in one source to those in its new text; those in the edit are dropped."""

    at = moving(old, new)

    def move(found: Mapping[Place, tuple[_T, ...]]) -> dict[Place, tuple[_T, ...]]:
        result: dict[Place, tuple[_T, ...]] = {}
        for place, some in found.items():
            start, end = at(place[1]), at(place[2])
            if place[0] != name:
                result[place] = some
            elif start is not None and end is not None:
                result[name, start, end] = some
        return result

    return Facts(move(facts.bonds), move(facts.values), move(facts.parts))


def _bonds(stages: Stages) -> dict[Place, tuple[BondFact, ...]]:
    graph, causal = stages.graph, stages.causal
    found: dict[Place, list[BondFact]] = {}
    for bond, stroke, _ in zip(graph.bonds, causal.strokes, element_ends(graph), strict=True):
        found.setdefault(place_of(bond.span), []).append(
            BondFact(
                bond.wide,
                bond.component,
                bond.width,
                bond.effort_unit,
                bond.flow_unit,
                stroke.at_head,
                stroke.rule.value,
                stroke.reason,
            )
        )
    return {place: tuple(facts) for place, facts in found.items()}


def _values(stages: Stages) -> dict[Place, tuple[ValueFact, ...]]:
    graph = stages.graph
    found: dict[Place, list[ValueFact]] = {}
    rows = [(p.name, p.unit, p.shown, p.value, p.span) for p in graph.parameters]
    rows += [(s.name, s.unit, s.shown, s.initial, s.span) for s in graph.states]
    for name, unit, shown, node, span in rows:
        here = found.setdefault(place_of(span), [])
        if len(here) >= _PARTS:
            continue
        value = graph.dag.value(node)
        unit_shown = shown or Shown(unit)
        text = "" if value is None else unit_shown.text(float(value))
        here.append(ValueFact(name, unit_shown.label or unit, text))
    return {place: tuple(facts) for place, facts in found.items()}


def _parts(stages: Stages) -> dict[Place, tuple[PartFact, ...]]:
    program = stages.equations
    names = symbol_names(program)
    stored: dict[str, list[int]] = {}
    for index, state in enumerate(program.states):
        for name in state.stores:
            stored.setdefault(name, []).append(index)
    left = left_sides(program)
    found: dict[Place, list[PartFact]] = {}
    for element in stages.graph.elements:
        here = found.setdefault(place_of(element.span), [])
        if len(here) >= _PARTS:
            continue
        lines: list[str] = []
        for index in stored.get(element.name, ()):
            node = program.states[index].derivative
            if _is_short(program.dag, node):
                lines += infix_lines(program.dag, [(left[index], node)], names)
            else:
                lines.append(f"{left[index]} = ..  (`bgc equations` prints it)")
        here.append(PartFact(element.name, tuple(lines)))
    return {place: tuple(facts) for place, facts in found.items()}


def _is_short(dag: Dag, node: Node) -> bool:
    seen: set[Node] = set()
    queue = [node]
    while queue:
        here = queue.pop()
        if here in seen:
            continue
        seen.add(here)
        if len(seen) > _NODES:
            return False
        queue.extend(dag.operands(here))
    return True
