"""Lower a program to the contents of its C functions."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.emission.differentiate import differentiate, differentiate_within, operation_count
from bgc.emission.factorisation import choose_blocks
from bgc.emission.implicit_speeds import implicit_forms
from bgc.emission.kernels import hoisted_nodes
from bgc.emission.optimise import number_values
from bgc.emission.print_lu import solve_operations
from bgc.emission.sparse import entries_of_matrix, plan_lu
from bgc.emission.switches import hold_modes
from bgc.emission.timed_terms import find_timed_terms
from bgc.emission.watches import WatchedArgument, find_watches
from bgc.ir.graph import Node
from bgc.ir.lowered import Jacobian, Kernel, Lowered, LuPlan, Reads, Store, Switch
from bgc.ir.program import Closures, MassEntry, PositiveParameter, Program
from bgc.ir.program_nodes import map_program, program_roots

_RUNNING = "h t x u"


def lower(program: Program) -> Lowered:
    """Differentiate an optimised program, plan its linear algebra and list its kernels.

    The result has its own program on its own DAG, to which all its nodes belong.
    """
    program, switches, jacobian, timed, plan = _planned(*hold_modes(program))
    program = replace(program, closures=_moving(program.dag, program.closures))
    watches = find_watches(program)
    kernels = (*_kernels(program, switches, jacobian), *_watch_kernels(watches))
    ranges = _range_kernel(timed)
    watching = () if ranges is None else (ranges,)
    for kernel in (*kernels, *watching):
        _verify(program.dag, kernel)
    hoisted = hoisted_nodes(program.dag, (*kernels, *watching))
    prepare = Kernel(
        "prepare",
        "Everything that depends on parameters alone.",
        ("p",),
        ("h",),
        Reads.PARAMETERS,
        _stores("h", hoisted),
    )
    plan = plan_lu(program, jacobian)
    return Lowered(
        program=program,
        switches=switches,
        jacobian=jacobian,
        plan=plan,
        hoisted=hoisted,
        kernels=(prepare, *kernels),
        watches=watches,
        ranges=ranges,
        blocks=choose_blocks(plan, entries_of_matrix(program, jacobian)),
    )


def _moving(dag: Dag, closures: Closures | None) -> Closures | None:
    """Closed chains without those that stand still, on which slicing left nothing to act."""
    if closures is None:
        return None
    kept = [k for k, row in enumerate(closures.by_impulse) if any(x != dag.zero for x in row)]
    others = [k for k in range(len(closures.flows)) if k >= closures.kept or k not in kept]
    moving = replace(
        closures,
        chain_of=tuple(closures.chain_of[k] for k in kept),
        flows=tuple(closures.flows[k] for k in (*kept, *others)),
        kept=len(kept),
        by_impulse=tuple(closures.by_impulse[k] for k in kept),
        response=tuple(tuple(row[k] for k in kept) for row in closures.response),
    )
    return moving if moving.kept or moving.moved else None


def _with_stored_mass(program: Program, jacobian: Jacobian) -> Program:
    """Store one zero in an empty mass matrix, since the runtime takes no entries as identity."""
    if program.mass != () or not program.states:
        return program
    place = next(zip(jacobian.rows, jacobian.columns, strict=True), (0, 0))
    return replace(program, mass=(MassEntry(*place, program.dag.zero),))


def _verify(dag: Dag, kernel: Kernel) -> None:
    """Assert that a kernel's nodes depend on its arguments only."""
    arguments = {*kernel.inputs, *(kernel.results if kernel.in_place else ())}
    if "s" in kernel.inputs:
        held = {
            s.kind for s in map(dag.symbol_of, dag.reachable(s.node for s in kernel.stores)) if s
        }
        assert Kind.STATE not in held, f"{kernel.name} reads states"
    elif "x" not in arguments:
        highest = Level.TIME if "t" in arguments else Level.PARAM
        for store in kernel.stores:
            assert dag.level[store.node] <= highest, f"{kernel.name} reads what it is not given"
    elif "u" not in arguments:
        symbols = (dag.symbol_of(n) for n in dag.reachable(s.node for s in kernel.stores))
        inputs = [s for s in symbols if s is not None and s.kind is Kind.INPUT]
        assert not inputs, f"{kernel.name} reads device inputs"


_Planned = tuple[Program, tuple[Switch, ...], Jacobian, tuple[Node, ...], LuPlan]
_SOLUTIONS = 6  # for each Jacobian: of ros34prw 4, of rodas5p 8
_GAIN = 0.9  # of the operations: what takes more is not worth inner unknowns
_LEAST = 2_000  # operations that are worth a comparison
_KEPT_GAIN = (
    0.75  # solutions along a chain take longer than their operations: one waits for another
)
_LARGE = 20_000  # operations from which on intermediate values may be worth keeping


