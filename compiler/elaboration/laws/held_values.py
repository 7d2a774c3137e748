"""Read sampled parts: the values that they hold, and how each follows at an instant."""

from __future__ import annotations

from collections.abc import Iterator

from bgc.algebra.dag import Kind, Level
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.catalogue import samples
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.bond_units import SECOND
from bgc.elaboration.bonds.wiring import Wiring
from bgc.elaboration.instances.checks import check_value, fit_shape, require_level
from bgc.elaboration.instances.components import component_names
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.tree import FmuCall, SampledPart
from bgc.elaboration.instances.world import World
from bgc.elaboration.laws.statements import read_target
from bgc.ir.graph import FlatGraph, FmuLink, FmuUse, Held, Junction, Node, SampleRate, Storage
from bgc.values.fmu_files import FmuVariable
from bgc.values.units import DIMENSIONLESS, si_text


def read_sampled(world: World, wiring: Wiring) -> tuple[tuple[Held, ...], tuple[SampleRate, ...]]:
    """Read the held values of all instances by their symbols, and the rates that they have."""
    found: list[Held] = []
    rates: dict[tuple[Node, Node], int] = {}
    made: list[SampleRate] = []
    for instance in wiring.instances:
        for part in instance.sampled:
            with world.report.collecting(note(part.env)):
                rate = _read_rate(world, part)
                number = rates.setdefault((rate.period, rate.offset), len(made))
                if number == len(made):
                    made.append(rate)
                found += _read_held(world, part, number)
    return tuple(sorted(found, key=lambda held: held.index)), tuple(made)


def _read_rate(world: World, part: SampledPart) -> SampleRate:
    """The period and offset of a sampled part."""
    item = part.item
    nodes = []
    for expr, what in ((item.period, "the sampling period"), (item.offset, "the offset")):
        if expr is None:
            nodes.append(world.dag.zero)
            continue
        value = world.evaluate(expr, part.env)
        check_value(value, (), SECOND, expr.span, what)
        require_level(world.dag, value, Level.PARAM, expr.span, what)
        nodes.append(value.node)
    period, offset = nodes
    if world.dag.level[period] == Level.CONST:
        (seconds,) = evaluate_nodes(world.dag, [period], {})
        if not seconds > 0:
            raise BgError([samples.bad_period(item.period.span, seconds)])
    return SampleRate(period, offset, item.period.span)


def _read_held(world: World, part: SampledPart, rate: int) -> Iterator[Held]:
    """The components of the states and outputs of a sampled part."""
    errors = len(world.report.errors)
    following = _read_nexts(world, part)
    all_read = len(world.report.errors) == errors
    sent = {call.given: _read_given(world, call) for call in part.fmus}
    received = {call.got for call in part.fmus}
    for quantity in part.held:
        symbols = world.quantities.value(quantity, quantity.declaration.name_span)
        span = quantity.declaration.name_span
        is_state = quantity.kind == "state"
        if is_state:
            initial = fit_shape(
                world.dag, world.quantities.start(quantity), symbols.shape, span, quantity.path
            ).nodes
            places = range(quantity.first, quantity.first + len(symbols.nodes))
            nodes = [following[k][0] for k in places if k in following]
            if len(nodes) < len(symbols.nodes):
                if all_read:  # else the one that is missing has been reported
                    name = quantity.declaration.name
                    world.report.add(samples.state_without_next(span, name))
                continue
        elif quantity in sent or quantity in received:
            initial = (world.dag.zero,) * len(symbols.nodes)
            nodes = sent.get(quantity) or list(symbols.nodes)
        else:
            initial = (world.dag.zero,) * len(symbols.nodes)
            value = world.quantities.value(part.definitions[quantity], span)
            what = f"`{quantity.declaration.name}`"
            nodes = list(fit_shape(world.dag, value, symbols.shape, span, what).nodes)
        labels = component_names(quantity.path, symbols.shape)
        for k, label in enumerate(labels):
            unit = si_text(symbols.units[k])
            index = quantity.first + k
            yield Held(index, label, unit, initial[k], nodes[k], rate, is_state, span)


