"""Derive the state equations: from the causal graph to a program.

Each variable is defined in terms of others (`variables`, `storage`, `inertias`, `motions`). The
definitions are resolved on demand (`loops`), so that only those which states, outputs and guards
need are ever built. The order of the states is: storage (by element), declared, algebraic.
"""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.strong_components import strong_components
from bgc.equations.audit import assert_power_balance
from bgc.equations.closures.close import close_chains
from bgc.equations.closures.multipliers import ClosingRows, closing_rows
from bgc.equations.impulses import impulse_warnings
from bgc.equations.inertias.merged_inertias import merge_inertias
from bgc.equations.instants import without_instants
from bgc.equations.jumps import require_free, resolve_jumps
from bgc.equations.loops.implicit import ImplicitRows, implicit_rows, pair_equations
from bgc.equations.loops.motion_rates import settle_motions
from bgc.equations.loops.start import with_start_values
from bgc.equations.loops.substitution import Resolver, algebraic_states
from bgc.equations.motions.merged_motions import merge_along_motions
from bgc.equations.port_stability import with_port_checks
from bgc.equations.representable import require_representable
from bgc.equations.scales import state_scale, storage_scales
from bgc.equations.speeds import with_speeds
from bgc.equations.start.given import (
    given_of_states,
    resolve_given,
    stiffness_at_start,
    values_to_check,
)
from bgc.equations.start.problem import Problem, start_problem
from bgc.equations.start.solve import with_start
from bgc.equations.storage.accounts import Accounts, energy_accounts
from bgc.equations.storage.independent_states import integrate_alone
from bgc.equations.storage.initial_values import closed_initials
from bgc.equations.storage.kinds import (
    IntegratedState,
    StorageElement,
    columns_of,
    is_independent,
    storage_elements,
)
from bgc.equations.storage.symmetry import symmetry_checks
from bgc.equations.variables.definitions import Variables
from bgc.equations.variables.law_nodes import positive_values
from bgc.ir.causal import CausalGraph, Role
from bgc.ir.fields import nodes_of
from bgc.ir.graph import FlatGraph, Node
from bgc.ir.program import Energy, MassEntry, PositiveParameter, Program, ProgramState
from bgc.ir.unused import without_settled_jumps, without_unused_divisors
from bgc.record_class import dataclass, replace


def derive_equations(causal: CausalGraph) -> Program:
    """Derive the program `M y' = f` of a causal graph.

    Guarantees that nodes hold states, time, inputs and parameters only, that no divisor is
    identically zero, and that algebraic loops have a regular Jacobian. Does not remove what the
    scene does not need (`slicing/slice.py` does).

    Raises
    ------
    BgError
        A law, a loop, an initial value or an equation cannot be used; it names the elements.
    """
    graph = causal.graph
    _note_owners(graph)
    variables = Variables(causal)
    system = _defined(causal, variables)
    unsettled = _resolved(system)
    moving = _with_motions(system, unsettled)
    started = with_start(moving, unsettled.start_rows, unsettled.start, variables)
    warnings = impulse_warnings(variables, system.resolver.rates_read, started.jumps)
    steady = without_instants(replace(started, warnings=warnings))
    if causal.closures:
        require_representable(graph, steady)  # closing a chain computes with its numbers
    closed = close_chains(steady, variables, unsettled.closing)
    require_free(graph, closed)
    solved = with_start_values(closed, range(unsettled.states, len(closed.states)))
    require_representable(graph, solved)
    assert_power_balance(solved)
    needed = without_settled_jumps(without_unused_divisors(solved))
    kept = with_speeds(needed, variables, system.resolver)
    return with_port_checks(kept, graph)


def _note_owners(graph: FlatGraph) -> None:
    """Record of each piecewise operation the first element whose law has it, for messages."""
    dag = graph.dag
    piecewise = {int(op) for op in Op if op.row.jump is not None}
    if not piecewise.isdisjoint(dag.op):
        for element in graph.elements:
            for node in dag.reachable(nodes_of(element), Level.TIME):
                if dag.op[node] in piecewise:
                    dag.owners.setdefault(node, element.name)


