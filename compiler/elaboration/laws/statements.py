"""Read the statements of all instances: assignments, states, equations and asserts."""

from __future__ import annotations

from bgc.algebra.dag import Kind, Level
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.catalogue import graph, laws, names, samples
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.bond_units import SECOND
from bgc.elaboration.bonds.domains import Domains
from bgc.elaboration.bonds.port_signals import Carried
from bgc.elaboration.bonds.wiring import Wiring
from bgc.elaboration.instances.checks import check_units, check_value, fit_like, fit_shape
from bgc.elaboration.instances.components import component_names, ordinal
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.scopes import find_member, path_of
from bgc.elaboration.instances.tree import Environment, Instance, PortEntry, Quantity, SampledPart
from bgc.elaboration.instances.world import World
from bgc.elaboration.laws.when import read_jump
from bgc.grammar import syntax
from bgc.ir.graph import Condition, Equation, Guard, Jump, Node, State, Unknown
from bgc.record_class import dataclass
from bgc.values.units import (
    Dimension,
    divide,
    shown_of,
    si_text,
)
from bgc.values.value import Value, describe_shape

# In this order: the nodes of one kind of statement come before those of the next.
_KINDS = (syntax.Derivative, syntax.Project, syntax.Equation, syntax.Assert, syntax.When)


@dataclass(frozen=True, slots=True)
class Statements:
    """States, unknowns, equations and asserts, as the flat graph holds them."""

    states: tuple[State, ...]
    unknowns: tuple[Unknown, ...]
    equations: tuple[Equation, ...]
    guards: tuple[Guard, ...]
    conditions: tuple[Condition, ...]
    jumps: tuple[Jump, ...]


def collect_definitions(world: World, wiring: Wiring) -> None:
    """Register each assignment with the output or signal that it defines, without evaluation."""
    for instance in wiring.instances:
        for statement, env in instance.written(syntax.Assign):
            if (member := _defined(statement, env)) is not None:
                world.quantities.definitions.setdefault(member, []).append((statement, env))


def _defined(statement: syntax.Assign, env: Environment) -> Quantity | None:
    """The output or signal of the same model that an assignment defines."""
    match statement.target:
        case syntax.Name(name=name) | syntax.Index(base=syntax.Name(name=name)):
            member = find_member(env, name)
        case _:
            return None
    if not isinstance(member, Quantity) or member.kind not in {"output", "signal"}:
        return None
    return member if member.declaration.value is None else None


def collect_assignments(world: World, wiring: Wiring, domains: Domains, carried: Carried) -> None:
    """Register each assignment to a signal of a port, without evaluation; refuse wrong targets."""
    carried.owners = wiring.owners
    for instance in wiring.instances:
        for statement, env in instance.written(syntax.Assign):
            with world.report.collecting(note(env)):
                _collect_assignment(world, domains, carried, instance, statement, env)


def _collect_assignment(
    world: World,
    domains: Domains,
    carried: Carried,
    instance: Instance,
    statement: syntax.Assign,
    env: Environment,
) -> None:
    target = statement.target
    match target:
        case syntax.Member(base=syntax.Name(name=port_name), name=signal):
            port = instance.members.get(port_name)
            if isinstance(port, PortEntry):
                domain = port.outer.net.root().domain
                facts = domains.facts(domain.declared) if domain else None
                if facts is not None and signal in facts.signals:
                    carried.write(port, signal, facts, statement, env)
                    return
                have = list(facts.signals) if facts else []
                raise BgError(
                    [graph.unknown_port_member(target.span, f"port `{port_name}`", signal, have)]
                )
        case syntax.Name(name=name) | syntax.Index(base=syntax.Name(name=name)):
            if _defined(statement, env) is not None:
                return
            if find_member(env, name) is None:
                seen = [*env.locals, *instance.members]
                raise BgError([names.unknown_name(target.span, name, seen)])
        case _:
            pass
    raise BgError([graph.cannot_assign(target.span, path_of(target))])


def evaluate_values(world: World, wiring: Wiring, carried: Carried) -> None:
    """Evaluate all values of all instances, so that every error in them is reported."""
    writes: dict[Instance, list[Quantity]] = {}
    for (port, _), quantity in carried.written.items():
        writes.setdefault(port.instance, []).append(quantity)
    for instance in wiring.instances:
        members = [m for m in instance.members.values() if isinstance(m, Quantity)]
        for quantity in [*members, *writes.get(instance, ())]:
            with world.report.collecting(note(quantity.env)):
                world.quantities.found(quantity, quantity.declaration.name_span)


