"""Open a scene for analysis: compile a program with chosen inputs and outputs.

Each chosen input becomes an INPUT symbol that is added to the varied quantity, so that zero leaves
the scene unchanged: the effort or flow of a source, the value of a parameter (and of those whose
defaults follow from it), or the channel of a device. The initial state does not depend on it.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path

from bgc.algebra.dag import Dag, Kind
from bgc.diagnostics.catalogue import analysis as catalogue
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.driver import compile_scene
from bgc.elaboration.scenes.scene_devices import channel_unit
from bgc.emission.simplification import number_values
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import Element, FlatGraph, Node, Parameter, Source, ports_of
from bgc.ir.program import Program
from bgc.options import Options
from bgc.record_class import dataclass, field, replace
from bgc.slicing.slice import without_unread

_MEMBER = re.compile(r"\[\d+\](?=\.[ef]$)")
_COMPONENT = re.compile(r"\[[\d,]+\]$")


@dataclass(frozen=True, slots=True)
class Varied:
    """An input of the opened program: `index` is that of its INPUT symbol.

    `kind` is `source`, `parameter` or `channel`. `given` is the scene's own value of a source
    that the symbol replaces; None where the symbol is added to what it varies.
    """

    name: str
    unit: str
    index: int
    kind: str
    given: Node | None = None


@dataclass(frozen=True, slots=True)
class Opened:
    """A program reduced to the states that its outputs need, its inputs, and its source texts.

    Jumps are left out, and sampled values are constants; `moving` is the program with both, which
    may need more states.
    `starts_at_rest` is true where the scene has a start at rest, which the program does not hold.
    """

    program: Program
    inputs: tuple[Varied, ...]
    warnings: tuple[Diagnostic, ...]
    sources: tuple[str, ...]
    moving: Program
    starts_at_rest: bool = False


@dataclass(frozen=True, slots=True)
class Candidate:
    """A possible input: a source (index of the element), a parameter, or a device channel."""

    kind: str  # "source", "parameter" or "channel"
    index: int
    unit: str


def open_scene(
    path: Path,
    options: Options,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    values: Mapping[str, float] | None = None,
    *,
    total: bool = False,
) -> Opened:
    """Compile a scene to a program with chosen inputs and outputs.

    Parameters
    ----------
    path, options
        The file and its scene. The whole model is compiled, so that every parameter can be varied.
    inputs
        Efforts or flows of sources, parameters, inputs of models, channels of devices; by default
        all channels of the scene's devices. A vector's name selects all its components. One name
        may be given alone, as may that of one output.
    outputs
        Names that the scene observes, or expressions; by default all observations of the scene
        except the energy accounts.
    values
        Other defaults of parameters by name, SI.
    total
        Whether the symbol of a source replaces its effort or flow, instead of being added to it,
        where that depends on parameters and the time alone. Derivatives are the same. Without
        `inputs`, all such sources are inputs too, except those of zero.

    Raises
    ------
    BgError
        The model is invalid, or an input or output cannot be used; BG522 where an output needs
        the rate of an input.
    """
    inputs, outputs = ([each] if isinstance(each, str) else each for each in (inputs, outputs))
    selection = _Selection(tuple(inputs), bool(outputs), dict(values or {}), total)
    options = replace(options, whole=True, observe=tuple(outputs), inputs=tuple(inputs))
    stages = compile_scene(path, options, prepare=selection.applied_to, until="equations")
    whole = stages.equations
    equations = _between_instants(whole)
    program = without_unread(_with_parameters(equations, selection.parameters))
    given = selection.given
    dag, new = number_values(program.dag, (*nodes_of(program), *given.values()))
    varied = tuple(
        replace(v, given=new[given[v.index]]) if v.index in given else v for v in selection.varied
    )
    sources = tuple(source.text for source in stages.package.sources)
    program = map_nodes(program, dag, new.__getitem__)
    moving = program
    if whole.jumps or whole.held:
        moving = without_unread(_with_parameters(whole, selection.parameters))
        dag, new = number_values(moving.dag, nodes_of(moving))
        moving = map_nodes(moving, dag, new.__getitem__)
    return Opened(program, varied, stages.warnings, sources, moving, selection.starts_at_rest)


def _between_instants(program: Program) -> Program:
    """A program without jumps, whose sampled values are constants, as at one time."""
    zero = program.dag.zero
    held = tuple(replace(held, update=zero) for held in program.held)
    return replace(program, jumps=(), held=held)


@dataclass(slots=True)
class _Selection:
    """The chosen inputs of a scene, found in its flat graph.

    `varied` are the inputs in order, `parameters` the INPUT symbols that are added to parameters,
    `given` the values of the sources that an INPUT symbol replaces, by its index.
    """

    inputs: tuple[str, ...]
    other_outputs: bool
    values: dict[str, float]
    total: bool = False
    varied: list[Varied] = field(default_factory=list)
    parameters: dict[int, Node] = field(default_factory=dict)
    given: dict[int, Node] = field(default_factory=dict)
    starts_at_rest: bool = False

    def applied_to(self, graph: FlatGraph) -> FlatGraph:
        """Vary the chosen sources, remove accounts and a start at rest, set the defaults."""
        if self.other_outputs and graph.scene.accounts:
            (account, *_) = graph.scene.accounts
            raise BgError([catalogue.account_as_output(f"energy.{account.account}")])
        observed = tuple(o for o in graph.observations if o.name in graph.scene.columns)
        columns = tuple(o.name for o in observed)
        self.starts_at_rest = graph.scene.rest is not None
        facts = replace(graph.scene, accounts=(), columns=columns, rest=None)
        defaults = _with_values(graph, self.values)
        graph = replace(graph, scene=facts, observations=observed, parameters=defaults)
        candidates = input_candidates(graph)
        first = sum(len(device.inputs) for device in graph.devices) + len(graph.held)
        sources: dict[int, Node] = {}
        given = _given_values(graph) if self.total else {}
        chosen = (
            choose_inputs(candidates, self.inputs) if self.inputs else _default(candidates, given)
        )
        for name in chosen:
            candidate = candidates[name]
            index = candidate.index
            if candidate.kind != "channel":
                index = first + len(sources) + len(self.parameters)
                symbol = graph.dag.symbol(Kind.INPUT, index)
                added = sources if candidate.kind == "source" else self.parameters
                added[candidate.index] = symbol
                if candidate.kind == "source" and candidate.index in given:
                    self.given[index] = given[candidate.index]
            self.varied.append(Varied(name, candidate.unit, index, candidate.kind))
        graph = with_sources(graph, sources, given)
        return replace(graph, varied=len(sources) + len(self.parameters))


def _with_values(graph: FlatGraph, values: Mapping[str, float]) -> tuple[Parameter, ...]:
    return tuple(
        replace(p, value=graph.dag.const(values[p.name])) if p.name in values else p
        for p in graph.parameters
    )


# --- what may be chosen -----------------------------------------------------------------------


def channel_names(device: str, channels: Sequence[tuple[str, int]]) -> list[str]:
    """Names of a device's inputs or commands: `hand.position[3]`, `lever.angle`."""
    wide = {channel for channel, component in channels if component > 1}
    return [
        f"{device}.{channel}{f'[{component}]' if channel in wide else ''}"
        for channel, component in channels
    ]