@dataclass(frozen=True, slots=True)
class _System:
    """A causal graph with all its variables defined, and the states among them numbered.

    `rows` are the final equations of declared states without a rate, and of declared unknowns.
    """

    causal: CausalGraph
    variables: Variables
    elements: list[StorageElement]
    stored: list[IntegratedState]
    accounts: Accounts | None
    numbers: dict[Node, int]
    resolver: Resolver
    rows: ImplicitRows


@dataclass(frozen=True, slots=True)
class _Unsettled:
    """A program whose rates hold the speeds of free motions and the multipliers of closing rows.

    M and the parameters that divide follow once the speeds are known. The states from number
    `states` on are unknowns of loops. `start` and `start_rows` are the equations of the start,
    `closing` those that close chains.
    """

    program: Program
    states: int
    start: Problem | None
    start_rows: tuple[Node, ...]
    closing: ClosingRows


def _defined(causal: CausalGraph, variables: Variables) -> _System:
    """Define the variables of storage, balances, accounts and equations."""
    graph = causal.graph
    elements = storage_elements(causal, variables)
    stored = _storage_states(causal, variables, elements)
    variables.set_balances()
    accounts = energy_accounts(variables, elements) if graph.scene.accounts else None
    if accounts is not None:
        stored += accounts.states
    numbers = _state_numbers(graph, stored)
    later = variables.speeds.keys() | set(variables.multipliers)
    rates, equation_of = _raw_rates(graph, stored), pair_equations(variables)
    resolver = Resolver(variables, numbers, rates, equation_of, later)
    rows = implicit_rows(variables, resolver, len(stored))
    return _System(causal, variables, elements, stored, accounts, numbers, resolver, rows)


def _resolved(system: _System) -> _Unsettled:
    """Resolve all that states, outputs, jumps, sampled parts and the start read."""
    variables, resolver, stored = system.variables, system.resolver, system.stored
    graph, dag = system.causal.graph, system.variables.dag
    declared = _declared_states(graph, resolver, len(stored), system.rows)
    states = _integrated_states(variables, resolver, stored, system.elements) + declared
    variables.starting |= _started_by_loops(dag, resolver, states, system.elements)
    start = start_problem(variables, resolver, system.elements, stored)
    start_rows = resolver.resolve_all(variables.start_rows)
    accounts = system.accounts
    energy = (dag.zero,) * 3 if accounts is None else resolver.resolve_all(accounts.nodes)
    outputs = _with_outputs(graph, resolver)
    resolver.resolve_all(unknown for _, unknown in variables.equations)  # none is ill-posed
    held = tuple(replace(h, update=resolver.resolve(h.update)) for h in graph.held)
    jumps = resolve_jumps(graph, resolver, system.numbers, stored)
    divisors = [replace(d, node=resolver.resolve(d.node)) for d in variables.raw_divisors]
    closing = closing_rows(variables, resolver)
    given = resolve_given(variables, resolver, system.elements)
    given += given_of_states(graph, states)
    count = len(states)
    states += algebraic_states(variables, resolver)
    states = _with_closed_initials(graph, states)
    free = () if start is None else start.free
    program = Program(
        dag=dag,
        scene=graph.scene,
        parameters=graph.parameters,
        states=tuple(states),
        mass=None,
        inputs=sum(len(device.inputs) for device in graph.devices) + graph.varied + len(graph.held),
        observations=outputs.observations,
        requirements=outputs.requirements,
        devices=outputs.devices,
        guards=outputs.guards,
        energy=Energy(*energy),
        positive=(),
        dropped=(),
        kept=graph.kept,
        divisors=(*divisors, *resolver.divisors),
        jumps=jumps,
        held=held,
        rates=graph.rates,
        fmus=graph.fmus,
        coupling_energies=tuple(port.coupling_energies for port in graph.ports),
        slots=len(graph.held),
        given=values_to_check(variables, given, states, free),
        ignored_defaults=tuple(dict.fromkeys(variables.ignored_defaults)),
    )
    return _Unsettled(program, count, start, start_rows, closing)


