"""Print the result of each pass as text, for `bgc show --after PASS` and the golden files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from typing import Any, Literal, TypeAlias, assert_never, get_args

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.infix import infix_lines, number
from bgc.diagnostics.source import Source, Span
from bgc.driver import Stage, Stages
from bgc.grammar.syntax import File
from bgc.ir.graph import Element, FlatGraph, ports_of
from bgc.ir.program import Program
from bgc.ir.shapes import ShapeUse
from bgc.printing.causality_table import causality_tables, element_ends, ranges
from bgc.printing.text_tables import as_text
from bgc.slicing.fold import Folding
from bgc.slicing.slicing_report import dropped_lines, folded_lines

Pass: TypeAlias = Literal[
    "parse", "elaborate", "fold", "causality", "equations", "slice", "optimise", "emit"
]
PASSES: tuple[Pass, ...] = get_args(Pass)

_WIDTH = 100


def show_pass(name: Pass, stages: Stages) -> str:
    """The result of a pass as text; `stages` must include that pass."""
    match name:
        case "parse":
            return show_syntax(stages.package.root.file)
        case "elaborate":
            return show_graph(stages.graph)
        case "fold":
            return show_folding(stages.folding)
        case "causality":
            return as_text(causality_tables(stages))
        case "equations":
            return show_equations(stages.equations)
        case "slice":
            return show_equations(stages.sliced)
        case "optimise":
            return show_equations(stages.optimised)
        case "emit":
            return "\n".join(unit.text for unit in stages.emitted.units)
        case _:
            assert_never(name)


def needed_for(name: Pass) -> Stage:
    """The last stage that the result of a pass and the warnings about it require."""
    match name:
        case "elaborate":
            return "physics"
        case "causality":
            return "equations"  # its tables name storage and algebraic loops
        case _:
            return name


def show_syntax(file: File) -> str:
    """The syntax tree without spans: one line per node, or an indented block if it is too long."""
    nodes = (*file.imports, *file.declarations)
    return "".join(f"{_tree(node, 0)}\n" for node in nodes)


def _tree(node: Any, indent: int) -> str:
    flat = _flat(node)
    nested = isinstance(node, tuple) or is_dataclass(node)
    if len(flat) + indent <= _WIDTH or not nested:
        return flat
    pad = " " * (indent + 2)
    if isinstance(node, tuple):
        inner = [_tree(item, indent + 2) for item in node]
        return "(\n" + "".join(f"{pad}{item}\n" for item in inner) + " " * indent + ")"
    named = [f"{name} = {_tree(value, indent + 2)}" for name, value in _fields(node)]
    body = "".join(f"{pad}{item}\n" for item in named)
    return f"{type(node).__name__}(\n{body}{' ' * indent})"


def _flat(node: Any) -> str:
    match node:
        case tuple():
            return f"({', '.join(_flat(item) for item in node)})"
        case Fraction():
            return number(node)
        case Enum():
            return str(node.value)
        case _ if is_dataclass(node):
            inner = ", ".join(f"{name} = {_flat(value)}" for name, value in _fields(node))
            return f"{type(node).__name__}({inner})"
        case _:
            return repr(node)


def _fields(node: Any) -> list[tuple[str, Any]]:
    """The fields of a syntax node, without spans and without absent or empty values."""
    found = ((f.name, getattr(node, f.name)) for f in fields(node))
    return [
        (name, value)
        for name, value in found
        if not isinstance(value, Span | Source) and value not in (None, (), "", False)
    ]


def show_graph(graph: FlatGraph) -> str:
    """The flat bond graph: its elements with their bonds, then the bonds."""
    return _sections(_graph_sections(graph))


def _graph_sections(graph: FlatGraph) -> tuple[tuple[str, list[str]], ...]:
    return (
        ("elements", [_element(graph, element) for element in graph.elements]),
        ("bonds", _bonds(graph)),
        ("parameters", _parameters(graph)),
        ("states", [f"{s.name} ({s.unit})" for s in graph.states]),
        ("shapes", [_shape(shape) for shape in graph.shapes]),
    )


def _shape(shape: ShapeUse) -> str:
    """A shape by name, with its colour and its values where they are recorded."""
    parts = [shape.name, *filter(None, (shape.colour, shape.file))]
    for value in shape.values:
        numbers = value.numbers
        if numbers is None:
            parts.append(f"{value.field} varies")
        else:
            listed = ", ".join(f"{number:g}" for number in numbers)
            parts.append(
                f"{value.field} = {listed}" if len(numbers) == 1 else f"{value.field} = [{listed}]"
            )
    return "  ".join(parts)


def show_folding(folding: Folding) -> str:
    """The parameters that were replaced by numbers, and the resulting flat graph."""
    folded = ("folded", list(folded_lines(folding.parameters)))
    return _sections((folded, *_graph_sections(folding.graph)))


def show_equations(program: Program) -> str:
    """The initial values, the state equations `M y' = f`, and the observations of the scene."""
    names = symbol_names(program)

    def lines(equations: list[tuple[str, int]]) -> list[str]:
        return infix_lines(program.dag, equations, names)

    left = left_sides(program)
    return _sections(
        (
            ("start", lines([(s.name, s.initial) for s in program.states])),
            (
                "equations",
                lines([(rate, s.derivative) for rate, s in zip(left, program.states, strict=True)]),
            ),
            ("jumps", lines(_jumps(program))),
            ("sampled", lines(_sampled(program))),
            ("FMUs", list(_fmus(program))),
            ("observed", lines([(o.name, o.node) for o in program.observations])),
            ("energy", lines(_accounts(program))),
            ("dropped", _dropped(program)),
        )
    )


def _sampled(program: Program) -> list[tuple[str, int]]:
    """The rates of sampled parts, the starts of their states, and the values at an instant."""
    found: list[tuple[str, int]] = []
    for k, rate in enumerate(program.rates):
        found += [(f"period {k + 1}", rate.period), (f"offset {k + 1}", rate.offset)]
        held = [h for h in program.held if h.rate == k]
        found += [(f"{h.name}(0)", h.initial) for h in held if h.is_state]
        found += [
            (f"next({h.name})" if h.is_state else h.name, h.update)
            for h in held
            if program.dag.symbol(Kind.INPUT, h.index) != h.update  # an FMU gives it
        ]
    return found


def _fmus(program: Program) -> Iterator[str]:
    """The FMUs of other tools: what they take, and what they give."""
    names = {program.dag.symbol(Kind.INPUT, h.index): h.name for h in program.held}
    for fmu in program.fmus:
        yield f"{fmu.name}: {fmu.file}"
        for link in fmu.links:
            arrow = "->" if link.role == "output" else "<-"
            yield f"  {link.name} {arrow} {names[link.symbol]}"


def _jumps(program: Program) -> list[tuple[str, int]]:
    """The condition of each jump, followed by the values that it gives to states."""
    found: list[tuple[str, int]] = []
    for k, jump in enumerate(program.jumps, 1):
        found.append((f"when {k}", jump.condition))
        found += [(f"when {k}: {program.states[r.state].name}", r.value) for r in jump.resets]
    return found


def _dropped(program: Program) -> list[str]:
    return list(dropped_lines(program.dropped, [state.name for state in program.states]))


def _accounts(program: Program) -> list[tuple[str, int]]:
    """The stored energy and the rates of the other accounts, as far as the scene uses them."""
    energy = program.energy
    rates = [
        ("stored", energy.stored),
        ("supplied'", energy.supplied),
        ("dissipated'", energy.dissipated),
    ]
    needed = program.scene.needed_accounts(bool(program.jumps))
    return [pair for pair in rates if pair[0].rstrip("'") in needed]


def _sections(sections: Iterable[tuple[str, list[str]]]) -> str:
    blocks = (
        f"{title}\n" + "".join(f"  {line}\n" for line in lines)
        for title, lines in sections
        if lines
    )
    return "\n".join(blocks)


def left_sides(program: Program) -> list[str]:
    """The left sides of the state equations: `x'`, or a row of the mass matrix times the rates."""
    if program.mass is None:
        return [f"{state.name}'" for state in program.states]
    rows: list[list[str]] = [[] for _ in program.states]
    names = symbol_names(program)
    for entry in program.mass:
        (line,) = infix_lines(program.dag, [("", entry.value)], names)
        factor = line.removeprefix(" = ")
        rate = f"{program.states[entry.column].name}'"
        rows[entry.row].append(rate if factor == "1" else f"({factor}) * {rate}")
    return [" + ".join(row) or "0" for row in rows]


def symbol_names(program: Program) -> Callable[[Symbol], str]:
    """A function that returns the name of a symbol of a program."""
    inputs = [
        f"{device.name}.{channel}[{component}]"
        for device in program.devices
        for channel, component in device.inputs
    ]
    inputs += [held.name for held in program.held]
    if program.slots > len(program.held):  # some of the symbols are no longer read
        first = len(inputs) - len(program.held)
        inputs[first:] = [f"held {k}" for k in range(program.slots)]
        for held in program.held:
            inputs[held.index] = held.name
    tables = {
        Kind.PARAM: [p.name for p in program.parameters],
        Kind.STATE: [s.name for s in program.states],
        Kind.INPUT: inputs,
    }

    def name(symbol: Symbol) -> str:
        if symbol.kind is Kind.SELECTOR:
            return f"selector {symbol.index - len(program.parameters)}"
        return "time" if symbol.kind is Kind.TIME else tables[symbol.kind][symbol.index]

    return name


def _element(graph: FlatGraph, element: Element) -> str:
    """One line for an element, with consecutive components of a wide bond as a range."""
    on: dict[str, list[int]] = {}
    for port in ports_of(element):
        bond = graph.bonds[port.bond]
        on.setdefault(bond.wide, []).extend([bond.component] if bond.width > 1 else [])
    bonds = ", ".join(wide + ranges(found) for wide, found in on.items())
    return f"{element.name} : {element.kind} on {bonds}"


def _bonds(graph: FlatGraph) -> list[str]:
    lines = []
    for bond, (tail, head) in zip(graph.bonds, element_ends(graph), strict=True):
        units = (bond.effort_unit, bond.flow_unit)
        lines.append(f"{tail} -> {head}" + (f" ({', '.join(units)})" if all(units) else ""))
    return lines


def _parameters(graph: FlatGraph) -> list[str]:
    names = [p.name for p in graph.parameters]
    equations = [(p.name, p.value) for p in graph.parameters]
    return infix_lines(graph.dag, equations, lambda symbol: names[symbol.index])