def evaluate_parameters(world: World, wiring: Wiring) -> None:
    """Evaluate parameters and constants, which numbers the parameters in source order."""
    for instance in wiring.instances:
        for member in instance.members.values():
            if isinstance(member, Quantity) and member.kind in {"param", "const"}:
                with world.report.collecting(note(member.env)):
                    world.quantities.found(member, member.declaration.name_span)


def read_statements(world: World, wiring: Wiring) -> Statements:
    """Read states with their derivatives, unknowns, equations and asserts of all instances."""
    derivatives: dict[int, tuple[Node, Span]] = {}
    projections: dict[int, tuple[Node, Span]] = {}
    equations: list[Equation] = []
    guards: list[Guard] = []
    conditions: list[Condition] = []
    jumps: list[Jump] = []
    for instance in wiring.instances:
        for statement, env in (each for kind in _KINDS for each in instance.written(kind)):
            with world.report.collecting(note(env)):
                match statement:
                    case syntax.Derivative():
                        read_target(world, statement, env, derivatives, rate=True)
                    case syntax.Project() if signal := _projected_signal(statement, env):
                        conditions.extend(_read_condition(world, signal, statement, env))
                    case syntax.Project():
                        read_target(world, statement, env, projections)
                    case syntax.Equation():
                        equations.extend(_read_equation(world, statement, env))
                    case syntax.Assert():
                        guards.extend(_read_assert(world, instance, statement, env))
                    case syntax.When():
                        jumps.append(read_jump(world, statement, env))
    states = tuple(_states(world, derivatives, projections))
    unknowns = tuple(_unknowns(world))
    if not world.report.errors:
        _check_counts(world, states, unknowns, equations)
    return Statements(
        states, unknowns, tuple(equations), tuple(guards), tuple(conditions), tuple(jumps)
    )


def _projected_signal(statement: syntax.Project, env: Environment) -> Quantity | None:
    """The signal that a projection is for; None where its target is anything else."""
    target = statement.target
    assert env.instance is not None
    member = env.instance.members.get(target.name) if isinstance(target, syntax.Name) else None
    is_signal = isinstance(member, Quantity) and member.kind in {"signal", "let", "output"}
    return member if isinstance(member, Quantity) and is_signal else None


def _read_condition(
    world: World, signal: Quantity, statement: syntax.Project, env: Environment
) -> list[Condition]:
    """The components of `project x = value` for a signal x."""
    held = world.quantities.value(signal, statement.target.span)
    span = statement.value.span
    value = world.evaluate(statement.value, env)
    value = fit_like(world.dag, value, held, span, f"`{signal.path}`")
    labels = component_names(signal.path, held.shape)
    return [
        Condition(label, world.dag.sub(node, target), statement.target.span)
        for label, node, target in zip(labels, held.nodes, value.nodes, strict=True)
    ]


def _read_assert(
    world: World, instance: Instance, statement: syntax.Assert, env: Environment
) -> list[Guard]:
    """The guard of an `assert`; none if constants alone decide that it holds.

    Raises
    ------
    BgError
        Constants alone decide that it does not hold.
    """
    value = world.evaluate(statement.condition, env)
    check_value(value, (), None, statement.condition.span, "the condition")
    (condition,) = value.nodes
    if world.dag.level[condition] > Level.CONST:
        whose = f"`{instance.path}`: " if instance.path else ""
        return [Guard(condition, whose + statement.message, statement.span)]
    (holds,) = evaluate_nodes(world.dag, [condition], {})
    if not holds:
        raise BgError([laws.false_assert(instance.span, statement.message, statement.span)])
    return []


def read_target(
    world: World,
    statement: syntax.Derivative | syntax.Project | syntax.Next,
    env: Environment,
    found: dict[int, tuple[Node, Span]],
    part: SampledPart | None = None,
    rate: bool = False,
) -> None:
    """Record the value of `der(x) = ..`, `project x = ..`, `next x = ..` for each component of x.

    The keys are `x.first` and those after it. `part` is the sampled part that has to hold x.
    """
    target = statement.target
    base = target.base if isinstance(target, syntax.Index) else target
    assert env.instance is not None
    state = env.instance.members.get(base.name) if isinstance(base, syntax.Name) else None
    is_state = isinstance(state, Quantity) and state.kind == "state"
    if not isinstance(state, Quantity) or not is_state or (part and state not in part.held):
        message = samples.next_of_what if part else laws.not_a_state
        raise BgError([message(target.span, path_of(target))])
    symbols = world.quantities.value(state, target.span)
    value = world.evaluate(statement.value, env)
    span = statement.value.span
    what = f"der({path_of(target)})" if rate else path_of(target)
    places, shape = list(range(len(symbols.nodes))), symbols.shape
    if isinstance(target, syntax.Index):
        index = world.quantities.component_index(target, env, shape, state.path)
        places, shape = [ordinal(index, shape)], ()
    value = fit_shape(world.dag, value, shape, span, f"`{what}`")
    for place, component in zip(places, value.components, strict=True):
        unit = symbols.units[place]
        expected = divide(unit, SECOND) if rate and unit is not None else unit
        check_units(component, expected, span, f"`{what}`")
        key = state.first + place
        if key in found:
            raise BgError([names.given_twice(target.span, what, found[key][1])])
        found[key] = (component.node, target.span)