def _with_motions(system: _System, unsettled: _Unsettled) -> Program:
    """Settle the speeds of motions, and list all loops, and all that their pivots rely on."""
    variables, resolver = system.variables, system.resolver
    settled, speeds = settle_motions(unsettled.program, variables, resolver, system.numbers)
    added = algebraic_states(variables, speeds)
    size = len(settled.states) + len(added)
    return replace(
        settled,
        states=(*settled.states, *added),
        mass=_mass(system.causal.graph, len(system.stored), size, system.rows),
        divisors=(*settled.divisors, *speeds.divisors),
        positive=_positive(system.causal, variables, system.elements),
        loops=(*resolver.loops, *speeds.loops),
    )


# --- states -----------------------------------------------------------------------------------


def _storage_states(
    causal: CausalGraph, variables: Variables, elements: Sequence[StorageElement]
) -> list[IntegratedState]:
    columns = columns_of(elements, Role.INERTIA)
    states: list[IntegratedState] = []
    merged: list[StorageElement] = []
    for element in elements:
        if is_independent(causal, element, columns):
            states.extend(integrate_alone(variables, element))
        else:
            merged.append(element)
    states += merge_inertias(variables, merged)
    return merge_along_motions(variables, elements, states)


def _state_numbers(graph: FlatGraph, stored: Sequence[IntegratedState]) -> dict[Node, int]:
    """Map the raw symbols that are states to their indices in the program."""
    dag = graph.dag
    symbols = [state.symbol for state in stored]
    symbols += [dag.symbol(Kind.STATE, state.index) for state in graph.states]
    symbols += [dag.symbol(Kind.UNKNOWN, unknown.index) for unknown in graph.unknowns]
    return {symbol: number for number, symbol in enumerate(symbols)}


def _raw_rates(graph: FlatGraph, stored: Sequence[IntegratedState]) -> dict[int, Node]:
    """Map state indices to raw derivatives, where these are assignments."""
    rates = {number: state.derivative for number, state in enumerate(stored)}
    for state in graph.states:
        if state.derivative is not None:
            rates[len(stored) + state.index] = state.derivative
    return rates


def _integrated_states(
    variables: Variables,
    resolver: Resolver,
    stored: Sequence[IntegratedState],
    elements: Sequence[StorageElement],
) -> list[ProgramState]:
    scales = storage_scales(variables.causal, elements)
    stiffness = stiffness_at_start(variables, elements)
    one = variables.dag.one
    return [
        ProgramState(
            name=state.name,
            unit=state.unit,
            kind=state.kind,
            initial=resolver.resolve(state.initial),
            derivative=resolver.resolve(state.derivative),
            projection=None,
            scale=state_scale(scales, state, one),
            stores=state.stores,
            stiffness=stiffness.get(state.symbol, 0.0),
        )
        for state in stored
    ]


def _started_by_loops(
    dag: Dag, resolver: Resolver, states: list[ProgramState], elements: Sequence[StorageElement]
) -> set[int]:
    """The elements whose initial states are not known before, since they depend on loops.

    A modulus that reads a flow or momentum of the elements that it connects is such a loop. Where
    an initial state depends on itself, it is set to zero until the start is solved.
    """
    unknowns = set(resolver.residuals)
    late = {k for k, s in enumerate(states) if unknowns & set(dag.reachable([s.initial]))}
    for k in _circular(dag, [state.initial for state in states]):
        if states[k].stores:
            late.add(k)
            states[k] = replace(states[k], initial=dag.zero)
    names = {name for k in late for name in states[k].stores}
    return {e.ports[0].port.element for e in elements if e.storage.name in names}


