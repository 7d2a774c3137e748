"""Read the statements of all instances: assignments, states, equations and asserts."""

from __future__ import annotations

from dataclasses import dataclass

from bgc.algebra.dag import Kind, Level
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.catalogue import graph, laws, names, values
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.carried import Carried
from bgc.elaboration.bonds.domains import Domains
from bgc.elaboration.bonds.units import SECOND
from bgc.elaboration.bonds.wiring import Wiring
from bgc.elaboration.instances.checks import check_value, fit_shape
from bgc.elaboration.instances.components import component_names, ordinal
from bgc.elaboration.instances.notes import note
from bgc.elaboration.instances.scopes import find_member, path_of
from bgc.elaboration.instances.tree import Environment, Instance, PortEntry, Quantity
from bgc.elaboration.instances.world import World
from bgc.elaboration.laws.jumps import read_jump
from bgc.grammar import syntax
from bgc.ir.graph import Condition, Equation, Guard, Jump, Node, State, Unknown
from bgc.values.units import (
    Dimension,
    describe_dimension,
    divide,
    shown_of,
    si_text,
)
from bgc.values.value import Value, describe_shape


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
        for statement, env in instance.assigns:
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
        for statement, env in instance.assigns:
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
        for derivative, env in instance.derivatives:
            with world.report.collecting(note(env)):
                _read_target(world, derivative, env, derivatives, rate=True)
        for projection, env in instance.projections:
            with world.report.collecting(note(env)):
                signal = _projected_signal(projection, env)
                if signal is not None:
                    conditions.extend(_read_condition(world, signal, projection, env))
                else:
                    _read_target(world, projection, env, projections, rate=False)
        for equation, env in instance.equations:
            with world.report.collecting(note(env)):
                equations.extend(_read_equation(world, equation, env))
        for statement, env in instance.asserts:
            with world.report.collecting(note(env)):
                guards.extend(_read_assert(world, instance, statement, env))
        for when, env in instance.whens:
            with world.report.collecting(note(env)):
                jumps.append(read_jump(world, when, env))
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
    value = fit_shape(
        world.dag, world.evaluate(statement.value, env), held.shape, span, f"`{signal.path}`"
    )
    for declared, unit in zip(held.units, value.units, strict=True):
        _check_unit(unit, declared, span, f"`{signal.path}`")
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


def _read_target(
    world: World,
    statement: syntax.Derivative | syntax.Project,
    env: Environment,
    found: dict[int, tuple[Node, Span]],
    rate: bool,
) -> None:
    """Record the value of `der(x) = ..` or `project x = ..` for each component of x."""
    target = statement.target
    base = target.base if isinstance(target, syntax.Index) else target
    assert env.instance is not None
    state = env.instance.members.get(base.name) if isinstance(base, syntax.Name) else None
    if not isinstance(state, Quantity) or state.kind != "state":
        raise BgError([laws.not_a_state(target.span, path_of(target))])
    symbols = world.quantities.value(state, target.span)
    value = world.evaluate(statement.value, env)
    span = statement.value.span
    what = f"der({path_of(target)})" if rate else path_of(target)
    if isinstance(target, syntax.Index):
        index = world.quantities.component_index(target, env, symbols.shape, state.path)
        places = [ordinal(index, symbols.shape)]
        value = fit_shape(world.dag, value, (), span, f"`{what}`")
    else:
        places = list(range(len(symbols.nodes)))
        value = fit_shape(world.dag, value, symbols.shape, span, f"`{what}`")
    for place, node, unit in zip(places, value.nodes, value.units, strict=True):
        declared = symbols.units[place]
        expected = divide(declared, SECOND) if rate and declared is not None else declared
        _check_unit(unit, expected, span, f"`{what}`")
        key = state.first + place
        if key in found:
            raise BgError([names.given_twice(target.span, what, found[key][1])])
        found[key] = (node, target.span)


def _check_unit(found: Dimension | None, expected: Dimension | None, span: Span, what: str) -> None:
    if found is not None and expected is not None and found != expected:
        raise BgError(
            [values.wrong_unit(span, what, describe_dimension(expected), describe_dimension(found))]
        )


def _read_equation(world: World, equation: syntax.Equation, env: Environment) -> list[Equation]:
    left = world.evaluate(equation.left, env, rates=True)
    right = world.evaluate(equation.right, env, rates=True)
    if left.shape != right.shape:
        right = fit_shape(world.dag, right, left.shape, equation.right.span, "the right side")
    for one, two in zip(left.units, right.units, strict=True):
        _check_unit(two, one, equation.right.span, "the right side")
    dag = world.dag
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
