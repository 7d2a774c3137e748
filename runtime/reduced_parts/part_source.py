"""A part of a scene: its elements, ports, outputs and values, read from the elaborated graph."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NoReturn, TypeAlias

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.catalogue.studies import part_not_reduced
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.words import listed
from bgc.driver import compile_scene
from bgc.grammar import syntax
from bgc.ir.defaults import default_values
from bgc.ir.graph import (
    Element,
    FlatGraph,
    Form,
    Junction,
    LinearLaw,
    Observation,
    Part,
    Resistor,
    Slot,
    Storage,
    ports_of,
)
from bgc.options import Options
from bgc.record_class import dataclass, replace
from bgc.resolution.modules import Package, ancestors, flatten
from bgc.runtime.linearising.operating_point import OpenedModel
from bgc.runtime.reduced_parts.part_laws import Laws, symbols_of
from bgc.runtime.reduced_parts.part_system import PartPort, PartSystem, part_system
from bgc.runtime.reduced_parts.part_text import TextOutput, TextPort

_Items: TypeAlias = dict[str, syntax.Port | syntax.Value]

_COMPONENT = re.compile(r"\[([\d,]+)\]$")
_GIVEN = ("param", "const", "input")
_READABLE = ("output", "signal", "let", "state", "unknown")


@dataclass(frozen=True, slots=True, eq=False)
class PartSource:
    """A part as it stands in a scene, with its linear form.

    `model` and `base` are its model and the interface of its slot, with their dimensions; `base` is
    empty where it fills no slot. `values` are statements of the interface's parameters with their
    values in the scene, `outputs` those that are linear. `tangents` names the elements whose laws
    are replaced by their tangents at the start.
    """

    path: str
    model: str
    base: str
    ports: tuple[TextPort, ...]
    values: tuple[str, ...]
    outputs: tuple[TextOutput, ...]
    found: PartSystem
    tangents: tuple[str, ...]


def read_part(
    path: Path, options: Options, package: Package, part: str, values: Mapping[str, float]
) -> PartSource:
    """Read a part of a scene.

    Parameters
    ----------
    path, options, package
        The file, its scene with what the user changes about it, and the file as it was parsed.
    part
        The path of the part.
    values
        Values of parameters that differ from those of the scene, SI, by name.

    Raises
    ------
    BgError
        BG665: the part has no linear passive form.
    """
    graph = _elaborated(path, options, package, ())
    place = next((each for each in graph.parts if each.path == part), None)
    if place is None or not part:
        there = listed([each.path for each in graph.parts if each.path])
        _refuse(part, f"the scene has no such part; it has {there}")
    slot = next((each for each in graph.slots if each.path == part), None)
    declared = _declared(package, place, slot)
    names = [f"{part}.{name}" for name in declared.read]
    graph = _elaborated(path, options, package, names)
    parameters = tuple(
        replace(each, value=graph.dag.const(values[each.name])) if each.name in values else each
        for each in graph.parameters
    )
    numbers = default_values(graph.dag, parameters)
    elements = _elements(graph, part)
    start = _values_at_start(path, options, values, graph, elements)
    laws = Laws(graph.dag.copy(), part, numbers, start)
    seen = {name: _observed(graph, f"{part}.{name}") for name in declared.read}
    return _source(place, slot, declared, elements, laws, seen)


def _elaborated(
    path: Path, options: Options, package: Package, observed: Iterable[str]
) -> FlatGraph:
    options = replace(options, observe=tuple(observed))
    return compile_scene(path, options, package=package, until="elaborate").graph


def _refuse(part: str, reason: str) -> NoReturn:
    raise BgError([part_not_reduced(part, reason)])


# --- declarations -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Declared:
    """What the text of a part declares: `needed` are the outputs that its interface has."""

    ports: tuple[syntax.Port, ...]
    values: tuple[syntax.Value, ...]
    outputs: tuple[syntax.Value, ...]
    needed: frozenset[str]

    @property
    def read(self) -> list[str]:
        """All names whose values are wanted, without the part's own."""
        ports = [f"{port.name}.{letter}" for port in self.ports for letter in "ef"]
        return ports + [value.name for value in (*self.outputs, *self.values)]