def _planned(program: Program, switches: tuple[Switch, ...]) -> _Planned:
    """The Jacobian of a program and the plan of its factorisation, in the form of least cost.

    With the results of `_optimised`.
    """
    forms = implicit_forms(program)
    if forms is None:
        return _with_plan(_optimised(*differentiate(program), switches))
    other = _with_plan(_optimised(*forms.accumulated(), switches))
    cost = _cost(other)
    if cost > _LARGE:
        kept = forms.with_kept_vertices(cost - _SOLUTIONS * _solution(other))
        if kept is not None:
            narrow = _with_plan(_optimised(*kept, switches))
            if _cost(narrow) < _KEPT_GAIN * cost:
                other, cost = narrow, _cost(narrow)
    explicit = differentiate_within(program, max(cost, _LEAST))
    if explicit is None:
        return other
    usual = _with_plan(_optimised(*explicit, switches))
    return other if cost < _GAIN * _cost(usual) and _cost(usual) > _LEAST else usual


def _with_plan(
    optimised: tuple[Program, tuple[Switch, ...], Jacobian, tuple[Node, ...]],
) -> _Planned:
    program, switches, jacobian, timed = optimised
    program = _with_stored_mass(program, jacobian)
    return program, switches, jacobian, timed, plan_lu(program, jacobian)


def _cost(planned: _Planned) -> int:
    """The operations of a Jacobian, its factorisation and the solutions with it."""
    program, _, jacobian, _, plan = planned
    made = operation_count(program.dag, jacobian) + plan.operations
    return made + _SOLUTIONS * _solution(planned)


def _solution(planned: _Planned) -> int:
    """The operations of one solution."""
    return solve_operations(planned[4], len(planned[0].states))


def _optimised(
    program: Program, jacobian: Jacobian, switches: tuple[Switch, ...]
) -> tuple[Program, tuple[Switch, ...], Jacobian, tuple[Node, ...]]:
    """Optimise a differentiated program with its Jacobian; zero entries are removed.

    Also returns the terms of time alone, each followed by its derivative.
    """
    timed = tuple(chain.from_iterable(find_timed_terms(program, switches)))
    others = (*jacobian.entries, *jacobian.by_time, *(switch.argument for switch in switches))
    others += timed
    dag, new = number_values(program.dag, (*program_roots(program), *others))
    switches = tuple(replace(switch, argument=new[switch.argument]) for switch in switches)
    kept = [
        (row, column, new[node])
        for row, column, node in zip(jacobian.rows, jacobian.columns, jacobian.entries, strict=True)
        if new[node] != dag.zero
    ]
    optimised = replace(
        jacobian,
        rows=tuple(row for row, _, _ in kept),
        columns=tuple(column for _, column, _ in kept),
        entries=tuple(node for _, _, node in kept),
        by_time=tuple(new[node] for node in jacobian.by_time),
    )
    program = map_program(program, dag, new.__getitem__)
    return program, switches, optimised, tuple(new[node] for node in timed)


def _stores(array: str, nodes: Iterable[Node]) -> tuple[Store, ...]:
    return tuple(Store(array, index, node) for index, node in enumerate(nodes))


def _kernels(
    program: Program, switches: tuple[Switch, ...], jacobian: Jacobian
) -> tuple[Kernel, ...]:
    """All kernels except `prepare`, those of the integration loop first."""
    return (
        *_step_kernels(program, jacobian),
        *_event_kernels(program, switches),
        *_jump_kernels(program, switches),
        *_sampled_kernels(program),
        *_setup_kernels(program),
        *_start_kernels(program),
    )


def _kernel(
    name: str,
    purpose: str,
    inputs: str,
    results: str,
    stores: Iterable[Store],
    *,
    in_place: bool = False,
) -> Kernel:
    """A kernel that reads hoisted nodes; argument names are separated by blanks."""
    return Kernel(
        name,
        purpose,
        tuple(inputs.split()),
        tuple(results.split()),
        Reads.HOISTED,
        tuple(stores),
        in_place,
    )