def _read_given(world: World, call: FmuCall) -> list[Node]:
    """The values that an FMU is given, each checked against the unit of its variable."""
    found = []
    for variable, expr in call.set:
        value = world.evaluate(expr, call.env)
        what = f"`{variable.name}` of `{call.file.shown}`"
        unit = variable.unit.dimension
        check_value(value, (), DIMENSIONLESS if unit is None else unit, expr.span, what)
        if variable.causality == "parameter":
            require_level(world.dag, value, Level.PARAM, expr.span, what)
        found.append(value.node)
    return found


def read_fmus(world: World, wiring: Wiring) -> tuple[FmuUse, ...]:
    """Read the FMUs of all sampled parts, whose held values have been read."""
    return tuple(
        _read_fmu(world, call)
        for instance in wiring.instances
        for part in instance.sampled
        for call in part.fmus
    )


def _read_fmu(world: World, call: FmuCall) -> FmuUse:
    """The FMU of a call: each variable with the symbol of its held value."""
    given = world.quantities.value(call.given, call.span).nodes
    got = world.quantities.value(call.got, call.span).nodes
    pairs = zip((*(v for v, _ in call.set), *call.read), (*given, *got), strict=True)
    file, owner = call.file, call.env.instance
    return FmuUse(
        owner.path if owner is not None and owner.path else call.got.path,
        file.shown,
        str(file.path.absolute()),
        file.digest,
        file.version,
        file.identifier,
        file.token,
        file.once,
        tuple(_link(variable, symbol) for variable, symbol in pairs),
        call.span,
    )


def _link(variable: FmuVariable, symbol: Node) -> FmuLink:
    is_parameter = variable.causality == "parameter"
    tunable = is_parameter and variable.variability == "tunable"
    role = "tunable" if tunable else variable.causality if variable.is_set else "output"
    unit = variable.unit
    return FmuLink(
        variable.name,
        variable.reference,
        variable.kind,
        role,
        symbol,
        variable.place,
        variable.count,
        unit.factor,
        unit.offset,
        variable.start if is_parameter else None,
    )


def _read_nexts(world: World, part: SampledPart) -> dict[int, tuple[Node, Span]]:
    """The next value of each component of each state by its symbol, with its place."""
    found: dict[int, tuple[Node, Span]] = {}
    for statement, env in part.nexts:
        with world.report.collecting(note(env)):
            read_target(world, statement, env, found, part)
    return found


def refuse_held_early(graph: FlatGraph) -> None:
    """Refuse initial values and projections that depend on held values.

    Raises
    ------
    BgError
        BG489.
    """
    if not graph.held:
        return
    held = {h.index: h for h in graph.held}
    early: list[tuple[Node, str, Span]] = []
    for state in graph.states:
        early.append((state.initial, f"the start of `{state.name}`", state.span))
        if state.projection is not None:
            early.append((state.projection, f"the projection of `{state.name}`", state.span))
    for element in graph.elements:
        if isinstance(element, Storage):
            early += [(i.value, f"the start of `{element.name}`", i.span) for i in element.initial]
        elif isinstance(element, Junction) and element.initial is not None:
            given = element.initial
            early.append((given.value, f"the start of `{element.name}`", given.span))
    early += [(h.initial, f"the start of `{h.name}`", h.span) for h in graph.held]
    problems = []
    for node, what, span in early:
        for symbol in map(graph.dag.symbol_of, graph.dag.reachable([node])):
            if symbol is not None and symbol.kind is Kind.INPUT and symbol.index in held:
                found = held[symbol.index]
                problems.append(samples.held_too_early(span, found.name, what, found.span))
                break
    if problems:
        raise BgError(problems)