def _declared(package: Package, part: Part, slot: Slot | None) -> _Declared:
    own = _items(package, part.model)
    wanted = _items(package, slot.interface) if slot is not None else {}
    needed = frozenset(n for n, item in wanted.items() if _is(item, _READABLE))
    ports = tuple(item for item in own.values() if isinstance(item, syntax.Port))
    for port in ports:
        domain = package.root.domains.get(port.domain or "")
        if domain is not None and any(v.kind == "signal" for v in domain.syntax.variables):
            _refuse(part.path, f"its port `{port.name}` carries signals: it moves in space")
        if port.law is not None:
            _refuse(part.path, f"its port `{port.name}` is sampled")
    if not ports:
        _refuse(part.path, "it has no ports")
    values = (item for item in own.values() if isinstance(item, syntax.Value))
    outputs = (item for item in values if item.kind == "output" or item.name in needed)
    return _Declared(
        ports=ports,
        values=tuple(
            item
            for item in wanted.values()
            if isinstance(item, syntax.Value) and item.kind in _GIVEN
        ),
        outputs=tuple(outputs),
        needed=needed,
    )


def _items(package: Package, model: str) -> _Items:
    """The ports and values of a model with those of its bases, by name."""
    declared = package.root.models.get(model)
    found: _Items = {}
    for each in ancestors(declared) if declared is not None else ():
        for item in flatten(each.syntax.items):
            if isinstance(item, syntax.Port | syntax.Value):
                found.setdefault(item.name, item)
    return found


def _is(item: syntax.Port | syntax.Value, kinds: Sequence[str]) -> bool:
    return isinstance(item, syntax.Value) and item.kind in kinds


# --- the graph --------------------------------------------------------------------------------


def _elements(graph: FlatGraph, part: str) -> list[Element]:
    """The elements of a part; BgError where it has equations of its own."""
    names = [state.name for state in graph.states] + [each.name for each in graph.unknowns]
    names += [held.name for held in graph.held] + [port.name for port in graph.ports]
    if any(name.startswith(f"{part}.") for name in names):
        _refuse(part, "it has states, unknowns or samples besides its elements")
    return [each for each in graph.elements if each.name.startswith(f"{part}.")]


def _observed(graph: FlatGraph, name: str) -> list[Observation]:
    """The components of a value that the scene observes."""
    return [each for each in graph.observations if _COMPONENT.sub("", each.name) == name]


def _values_at_start(
    path: Path,
    options: Options,
    values: Mapping[str, float],
    graph: FlatGraph,
    elements: Sequence[Element],
) -> dict[Symbol, float]:
    """The states of a part at the start, and the variables of its nonlinear resistors."""
    stores = [each for each in elements if isinstance(each, Storage)]
    bent = [e for e in elements if isinstance(e, Resistor) and not isinstance(e.law, LinearLaw)]
    given = any(each.initial for each in stores) or any(
        isinstance(each, Junction) and each.initial for each in elements
    )
    straight = all(isinstance(each.law, LinearLaw) for each in stores) and not bent
    if straight and not given and graph.scene.rest is None:
        return {}
    wanted: list[tuple[str, Symbol]] = []
    for store in stores:
        letter = "q" if store.kind == "C" else "p"
        wanted += zip(_names(graph, store, letter), symbols_of(store), strict=True)
    for resistor in bent:
        letter, kind = ("f", Kind.FLOW) if resistor.law.form is Form.EFFORT else ("e", Kind.EFFORT)
        own = [Symbol(kind, port.bond) for port in resistor.ports]
        wanted += zip(_names(graph, resistor, letter), own, strict=True)
    opened = OpenedModel(path, options, outputs=[name for name, _ in wanted], values=values)
    numbers = opened.outputs(opened.operating_point(None)).tolist()
    names = [each.name for each in opened.opened.program.observations]
    found = dict(zip(names, numbers, strict=True))
    return {symbol: found[name] for name, symbol in wanted}


def _names(graph: FlatGraph, element: Storage | Resistor, letter: str) -> list[str]:
    """The names of an element's variables, `hub.f[2]` for a component of a wide one."""
    if len(element.ports) > 1:
        return [f"{element.name}.{letter}[{k + 1}]" for k in range(len(element.ports))]
    bond = graph.bonds[element.ports[0].bond]
    suffix = f"[{bond.component}]"
    if bond.width > 1 and element.name.endswith(suffix):
        return [f"{element.name.removesuffix(suffix)}.{letter}{suffix}"]
    return [f"{element.name}.{letter}"]


# --- the source -------------------------------------------------------------------------------