def _step_kernels(program: Program, jacobian: Jacobian) -> Iterator[Kernel]:
    """The kernels that are evaluated within steps and at rows."""
    energy = program.energy
    yield _kernel(
        "rhs",
        "The right-hand sides f of M y' = f.",
        _RUNNING,
        "f",
        _stores("f", (s.derivative for s in program.states)),
    )
    yield _kernel(
        "jacobian",
        "The entries of df/dx in the order of jac_row and jac_col, and df/dt."
        if jacobian.inner == 0
        else "The entries in the order of local_row and local_col, and df/dt.",
        _RUNNING,
        "jac dfdt",
        (*_stores("jac", jacobian.entries), *_stores("dfdt", jacobian.by_time)),
    )
    yield _kernel(
        "energy",
        "Stored energy, supplied power, dissipated power.",
        _RUNNING,
        "out",
        _stores("out", (energy.stored, energy.supplied, energy.dissipated)),
    )
    yield _kernel(
        "outputs",
        "What the scene observes.",
        _RUNNING,
        "y",
        _stores("y", (o.node for o in program.observations)),
    )
    yield _kernel(
        "commands",
        "What the devices are told.",
        _RUNNING,
        "c",
        _stores("c", (value for d in program.devices for value in d.values)),
    )


def _event_kernels(program: Program, switches: tuple[Switch, ...]) -> Iterator[Kernel]:
    """The kernels of asserts, projections, switches and divisors; only asserts may be empty."""
    yield _kernel(
        "asserts",
        "Conditions that have to hold: nonzero where they do.",
        _RUNNING,
        "a",
        _stores("a", (g.condition for g in program.guards)),
    )
    projections = [
        Store("x", index, state.projection)
        for index, state in enumerate(program.states)
        if state.projection is not None
    ]
    if projections:
        yield _kernel(
            "project",
            "States that are set after each completed step.",
            "h t",
            "x",
            projections,
            in_place=True,
        )
    if program.closures is not None:
        yield _kernel(
            "closures",
            "Flows and conditions that close chains, and their derivatives.",
            _RUNNING,
            "c",
            _stores("c", closure_nodes(program.closures)),
        )
    if switches:
        yield _kernel(
            "switches",
            "The arguments of discontinuous operations.",
            _RUNNING,
            "z",
            _stores("z", (switch.argument for switch in switches)),
        )
    if program.divisors:
        yield _kernel(
            "divisors",
            "Divisors of the right-hand sides that may vanish.",
            _RUNNING,
            "z",
            _stores("z", (divisor.node for divisor in program.divisors)),
        )


def _jump_kernels(program: Program, switches: tuple[Switch, ...]) -> Iterator[Kernel]:
    """The kernels of `when` and `reset`, if there are any."""
    if not program.jumps:
        return
    yield _kernel(
        "conditions",
        "The conditions of jumps: nonzero where they hold.",
        _RUNNING,
        "c",
        _stores("c", (jump.condition for jump in program.jumps)),
    )
    yield _kernel(
        "resets",
        "The values that jumps give to states.",
        _RUNNING,
        "z",
        _stores("z", (reset.value for jump in program.jumps for reset in jump.resets)),
    )
    yield _kernel(
        "edge_rates",
        "The rates of the arguments of the switches in conditions, from those of the states.",
        f"{_RUNNING} r",
        "z",
        _stores("z", _edge_rates(program, [s for s in switches if s.of_jump])),
    )


def _sampled_kernels(program: Program) -> Iterator[Kernel]:
    """The kernels of sampled parts, if there are any."""
    if not program.held:
        return
    yield _kernel(
        "sampling",
        "The period and the offset of each rate.",
        "h",
        "s",
        _stores("s", (node for rate in program.rates for node in (rate.period, rate.offset))),
    )
    yield _kernel(
        "held_start",
        "The values that sampled parts hold at the start.",
        "h t u",
        "z",
        _stores("z", (held.initial for held in program.held)),
    )
    yield _kernel(
        "held",
        "The values that sampled parts hold from an instant on.",
        _RUNNING,
        "z",
        _stores("z", (held.update for held in program.held)),
    )


def _edge_rates(program: Program, edges: Sequence[Switch]) -> Iterator[Node]:
    """The derivatives of the arguments of switches by time, in terms of the states' rates."""
    dag = program.dag
    for switch in edges:
        held = (dag.symbol_of(node) for node in dag.reachable([switch.argument]))
        direction = {
            dag.symbol(s.kind, s.index): dag.symbol(Kind.RATE, s.index)
            for s in held
            if s is not None and s.kind is Kind.STATE
        }
        direction[dag.symbol(Kind.TIME)] = dag.one
        yield directional_derivative(dag, switch.argument, direction)


def _watch_kernels(watches: Sequence[WatchedArgument]) -> Iterator[Kernel]:
    """The kernel of the watched arguments, if there are any."""
    if watches:
        purpose = "The arguments of functions that may hide pulses."
        yield _kernel("watched", purpose, _RUNNING, "z", _stores("z", (z for _, z in watches)))