def input_candidates(graph: FlatGraph) -> dict[str, Candidate]:
    """All possible inputs by name: channels of devices, then sources, then parameters."""
    found: dict[str, Candidate] = {}
    for device in graph.devices:
        names = zip(channel_names(device.name, device.inputs), device.inputs, strict=True)
        for k, (name, (channel, _)) in enumerate(names, device.first_input):
            found[name] = Candidate("channel", k, channel_unit(channel))
    for index, element in enumerate(graph.elements):
        if isinstance(element, Source):
            name, unit = _source_name(graph, element)
            found.setdefault(name, Candidate("source", index, unit))
    for parameter in graph.parameters:
        candidate = Candidate("parameter", parameter.index, parameter.unit)
        found.setdefault(parameter.name, candidate)
    return found


def _source_name(graph: FlatGraph, source: Source) -> tuple[str, str]:
    """The name of a source as an input, `supply.e` or `push.e[2]` in a wide one, and its unit."""
    (port,) = ports_of(source)
    bond = graph.bonds[port.bond]
    letter = "e" if source.kind == "Se" else "f"
    unit = bond.effort_unit if letter == "e" else bond.flow_unit
    suffix = f"[{bond.component}]"
    if bond.width > 1 and source.name.endswith(suffix):
        return f"{source.name.removesuffix(suffix)}.{letter}{suffix}", unit
    return f"{source.name}.{letter}", unit


def _default(candidates: Mapping[str, Candidate], given: Collection[int]) -> list[str]:
    """The channels of the devices, and some sources, by their elements."""
    return [
        name
        for name, candidate in candidates.items()
        if candidate.kind == "channel" or (candidate.kind == "source" and candidate.index in given)
    ]