def _source(
    part: Part,
    slot: Slot | None,
    declared: _Declared,
    elements: Sequence[Element],
    laws: Laws,
    seen: Mapping[str, Sequence[Observation]],
) -> PartSource:
    inside = {port.bond: port.sign for each in elements for port in ports_of(each)}
    scalars: list[PartPort] = []
    for port in declared.ports:
        for each in seen[f"{port.name}.e"]:
            symbol = laws.dag.symbol_of(each.node)
            if symbol is None or symbol.index not in inside:
                _refuse(part.path, f"its port `{port.name}` leads to none of its elements")
            scalars.append(PartPort(symbol.index, inside[symbol.index]))
    nodes = [each.node for output in declared.outputs for each in seen[output.name]]
    found = part_system(elements, scalars, nodes, laws)
    owner = [output for output in declared.outputs for _ in seen[output.name]]
    bent = {output.name for output, linear in zip(owner, found.linear, strict=True) if not linear}
    if bent & declared.needed:
        _refuse(part.path, f"its output `{min(bent & declared.needed)}` is not linear")
    rows = [k for k, output in enumerate(owner) if output.name not in bent]
    system = replace(found.system, outputs=found.system.outputs[rows])
    return PartSource(
        path=part.path,
        model=_sized(part.model, [size for _, size in part.dims]),
        base=_sized(slot.interface, slot.dims) if slot is not None else "",
        ports=_text_ports(declared.ports, found, scalars, seen),
        values=tuple(
            line
            for value in declared.values
            for line in _value_lines(value, seen[value.name], laws)
        ),
        outputs=tuple(
            TextOutput(_declaration(output, seen[output.name]), _shape(seen[output.name]))
            for output in declared.outputs
            if output.name not in bent
        ),
        found=replace(found, system=system),
        tangents=tuple(dict.fromkeys(laws.tangents)),
    )


def _text_ports(
    ports: Sequence[syntax.Port],
    found: PartSystem,
    scalars: Sequence[PartPort],
    seen: Mapping[str, Sequence[Observation]],
) -> tuple[TextPort, ...]:
    texts, first = [], 0
    for port in ports:
        flows = seen[f"{port.name}.f"]
        last = first + len(flows)
        is_out = scalars[first].sign < 0
        domain = f" : {port.domain}" if port.domain else ""
        width = f"[{len(flows)}]" if len(flows) > 1 and not port.domain else ""
        direction = f" {port.direction.value}" if port.direction else " out" if is_out else " in"
        declaration = f"port {port.name}{width}{direction}{domain}{' main' if port.main else ''}"
        units = tuple(each.unit for each in flows)
        by_effort = found.by_effort[first:last]
        texts.append(TextPort(port.name, declaration, is_out, by_effort, units))
        first = last
    return tuple(texts)


def _value_lines(value: syntax.Value, seen: Sequence[Observation], laws: Laws) -> list[str]:
    """A parameter with its value, and an assertion that it keeps it."""
    numbers = evaluate_nodes(laws.dag, [each.node for each in seen], laws.values)
    texts = [repr(number).replace("e+", "e") for number in numbers]
    shape = _shape(seen)
    text = f"[{', '.join(texts)}]" if shape else texts[0]
    if len(shape) > 1:
        text = f"[{', '.join(_rows(texts, shape))}]"
    lines = [f"{_declaration(value, seen)} = {text};"]
    if not shape and value.kind != "const":
        lines.append(
            f'assert {value.name} == {text}, "the part is reduced for its {value.name} = {text}";'
        )
    return lines


def _rows(texts: Sequence[str], shape: tuple[int, ...]) -> list[str]:
    return [f"[{', '.join(texts[k : k + shape[1]])}]" for k in range(0, len(texts), shape[1])]


def _declaration(value: syntax.Value, seen: Sequence[Observation]) -> str:
    """`output name[3] : m`, without its value; anything that is read becomes an output."""
    kind = value.kind if value.kind in _GIVEN else "output"
    dims = _sized("", _shape(seen)).replace("][", ", ")
    return f"{kind} {value.name}{dims}{f' : {value.unit}' if value.unit else ''}"


def _shape(seen: Sequence[Observation]) -> tuple[int, ...]:
    """The dimensions of a value, by its last component."""
    last = _COMPONENT.search(seen[-1].name)
    return tuple(map(int, last[1].split(","))) if last else ()


def _sized(name: str, sizes: Sequence[int]) -> str:
    return f"{name}[{', '.join(map(str, sizes))}]" if sizes else name
