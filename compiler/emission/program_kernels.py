"""The kernels of a program: the C functions with their arguments and what each stores."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.emission.after_rates import kept_for
from bgc.emission.watches import WatchedArgument
from bgc.ir.graph import Node
from bgc.ir.lowered import SCRATCH, Jacobian, Kernel, Reads, Store, Switch
from bgc.ir.program import Closures, PositiveParameter, Program

_RUNNING = "h t x u"


def program_kernels(
    program: Program, switches: tuple[Switch, ...], jacobian: Jacobian
) -> tuple[Kernel, ...]:
    """All kernels except `prepare`, those of the integration loop first."""
    kept = kept_for(
        program.dag, [s.derivative for s in program.states], [s.argument for s in switches]
    )
    return (
        *_step_kernels(program, jacobian, kept),
        *_event_kernels(program, switches, kept),
        *_jump_kernels(program, switches),
        *_sampled_kernels(program),
        *_setup_kernels(program),
        *_start_kernels(program),
        *_given_kernel(program),
    )


def hoisted_kernel(
    name: str,
    purpose: str,
    inputs: str,
    results: str,
    stores: Iterable[Store],
    *,
    in_place: bool = False,
    found: tuple[Node, ...] = (),
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
        found,
    )


def _step_kernels(program: Program, jacobian: Jacobian, kept: tuple[Node, ...]) -> Iterator[Kernel]:
    """The kernels that are evaluated within steps and at rows; `rhs` leaves `kept` in w."""
    energy = program.energy
    yield hoisted_kernel(
        "rhs",
        "The right-hand sides f of M y' = f.",
        _RUNNING,
        "f",
        (*stores("f", (s.derivative for s in program.states)), *stores(SCRATCH, kept)),
    )
    yield hoisted_kernel(
        "jacobian",
        "The entries of df/dx in the order of jac_row and jac_col, and df/dt."
        if jacobian.inner == 0
        else "The entries in the order of local_row and local_col, and df/dt.",
        _RUNNING,
        "jac dfdt",
        (*stores("jac", jacobian.entries), *stores("dfdt", jacobian.by_time)),
    )
    yield hoisted_kernel(
        "energy",
        "Stored energy, supplied power, dissipated power.",
        _RUNNING,
        "out",
        stores("out", (energy.stored, energy.supplied, energy.dissipated)),
    )
    yield hoisted_kernel(
        "outputs",
        "What the scene observes.",
        _RUNNING,
        "y",
        stores("y", (o.node for o in program.observations)),
    )
    yield hoisted_kernel(
        "commands",
        "Commands to the devices.",
        _RUNNING,
        "c",
        stores("c", (value for d in program.devices for value in d.values)),
    )


def _event_kernels(
    program: Program, switches: tuple[Switch, ...], kept: tuple[Node, ...]
) -> Iterator[Kernel]:
    """The kernels of asserts, projections, switches and divisors; only asserts may be empty.

    `kept` are nodes of `rhs` with which the arguments of switches cost little.
    """
    yield hoisted_kernel(
        "asserts",
        "Conditions that have to hold: nonzero where they do.",
        _RUNNING,
        "a",
        stores("a", (g.condition for g in program.guards)),
    )
    projections = [
        Store("x", index, state.projection)
        for index, state in enumerate(program.states)
        if state.projection is not None
    ]
    if projections:
        yield hoisted_kernel(
            "project",
            "States that are set after each completed step.",
            "h t",
            "x",
            projections,
            in_place=True,
        )
    if program.closures is not None:
        yield hoisted_kernel(
            "closures",
            "Flows and conditions that close chains, and their derivatives.",
            _RUNNING,
            "c",
            stores("c", closure_nodes(program.closures)),
        )
    arguments = stores("z", (switch.argument for switch in switches))
    if switches:
        yield hoisted_kernel(
            "switches",
            "The arguments of discontinuous operations.",
            _RUNNING,
            "z",
            arguments,
        )
    if kept:
        yield hoisted_kernel(
            "switches_after_rhs",
            "The same, from what rhs has left in w.",
            _RUNNING,
            "z",
            arguments,
            found=kept,
        )
    timed = [switch.argument for switch in switches if switch.timed]
    if 0 < len(timed) < len(switches):
        yield hoisted_kernel(
            "timed_switches",
            "Those of them that depend on time alone, which come first.",
            _RUNNING,
            "z",
            stores("z", timed),
        )
    if program.divisors:
        yield hoisted_kernel(
            "divisors",
            "Divisors of the right-hand sides that may vanish.",
            _RUNNING,
            "z",
            stores("z", (divisor.node for divisor in program.divisors)),
        )


def _jump_kernels(program: Program, switches: tuple[Switch, ...]) -> Iterator[Kernel]:
    """The kernels of `when` and `reset`, if there are any."""
    if not program.jumps:
        return
    yield hoisted_kernel(
        "conditions",
        "The conditions of jumps: nonzero where they hold.",
        _RUNNING,
        "c",
        stores("c", (jump.condition for jump in program.jumps)),
    )
    yield hoisted_kernel(
        "resets",
        "The values that jumps give to states.",
        _RUNNING,
        "z",
        stores("z", (reset.value for jump in program.jumps for reset in jump.resets)),
    )
    yield hoisted_kernel(
        "edge_rates",
        "The rates of the arguments of the switches in conditions, from those of the states.",
        f"{_RUNNING} r",
        "z",
        stores("z", _edge_rates(program, [s for s in switches if s.of_jump])),
    )


def _sampled_kernels(program: Program) -> Iterator[Kernel]:
    """The kernels of sampled parts, if there are any."""
    if not program.held:
        return
    yield hoisted_kernel(
        "sampling",
        "The period and the offset of each rate.",
        "h",
        "s",
        stores("s", (node for rate in program.rates for node in (rate.period, rate.offset))),
    )
    yield hoisted_kernel(
        "held_start",
        "The values that sampled parts hold at the start.",
        "h t u",
        "z",
        stores("z", (held.initial for held in program.held)),
    )
    yield hoisted_kernel(
        "held",
        "The values that sampled parts hold from an instant on.",
        _RUNNING,
        "z",
        stores("z", (held.update for held in program.held)),
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


def watch_kernels(watches: Sequence[WatchedArgument]) -> Iterator[Kernel]:
    """The kernel of the watched arguments, if there are any."""
    if watches:
        purpose = "The arguments of functions that may hide pulses."
        yield hoisted_kernel(
            "watched", purpose, _RUNNING, "z", stores("z", (z for _, z in watches))
        )


def range_kernel(timed: tuple[Node, ...]) -> Kernel | None:
    """The kernel of the terms of time alone, for interval arithmetic; None if there are none."""
    purpose = "Ranges of terms of time alone, each with its derivative by time."
    return hoisted_kernel("ranges", purpose, "h t u", "b", stores("b", timed)) if timed else None


def timed_range_kernel(switches: tuple[Switch, ...]) -> Kernel | None:
    """The kernel of the timed switches, for interval arithmetic; None if there are none."""
    purpose = "Ranges of the arguments of switches of time alone, and of their derivatives by time."
    pairs = [(switch.argument, switch.rate) for switch in switches if switch.timed]
    nodes = enumerate(node for pair in pairs for node in pair)
    made = [Store("b", place, node) for place, node in nodes if node is not None]
    return hoisted_kernel("timed_ranges", purpose, "h t u", "b", made) if made else None


def stores(array: str, nodes: Iterable[Node]) -> tuple[Store, ...]:
    """Store nodes in an array, one after the other."""
    return tuple(Store(array, index, node) for index, node in enumerate(nodes))


def closure_nodes(closures: Closures) -> list[Node]:
    """The results of the kernel `closures`, in the order of `bgc_closure_info`."""
    matrices = closures.by_place, closures.by_start
    return [*projection_nodes(closures), *(node for m in matrices for row in m for node in row)]


def projection_nodes(closures: Closures) -> list[Node]:
    """The first of these results: flows, conditions, dw/dx, and responses to the multipliers."""
    matrices = closures.by_impulse, closures.response
    entries = (node for matrix in matrices for row in matrix for node in row)
    return [*closures.flows, *closures.conditions, *entries]


def _setup_kernels(program: Program) -> Iterator[Kernel]:
    """The kernels that are evaluated once, when parameters are set or a run starts."""
    yield hoisted_kernel(
        "mass",
        "The entries of M in the order of mass_row and mass_col.",
        "h",
        "m",
        stores("m", (entry.value for entry in program.mass or ())),
    )
    yield hoisted_kernel(
        "initial",
        "The states at the start.",
        "h t u",
        "x",
        stores("x", (s.initial for s in program.states)),
    )
    yield hoisted_kernel(
        "scale",
        "The unit in which the error of each state is measured.",
        "h",
        "scale",
        stores("scale", (s.scale for s in program.states)),
    )
    yield hoisted_kernel(
        "positive",
        "Parameters and expressions of them that have to be positive.",
        "p h",
        "check",
        stores("check", _checks(program)),
    )


def _start_kernels(program: Program) -> Iterator[Kernel]:
    """The kernels that solve for initial values without a closed form, if there are any."""
    if program.start is None:
        return
    dag, residuals = program.dag, program.start.residuals
    unknowns = [dag.symbol(Kind.START, k) for k in range(len(residuals))]
    slopes = [x for node in residuals for x in gradient(dag, node, unknowns)]
    yield hoisted_kernel(
        "start",
        "The residuals of the equations of the start, and their Jacobian row by row.",
        "h t u s",
        "r j",
        (*stores("r", residuals), *stores("j", slopes)),
    )
    yield hoisted_kernel(
        "started",
        "The states that the solution of these equations gives.",
        "h t u s",
        "x",
        (Store("x", number, node) for number, node in program.start.values),
    )


def _given_kernel(program: Program) -> Iterator[Kernel]:
    """The kernel that compares the start with what is given for it, if anything is."""
    if program.given:
        pairs = (node for given in program.given for node in (given.node, given.value))
        yield hoisted_kernel(
            "given",
            "Initial values that are given: what each is, and what it has to be.",
            _RUNNING,
            "g",
            stores("g", pairs),
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
