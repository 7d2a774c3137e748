"""Cone of influence: leave out the states that nothing the scene reads depends on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bgc.algebra.dag import Kind
from bgc.emission.rewrite import map_program, program_roots
from bgc.graph import Node
from bgc.program import Energy, MassEntry, Program, ProgramState


def slice_program(program: Program) -> Program:
    """The program without the states that reach no output.

    What is read: observations, requirements, commands to devices, guards, what `keep` names,
    and the energy accounts if the scene observes one. A scene that reads nothing keeps
    everything. What is left out is said in `dropped`.
    """
    roots = _roots(program)
    if not roots:
        return program
    if not program.scene.accounts:
        zero = program.dag.zero
        program = replace(program, energy=Energy(zero, zero, zero))
    kept = _reached(program, roots)
    if len(kept) < len(program.states):
        program = _renumbered(program, kept)
    return _without_useless_checks(program)


def _roots(program: Program) -> list[Node]:
    roots = [o.node for o in program.observations]
    roots += [r.node for r in program.requirements]
    roots += [value for device in program.devices for value in device.values]
    roots += [guard.condition for guard in program.guards]
    if program.scene.accounts:
        roots += [program.energy.stored, program.energy.supplied, program.energy.dissipated]
    roots += [
        program.dag.symbol(Kind.STATE, index)
        for index, state in enumerate(program.states)
        if any(_belongs(state.name, name) for name in program.kept)
    ]
    return roots


def _belongs(state: str, kept: str) -> bool:
    """Whether a state is a part of what `keep` names: itself, `kept.x` or `kept[1]`."""
    return state == kept or state.startswith((f"{kept}.", f"{kept}["))


def _reached(program: Program, roots: Sequence[Node]) -> list[int]:
    """The states that the roots depend on, by way of the equations."""
    dag = program.dag
    columns: dict[int, list[int]] = {}
    for entry in program.mass or ():
        columns.setdefault(entry.row, []).append(entry.column)
    seen: set[Node] = set()
    kept: set[int] = set()
    stack = list(roots)
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        stack.extend(dag.operands(node))
        symbol = dag.symbol_of(node)
        if symbol is not None and symbol.kind is Kind.STATE:
            kept.add(symbol.index)
            state = program.states[symbol.index]
            stack.append(state.derivative)
            stack.extend([] if state.projection is None else [state.projection])
            stack.extend(dag.symbol(Kind.STATE, k) for k in columns.get(symbol.index, ()))
    return sorted(kept)


def _renumbered(program: Program, kept: Sequence[int]) -> Program:
    """The program on some of its states only, numbered anew."""
    dag = program.dag
    number = {old: new for new, old in enumerate(kept)}
    smaller = replace(
        program,
        states=tuple(program.states[old] for old in kept),
        mass=_mass(program.mass, number),
        dropped=(
            *program.dropped,
            *(_said(state) for k, state in enumerate(program.states) if k not in number),
        ),
    )
    moved = {
        dag.symbol(Kind.STATE, old): dag.symbol(Kind.STATE, new) for old, new in number.items()
    }
    roots = program_roots(smaller)
    renumbered = dict(zip(roots, dag.substitute(roots, moved), strict=True))
    return map_program(smaller, dag, renumbered.__getitem__)


def _mass(
    mass: tuple[MassEntry, ...] | None, number: dict[int, int]
) -> tuple[MassEntry, ...] | None:
    if mass is None:
        return None
    return tuple(
        MassEntry(number[entry.row], number[entry.column], entry.value)
        for entry in mass
        if entry.row in number
    )


def _said(state: ProgramState) -> str:
    return f"`{state.name}`: nothing that the scene reads depends on it"


def _without_useless_checks(program: Program) -> Program:
    """Without checks of parameters that nothing is divided by any more."""
    bare = replace(program, positive=(), parameters=())
    used = set(program.dag.reachable(program_roots(bare)))
    return replace(program, positive=tuple(p for p in program.positive if p.node in used))