def _range_kernel(timed: tuple[Node, ...]) -> Kernel | None:
    """The kernel of the terms of time alone, for interval arithmetic; None if there are none."""
    purpose = "Ranges of terms of time alone, each with its derivative by time."
    return _kernel("ranges", purpose, "h t u", "b", _stores("b", timed)) if timed else None


def closure_nodes(closures: Closures) -> list[Node]:
    """The results of the kernel `closures`, in the order of `bgc_closure_info`."""
    nodes = [*closures.flows, *closures.conditions]
    for matrix in (closures.by_impulse, closures.response, closures.by_place, closures.by_start):
        nodes += [node for row in matrix for node in row]
    return nodes


def _setup_kernels(program: Program) -> Iterator[Kernel]:
    """The kernels that are evaluated once, when parameters are set or a run starts."""
    yield _kernel(
        "mass",
        "The entries of M in the order of mass_row and mass_col.",
        "h",
        "m",
        _stores("m", (entry.value for entry in program.mass or ())),
    )
    yield _kernel(
        "initial",
        "The states at the start.",
        "h t u",
        "x",
        _stores("x", (s.initial for s in program.states)),
    )
    yield _kernel(
        "scale",
        "The unit in which the error of each state is measured.",
        "h",
        "scale",
        _stores("scale", (s.scale for s in program.states)),
    )
    yield _kernel(
        "positive",
        "Parameters and expressions of them that have to be positive.",
        "p h",
        "check",
        _stores("check", _checks(program)),
    )


def _start_kernels(program: Program) -> Iterator[Kernel]:
    """The kernels that solve for initial values without a closed form, if there are any."""
    if program.start is None:
        return
    dag, residuals = program.dag, program.start.residuals
    unknowns = [dag.symbol(Kind.START, k) for k in range(len(residuals))]
    slopes = [x for node in residuals for x in gradient(dag, node, unknowns)]
    yield _kernel(
        "start",
        "The residuals of the equations of the start, and their Jacobian row by row.",
        "h t u s",
        "r j",
        (*_stores("r", residuals), *_stores("j", slopes)),
    )
    yield _kernel(
        "started",
        "The states that the solution of these equations gives.",
        "h t u s",
        "x",
        (Store("x", number, node) for number, node in program.start.values),
    )


_ROUNDING = Fraction(1, 2**48)  # bound on the relative rounding error of a sum that is zero


def _checks(program: Program) -> list[Node]:
    """Nodes that are positive where the checks hold."""
    return [_positive_where(program.dag, check) for check in program.positive]


def _positive_where(dag: Dag, check: PositiveParameter) -> Node:
    """A node that is positive where a check holds; of a nonzero divisor, its distance from zero."""
    if check.strictly_positive:
        return check.node
    if check.finite:
        return _is_finite(dag, check.node)
    distance = _distance_from_zero(dag, check.node)
    size = dag.call(Op.ABS, check.node)
    divides = any(dag.op[n] == Op.DIV for n in dag.reachable([check.node]))
    if distance == size or not divides:
        return distance
    return dag.select(_is_finite(dag, check.node), distance, size)  # 1/0 is far from zero


def _is_finite(dag: Dag, node: Node) -> Node:
    """1 for a finite value, 0 for an infinite one, NaN for NaN."""
    return dag.call(Op.LE, dag.call(Op.ABS, node), dag.const(sys.float_info.max))


def _distance_from_zero(dag: Dag, node: Node) -> Node:
    """The absolute value of a node, less a bound on the rounding error of its terms."""
    terms, stack, seen = [], [node], set()
    while stack:
        top = stack.pop()
        if top in seen:
            continue
        seen.add(top)
        if dag.op[top] in {Op.ADD, Op.SUB, Op.NEG}:
            stack.extend(dag.operands(top))
        else:
            terms.append(dag.call(Op.ABS, top))
    size = dag.call(Op.ABS, node)
    if len(terms) == 1:
        return size
    return dag.sub(size, dag.mul(dag.const(_ROUNDING), dag.sum(terms)))


def dependent_defaults(program: Program) -> list[tuple[int, Node]]:
    """The index and default of each parameter whose default depends on others."""
    return [
        (parameter.index, parameter.value)
        for parameter in program.parameters
        if _has_symbols(program.dag, parameter.value)
    ]


def _has_symbols(dag: Dag, node: Node) -> bool:
    return any(dag.op[n] == Op.SYMBOL for n in dag.reachable([node]))
