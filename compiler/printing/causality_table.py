"""Tabulate causality: strokes with their reasons, storage, algebraic loops."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import count

from bgc.causality.procedure import Procedure, place_in_order
from bgc.driver import Stages
from bgc.ir.causal import CausalGraph, Role, Rule, Stroke
from bgc.ir.graph import Bond, FlatGraph, Storage, ports_of
from bgc.ir.program import Loop, Program, ProgramState
from bgc.language.elements import ELEMENTS
from bgc.printing.text_tables import Table

_COMPONENT = re.compile(r"(?P<base>.+)\[(?P<index>\d+)\]")


def stroke_table(causal: CausalGraph) -> Table:
    """Each bond with its stroke, at the end where the effort is imposed, and the reason for it.

    Components of a wide bond with equal strokes and reasons share a row.
    """
    numbered = [(bond, stroke, "") for bond, stroke in enumerate(causal.strokes)]
    rows = [row[1:] for row in _stroke_rows(causal.graph, numbered)]
    return Table("strokes", ("bond", "rule", "reason"), tuple(rows))


def procedure_table(found: CausalGraph | Procedure) -> Table:
    """The strokes in the order of sequential assignment, with a number at each choice.

    A contradiction stands below, with the bonds that it concerns, and then the bonds left open.
    """
    graph = found.graph
    procedure = found if isinstance(found, Procedure) else place_in_order(graph, found.strokes)
    placed = [
        (item.bond, item.stroke, "choice" if item.choice else "") for item in procedure.placements
    ]
    rows: list[tuple[str, ...]] = []
    choices = count(1)
    for mark, *row in _stroke_rows(graph, placed):
        rows.append((str(next(choices)) if mark else "", *row))
    if procedure.contradiction:
        at_fault = _stroke_rows(graph, [(bond, None, "") for bond in procedure.at_fault])
        rows.append(
            ("", _listed(row[1] for row in at_fault), "contradiction", procedure.contradiction)
        )
    reached = {*procedure.at_fault, *(item.bond for item in procedure.placements)}
    left = [(bond.index, None, "") for bond in graph.bonds if bond.index not in reached]
    rows += [("", ends, "open", "") for _, ends, _, _ in _stroke_rows(graph, left)]
    return Table("assignment", ("choice", "bond", "rule", "reason"), tuple(rows))


def _stroke_rows(
    graph: FlatGraph, strokes: Iterable[tuple[int, Stroke | None, str]]
) -> list[tuple[str, str, str, str]]:
    """Mark, ends with the stroke, rule and reason of bonds, without a stroke for None.

    Components of a wide bond that differ in nothing share a row, at the place of the first.
    """
    named = element_ends(graph)
    rows: dict[tuple[str, ...], list[int]] = {}
    for number, stroke, mark in strokes:
        bond, (tail, head) = graph.bonds[number], named[number]
        arrow = "->" if stroke is None else "->|" if stroke.at_head else "|->"
        ends = f"{_whole(tail, bond)} {arrow} {_whole(head, bond)}"
        reason = stroke.reason if stroke else ""
        if bond.width > 1:
            reason = reason.replace(f"[{bond.component}]`", "`")
        key = (bond.wide, mark, ends, stroke.rule.value if stroke else "", reason)
        rows.setdefault(key, []).extend([bond.component] if bond.width > 1 else [])
    return [
        (mark, ends + ranges(found), rule, why)
        for (_, mark, ends, rule, why), found in rows.items()
    ]


def storage_table(causal: CausalGraph, program: Program) -> Table:
    """Each storage element: its causality, its states, and the elements that share them."""
    rules: dict[int, set[Rule]] = {}
    for port in causal.ports:
        if port.role in {Role.INERTIA, Role.COMPLIANCE}:
            rules.setdefault(port.element, set()).add(causal.strokes[port.bond].rule)
    states: dict[str, list[ProgramState]] = {}
    for state in program.states:
        for name in state.stores:
            states.setdefault(name, []).append(state)
    rows = [
        _storage_row(
            element,
            rules.get(index, set()),
            states.get(element.name, []),
            ignores_default=element.name in program.ignored_defaults,
        )
        for index, element in enumerate(causal.graph.elements)
        if isinstance(element, Storage)
    ]
    return Table("storage", ("element", "kind", "causality", "states"), tuple(rows))


def _storage_row(
    element: Storage, rules: set[Rule], states: Sequence[ProgramState], *, ignores_default: bool
) -> tuple[str, str, str, str]:
    found = [rule.value for rule in (Rule.PREFERRED, Rule.DERIVATIVE) if rule in rules]
    words = {Rule.PREFERRED.value: "integral", Rule.DERIVATIVE.value: "derivative"}
    causality = " and ".join(words[name] for name in found)
    others = [name for state in states for name in state.stores if name != element.name]
    names = _listed([state.name for state in states])
    if not states:
        names = f"none: {ELEMENTS[element.kind].dependent}"
    elif others:
        kind = states[0].kind
        names = f"the generalised {kind} {names}, with {_listed(dict.fromkeys(others))}"
    if ignores_default:
        names += "; starts as what it is joined to, not at zero"
    return element.name, element.kind, causality, names


def loop_table(loops: Iterable[Loop]) -> Table:
    """Each algebraic loop: its tearing variables, its elements, its kind and its solution."""
    return Table(
        "algebraic loops",
        ("solved for", "through", "kind", "solution"),
        tuple(
            (
                _listed(loop.torn),
                _listed(loop.elements or loop.bonds),
                loop.kind.value,
                loop.solution.value,
            )
            for loop in loops
        ),
    )


def causality_tables(stages: Stages) -> tuple[Table, ...]:
    """Strokes, storage and algebraic loops of a compilation up to its equations."""
    return (
        stroke_table(stages.causal),
        storage_table(stages.causal, stages.equations),
        loop_table(stages.equations.loops),
    )


def element_ends(graph: FlatGraph) -> list[tuple[str, str]]:
    """The names of the elements at the tail and the head of each bond."""
    tails, heads = [""] * len(graph.bonds), [""] * len(graph.bonds)
    for element in graph.elements:
        for port in ports_of(element):
            (heads if port.sign > 0 else tails)[port.bond] = element.name
    return list(zip(tails, heads, strict=True))


def ranges(found: Sequence[int]) -> str:
    """Components of a wide bond, ` [1..3]` or ` [1, 4]`; empty for a scalar bond."""
    parts: list[list[int]] = []
    for component in found:
        if parts and component == parts[-1][-1] + 1:
            parts[-1].append(component)
        else:
            parts.append([component])
    texts = [str(p[0]) if len(p) == 1 else f"{p[0]}..{p[-1]}" for p in parts]
    return f" [{', '.join(texts)}]" if texts else ""


def _whole(name: str, bond: Bond) -> str:
    """The name of an element on a wide bond, without the index of the component."""
    return name.removesuffix(f"[{bond.component}]") if bond.width > 1 else name


def _listed(names: Iterable[str], most: int = 4) -> str:
    """Names separated by commas, abbreviated beyond `most`; components are joined: `p[1..6]`."""
    whole: dict[str, list[int]] = {}
    for name in names:
        found = _COMPONENT.fullmatch(name)
        base = found["base"] if found else name
        whole.setdefault(base, []).extend([int(found["index"])] if found else [])
    texts = [f"{base}{ranges(found).strip()}" for base, found in whole.items()]
    if len(texts) > most:
        return f"{', '.join(texts[: most - 1])} and {len(texts) - most + 1} more"
    return ", ".join(texts)