def _read_equation(world: World, equation: syntax.Equation, env: Environment) -> list[Equation]:
    left = world.evaluate(equation.left, env, rates=True)
    right = world.evaluate(equation.right, env, rates=True)
    dag = world.dag
    right = fit_like(dag, right, left, equation.right.span, "the right side")
    return [
        Equation(dag.sub(a, b), equation.span) for a, b in zip(left.nodes, right.nodes, strict=True)
    ]


def _components(world: World, quantity: Quantity) -> list[tuple[str, Dimension | None, Node]]:
    """Name, unit and initial value of each component of a state or unknown."""
    value = quantity.value
    assert value is not None
    start: Value = world.quantities.start(quantity)
    if start.shape != value.shape:
        raise BgError(
            [
                shape_messages.wrong_shape(
                    quantity.declaration.span,
                    f"`{quantity.declaration.name}`",
                    describe_shape(value.shape),
                    describe_shape(start.shape),
                )
            ]
        )
    labels = component_names(quantity.path, value.shape)
    return list(zip(labels, value.units, start.nodes, strict=True))


def _states(
    world: World,
    derivatives: dict[int, tuple[Node, Span]],
    projections: dict[int, tuple[Node, Span]],
) -> list[State]:
    found: list[State] = []
    for quantity in world.quantities.states:
        with world.report.collecting(note(quantity.env)):
            for k, (name, unit, start) in enumerate(_components(world, quantity)):
                index = quantity.first + k
                derivative = derivatives.get(index, (None, None))[0]
                projection = projections.get(index, (None, None))[0]
                span = quantity.declaration.name_span
                free = _free_parameters(world, start)
                found.append(
                    State(
                        index,
                        name,
                        si_text(unit),
                        start,
                        derivative,
                        projection,
                        span,
                        free,
                        shown_of(unit),
                    )
                )
    return found


def _free_parameters(world: World, start: Node) -> tuple[Node, ...]:
    """The parameters that a start depends on, if all of them keep their parts' own defaults.

    A parameter that is given by others stands for these.
    """
    found: dict[Node, None] = {}
    waiting = [start]
    while waiting:
        names = [
            (node, symbol)
            for node in world.dag.reachable([waiting.pop()])
            if (symbol := world.dag.symbol_of(node)) is not None and symbol.kind is Kind.PARAM
        ]
        if not names:
            return ()
        for node, symbol in names:
            if symbol.index in world.quantities.ungiven:
                found[node] = None
            else:
                waiting.append(world.quantities.parameters[symbol.index].value)
    return tuple(found)


def _unknowns(world: World) -> list[Unknown]:
    found: list[Unknown] = []
    for quantity in world.quantities.unknowns:
        with world.report.collecting(note(quantity.env)):
            for k, (name, unit, start) in enumerate(_components(world, quantity)):
                span = quantity.declaration.name_span
                first = quantity.first + k
                found.append(Unknown(first, name, si_text(unit), start, span, shown_of(unit)))
    return found


def _check_counts(
    world: World,
    states: tuple[State, ...],
    unknowns: tuple[Unknown, ...],
    equations: list[Equation],
) -> None:
    """Report unequal numbers of equations and unknowns.

    States without a derivative count as unknowns. Of unequal numbers, the cause is a state whose
    rate appears in no equation, if there is one; with equal numbers, such a state is valid: its
    row of the mass matrix is zero.
    """
    implicit = [state for state in states if state.derivative is None]
    held = [*(u.span for u in unknowns), *(state.span for state in implicit)]
    if len(equations) == len(held):
        return
    dag = world.dag
    rates = set()
    for node in dag.reachable(equation.residual for equation in equations):
        symbol = dag.symbol_of(node)
        if symbol is not None and symbol.kind is Kind.RATE:
            rates.add(symbol.index)
    for state in implicit:
        if state.index not in rates:
            world.report.add(laws.state_without_equation(state.span, state.name))
    if not world.report.errors:
        surplus = [e.span for e in equations] if len(equations) > len(held) else held
        world.report.add(laws.equations_and_unknowns(surplus[-1], len(equations), len(held)))