def _circular(dag: Dag, initials: Sequence[Node]) -> list[int]:
    """The states whose initial values depend on themselves."""
    size = len(initials)  # the unknowns of loops are numbered behind
    needs = [
        [s.index for s in dag.symbols_in([x], Kind.STATE).values() if s.index < size]
        for x in initials
    ]
    found, done = list[int](), set[int]()
    for root in range(size):
        for members, has_cycle in strong_components(root, needs.__getitem__, done.__contains__):
            done.update(members)
            found += members if has_cycle else []
    return found


def _declared_states(
    graph: FlatGraph, resolver: Resolver, first: int, rows: ImplicitRows
) -> list[ProgramState]:
    """Declared states, then declared unknowns."""
    one = graph.dag.one
    states = []
    for state in graph.states:
        derivative = (
            rows[first + state.index][0]
            if state.derivative is None
            else resolver.resolve(state.derivative)
        )
        projection = None if state.projection is None else resolver.resolve(state.projection)
        initial = resolver.resolve(state.initial)
        states.append(
            ProgramState(
                state.name,
                state.unit,
                "declared",
                initial,
                derivative,
                projection,
                one,
                shown=state.shown,
            )
        )
    first += len(graph.states)
    for unknown in graph.unknowns:
        right, entries = rows[first + unknown.index]
        kind = "declared" if entries else "algebraic"
        initial = resolver.resolve(unknown.start)
        states.append(
            ProgramState(
                unknown.name, unknown.unit, kind, initial, right, None, one, shown=unknown.shown
            )
        )
    return states


def _with_closed_initials(graph: FlatGraph, states: Sequence[ProgramState]) -> list[ProgramState]:
    spans = {state.name: state.span for state in graph.states}
    places = [(state.name, spans.get(state.name)) for state in states]
    closed = closed_initials(graph.dag, [state.initial for state in states], places)
    return [replace(state, initial=initial) for state, initial in zip(states, closed, strict=True)]


def _mass(
    graph: FlatGraph, first: int, size: int, rows: ImplicitRows
) -> tuple[MassEntry, ...] | None:
    """The mass matrix; None where it is the identity.

    Rows of equations are the user's, rows of loops (the last states) are zero.
    """
    one = graph.dag.one
    loops = first + len(graph.states) + len(graph.unknowns)
    entries: list[MassEntry] = []
    for row in range(size):
        if row in rows:
            columns = sorted(rows[row][1].items())
            entries.extend(MassEntry(row, column, value) for column, value in columns)
        elif row < loops:
            entries.append(MassEntry(row, row, one))
    identity = [MassEntry(row, row, one) for row in range(size)]
    return None if entries == identity else tuple(entries)


def _positive(
    causal: CausalGraph, variables: Variables, elements: Sequence[StorageElement]
) -> tuple[PositiveParameter, ...]:
    """The divisors of parameter level, each with its strictest condition."""
    found = {p.node: p for p in (*causal.positive, *variables.watched)}
    for element in elements:
        for p in positive_values(causal.graph.dag, element.storage):
            found[p.node] = p
    level = causal.graph.dag.level
    for rate in causal.graph.rates:
        if level[rate.period] == Level.PARAM:
            found[rate.period] = PositiveParameter(
                rate.period, "the period of a sampled part must be positive", True
            )
        if level[rate.offset] == Level.PARAM:
            found.setdefault(
                rate.offset,
                PositiveParameter(
                    rate.offset, "the offset of a sampled part must be finite", False, finite=True
                ),
            )
    return (*found.values(), *symmetry_checks(variables))


# --- outputs ----------------------------------------------------------------------------------


def _with_outputs(graph: FlatGraph, resolver: Resolver) -> FlatGraph:
    """The graph with everything that the scene reads resolved."""
    resolve = resolver.resolve
    return replace(
        graph,
        observations=tuple(replace(o, node=resolve(o.node)) for o in graph.observations),
        requirements=tuple(replace(r, node=resolve(r.node)) for r in graph.requirements),
        devices=tuple(replace(d, values=resolver.resolve_all(d.values)) for d in graph.devices),
        guards=tuple(replace(g, condition=resolve(g.condition)) for g in graph.guards),
    )