def choose_inputs(candidates: Mapping[str, Candidate], texts: Sequence[str]) -> list[str]:
    """The names of the selected inputs, without repetition.

    A vector's name selects its components, a source's name its effort or flow. Where a `Mux` joins
    the bonds of a wide source, its components are sources of their own, `free[2].e`.
    """
    vectors: dict[str, list[str]] = {}
    for name, candidate in candidates.items():
        whole = _COMPONENT.sub("", name)
        if candidate.kind == "source":
            whole = _MEMBER.sub("", whole)
        vectors.setdefault(whole, []).append(name)
        if candidate.kind == "source":
            vectors.setdefault(whole.rpartition(".")[0], []).append(name)
    chosen: dict[str, None] = {}
    errors = []
    for text in texts:
        names = [text] if text in candidates else vectors.get(text)
        if names is None:
            errors.append(catalogue.unknown_input(text, candidates))
        chosen.update(dict.fromkeys(names or ()))
    if errors:
        raise BgError(errors)
    return list(chosen)


# --- what is varied ---------------------------------------------------------------------------


def with_sources(
    graph: FlatGraph, added: Mapping[int, Node], replaced: Collection[int] = ()
) -> FlatGraph:
    """The graph with a symbol added to what some of its sources set, or in place of it."""
    elements: list[Element] = []
    for index, element in enumerate(graph.elements):
        if isinstance(element, Source) and index in added:
            symbol = added[index]
            value = symbol if index in replaced else graph.dag.add(element.value, symbol)
            element = replace(element, value=value)
        elements.append(element)
    return replace(graph, elements=tuple(elements))


def _given_values(graph: FlatGraph) -> dict[int, Node]:
    """The values of the sources that depend on parameters and the time alone, and are not zero."""
    dag = graph.dag
    values = {k: e.value for k, e in enumerate(graph.elements) if isinstance(e, Source)}
    return {
        k: node
        for k, node in values.items()
        if node != dag.zero and _depends_on_parameters_alone(dag, node)
    }


def _depends_on_parameters_alone(dag: Dag, node: Node) -> bool:
    """Test whether a node holds no symbols but parameters and the time."""
    symbols = map(dag.symbol_of, dag.reachable([node]))
    return all(s is None or s.kind in (Kind.PARAM, Kind.TIME) for s in symbols)


def _with_parameters(program: Program, added: Mapping[int, Node]) -> Program:
    """Add a symbol to some parameters of a program, wherever its equations contain them."""
    if not added:
        return program
    dag = program.dag
    moved = {dag.symbol(Kind.PARAM, index): symbol for index, symbol in added.items()}
    replaced = {node: dag.add(node, symbol) for node, symbol in moved.items()}
    replaced = with_followers(dag, program.parameters, replaced)
    if not replaced.keys().isdisjoint(dag.reachable([m.value for m in program.mass or ()])):
        name = program.parameters[next(iter(added))].name
        raise BgError([catalogue.input_in_mass(name)])
    roots = nodes_of(program)
    new_of = dict(zip(roots, dag.substitute(roots, replaced), strict=True))
    varied = map_nodes(program, dag, new_of.__getitem__)
    return replace(
        varied,
        mass=program.mass,
        parameters=program.parameters,
        positive=program.positive,
        states=tuple(
            replace(state, initial=old.initial, scale=old.scale)
            for state, old in zip(varied.states, program.states, strict=True)
        ),
    )


def with_followers(
    dag: Dag, parameters: Sequence[Parameter], replaced: Mapping[Node, Node]
) -> dict[Node, Node]:
    """Add what replaces the parameters whose defaults follow from replaced ones.

    Each changes as its default does; one that has been set keeps its offset from it.
    """
    found = dict(replaced)
    for index in _in_dependency_order(dag, parameters):
        node, value = dag.symbol(Kind.PARAM, index), parameters[index].value
        if node in found or found.keys().isdisjoint(dag.reachable([value])):
            continue
        (new,) = dag.substitute([value], found)
        found[node] = dag.add(node, dag.sub(new, value))
    return found


def _in_dependency_order(dag: Dag, parameters: Sequence[Parameter]) -> Iterable[int]:
    """Indices of the parameters, each after those on which its default depends."""
    done: dict[int, None] = {}
    for start in range(len(parameters)):
        stack = [start]
        while stack:
            index = stack[-1]
            symbols = map(dag.symbol_of, dag.reachable([parameters[index].value]))
            needed = [s.index for s in symbols if s is not None and s.index not in done]
            if index in done or not needed:
                done[index] = None
                stack.pop()
            else:
                stack.extend(needed)
    return done
