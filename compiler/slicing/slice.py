"""Remove the states that the scene does not need: those that nothing reads or that never change."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from bgc.algebra.dag import Kind
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import Guard, Node
from bgc.ir.program import (
    Closures,
    Dropped,
    Energy,
    GivenValue,
    MassEntry,
    PositiveParameter,
    Program,
    Reason,
    Start,
    StateJump,
)
from bgc.ir.unused import without_settled_jumps, without_unused_divisors
from bgc.slicing.invariants import invariant_states, put_in
from bgc.slicing.keep_patterns import is_kept
from bgc.slicing.sliced_speeds import sliced_speeds


def slice_program(program: Program) -> Program:
    """Remove the states that reach no output, and those that never change.

    Outputs here are observations, requirements, commands to devices, guards, the names in `keep`,
    and the energy accounts if the scene observes one. A scene without any keeps everything, and
    a model without a scene is not sliced. A scene in which nothing moves keeps all states that
    reach its outputs: it is compiled for its modes. `dropped` lists the removed states; the
    outputs are the same functions of time as before.
    """
    if not program.scene.name or not _roots(program):
        return program
    if not program.scene.accounts:
        zero = program.dag.zero
        program = replace(program, energy=Energy(zero, zero, zero))
    program = without_unread(program)
    values = invariant_states(program)
    if len(values) < len(program.states):
        program = without_unread(_without_invariants(program, values))
    return _without_useless_checks(without_settled_jumps(program))


# --- cone of influence ------------------------------------------------------------------------


def without_unread(program: Program) -> Program:
    """Remove the states that reach none of the outputs."""
    reached, held = _reached(program, _roots(program))
    program = _with_held(program, held)
    unread = [k for k in range(len(program.states)) if k not in reached]
    return _without(program, dict.fromkeys(unread, Reason.UNREAD), {})


def _roots(program: Program) -> list[Node]:
    roots = [o.node for o in program.observations]
    roots += [r.node for r in program.requirements]
    roots += [value for device in program.devices for value in device.values]
    roots += [guard.condition for guard in program.guards]
    if program.closures is not None:  # a chain is closed as a whole
        roots += [*program.closures.flows, *program.closures.conditions]
    if program.scene.accounts:
        roots += [program.energy.stored, program.energy.supplied, program.energy.dissipated]
        roots += [
            program.dag.symbol(Kind.INPUT, k)
            for energies in program.coupling_energies
            for k in energies
        ]
    roots += [
        program.dag.symbol(Kind.STATE, index)
        for index, state in enumerate(program.states)
        if is_kept(state.name, program.kept)
    ]
    roots += [
        program.dag.symbol(Kind.INPUT, held.index)
        for held in program.held
        if is_kept(held.name, program.kept)
    ]
    return roots


def _reached(program: Program, roots: Sequence[Node]) -> tuple[Collection[int], Collection[int]]:
    """The states that the roots depend on, directly or through the equations.

    Also the INPUT symbols of the held values that they depend on, through sampled parts too.
    """
    dag = program.dag
    columns: dict[int, list[int]] = {}
    for entry in program.mass or ():
        columns.setdefault(entry.row, []).append(entry.column)
    resets: dict[int, list[Node]] = {}
    for jump in program.jumps:
        for reset in jump.resets:
            resets.setdefault(reset.state, []).extend((jump.condition, reset.value))
    updates = {held.index: [held.update] for held in program.held}
    for fmu in program.fmus:  # all that it gives depends on all that it takes
        for symbol in map(dag.symbol_of, fmu.symbols):
            assert symbol is not None
            updates[symbol.index] += fmu.symbols
    seen: set[Node] = set()
    reached: set[int] = set()
    held: set[int] = set()
    stack = list(roots)
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        stack.extend(dag.operands(node))
        symbol = dag.symbol_of(node)
        if symbol is not None and symbol.kind is Kind.STATE:
            reached.add(symbol.index)
            state = program.states[symbol.index]
            stack.append(state.derivative)
            stack.extend([] if state.projection is None else [state.projection])
            stack.extend(dag.symbol(Kind.STATE, k) for k in columns.get(symbol.index, ()))
            stack.extend(resets.get(symbol.index, ()))
        elif symbol is not None and symbol.kind is Kind.INPUT and symbol.index in updates:
            held.add(symbol.index)
            stack += updates[symbol.index]
    return reached, held


def _with_held(program: Program, indices: Collection[int]) -> Program:
    """Keep the held values of some INPUT symbols, and the rates that they have."""
    left = [held for held in program.held if held.index in indices]
    used = sorted({held.rate for held in left})
    number = {old: new for new, old in enumerate(used)}
    kept = {program.dag.symbol(Kind.INPUT, index) for index in indices}
    return replace(
        program,
        held=tuple(replace(held, rate=number[held.rate]) for held in left),
        rates=tuple(program.rates[old] for old in used),
        fmus=tuple(f for f in program.fmus if not kept.isdisjoint(f.symbols)),
    )


# --- invariants -------------------------------------------------------------------------------


def _without_invariants(program: Program, values: Mapping[int, Node]) -> Program:
    """Substitute the values of the states that never change."""
    zero = program.dag.zero
    reasons = {k: Reason.ZERO if v == zero else Reason.CONSTANT for k, v in values.items()}
    smaller = _without(program, reasons, values)
    return replace(smaller, guards=tuple(g for g in smaller.guards if not _holds(smaller, g)))


def _holds(program: Program, guard: Guard) -> bool:
    """Return whether a condition is now always true."""
    return bool(program.dag.value(guard.condition))


# --- shared by both ---------------------------------------------------------------------------


def _without(
    program: Program, reasons: Mapping[int, Reason], values: Mapping[int, Node]
) -> Program:
    """Remove states and renumber the others."""
    left = [k for k in range(len(program.states)) if k not in reasons]
    number = {old: new for new, old in enumerate(left)}
    dropped = (Dropped(program.states[k].name, reason) for k, reason in reasons.items())
    smaller = replace(
        program,
        states=tuple(program.states[old] for old in left),
        mass=_mass(program.mass, number),
        closures=_closures(program.closures, number),
        dropped=(*program.dropped, *dropped),
        start=_start(program.start, number),
        given=_given(program, {*number, *values}),
        jumps=_jumps(program.jumps, number),
        speeds=sliced_speeds(program, values, number),
    )
    smaller = without_unused_divisors(smaller)
    dag = program.dag
    moved = {k: dag.symbol(Kind.STATE, new) for k, new in number.items()}
    new = put_in(smaller, nodes_of(smaller), {**values, **moved})
    return map_nodes(smaller, dag, new.__getitem__)


def _start(start: Start | None, number: Mapping[int, int]) -> Start | None:
    """The equations of the start, as far as the states that are left need them."""
    if start is None:
        return None
    left = tuple((number[k], node) for k, node in start.values if k in number)
    return replace(start, values=left) if left else None


def _given(program: Program, left: Collection[int]) -> tuple[GivenValue, ...]:
    """The given values that need no other state than some."""
    states = {program.dag.symbol(Kind.STATE, k) for k in range(len(program.states))}
    states -= {program.dag.symbol(Kind.STATE, k) for k in left}
    return tuple(
        given
        for given in program.given
        if states.isdisjoint(program.dag.reachable([given.node, given.value]))
    )


def _mass(
    mass: tuple[MassEntry, ...] | None, number: Mapping[int, int]
) -> tuple[MassEntry, ...] | None:
    if mass is None:
        return None
    return tuple(
        MassEntry(number[entry.row], number[entry.column], entry.value)
        for entry in mass
        if entry.row in number and entry.column in number
    )


def _jumps(jumps: Sequence[StateJump], number: Mapping[int, int]) -> tuple[StateJump, ...]:
    """The jumps of the states that are left."""
    found = []
    for jump in jumps:
        left = (replace(r, state=number[r.state]) for r in jump.resets if r.state in number)
        found.append(replace(jump, resets=tuple(left)))
    return tuple(jump for jump in found if jump.resets)


def _closures(closures: Closures | None, number: Mapping[int, int]) -> Closures | None:
    if closures is None:
        return None
    impulses = [i for i, k in enumerate(closures.impulses) if k in number]
    moved = [i for i, k in enumerate(closures.moved) if k in number]
    return replace(
        closures,
        impulses=tuple(number[closures.impulses[i]] for i in impulses),
        moved=tuple(number[closures.moved[i]] for i in moved),
        by_impulse=tuple(tuple(row[i] for i in impulses) for row in closures.by_impulse),
        response=tuple(closures.response[i] for i in impulses),
        by_place=tuple(tuple(row[i] for i in moved) for row in closures.by_place),
        by_start=tuple(closures.by_start[i] for i in moved),
    )


def _without_useless_checks(program: Program) -> Program:
    """Remove checks of nodes that no longer appear.

    Bounds and checks of symmetry stay as long as one of their parameters appears.
    """
    dag, bare = program.dag, replace(program, positive=(), parameters=())
    used = set(dag.reachable(nodes_of(bare)))

    def is_used(check: PositiveParameter) -> bool:
        if not check.bound and check.symmetric is None:
            return check.node in used
        return not used.isdisjoint(dag.symbols_in([check.node]))

    return replace(program, positive=tuple(filter(is_used, program.positive)))
