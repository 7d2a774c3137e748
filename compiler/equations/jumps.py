"""Resolve jumps: the states that `reset` sets, and values and conditions in terms of states."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from bgc.algebra.dag import Kind
from bgc.diagnostics.catalogue import jumps as messages
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.loops.substitution import Resolver
from bgc.equations.storage.kinds import IntegratedState
from bgc.ir.graph import FlatGraph, Node, Reset, Storage
from bgc.ir.program import Program, StateJump, StateReset
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class _Stored:
    """The storage states of a program, and the elements of the graph that hold them."""

    graph: FlatGraph
    states: Sequence[IntegratedState]

    def owner(self, target: Node) -> Storage | None:
        """The storage element of a displacement or momentum symbol; None of any other."""
        symbol = self.graph.dag.leaf(target)
        if symbol.kind not in {Kind.DISPLACEMENT, Kind.MOMENTUM}:
            return None
        return next(
            element
            for element in self.graph.elements
            if isinstance(element, Storage)
            and 0 <= symbol.index - element.first_state < len(element.ports)
        )

    def sharing(self, name: str) -> list[str]:
        """The other elements whose values depend on those of an element."""
        shared = (s.stores for s in self.states if name in s.stores)
        return list(dict.fromkeys(n for names in shared for n in names if n != name))


def resolve_jumps(
    graph: FlatGraph,
    resolver: Resolver,
    numbers: Mapping[Node, int],
    stored: Sequence[IntegratedState],
) -> tuple[StateJump, ...]:
    """The jumps of a graph in terms of the program's states.

    Raises
    ------
    BgError
        BG482: a target is the displacement or momentum of dependent storage.
    """
    storage = _Stored(graph, stored)
    return tuple(
        StateJump(
            resolver.resolve(jump.condition),
            tuple(
                StateReset(_state_of(reset, storage, numbers), resolver.resolve(reset.value))
                for reset in jump.resets
            ),
            jump.span,
        )
        for jump in graph.jumps
    )


def _state_of(reset: Reset, storage: _Stored, numbers: Mapping[Node, int]) -> int:
    owner, number = storage.owner(reset.target), numbers.get(reset.target)
    others = [] if owner is None else storage.sharing(owner.name)
    if number is None or others:
        declared = None if owner is None else owner.span
        raise BgError([messages.dependent_reset(reset.span, reset.name, others, declared)])
    return number


def require_free(graph: FlatGraph, program: Program) -> None:
    """Refuse resets of what closed chains determine, and of states that no rate integrates.

    Raises
    ------
    BgError
        BG482: a reset of a momentum or displacement in a closed chain. BG481: a reset of a state
        that equations determine at each instant.
    """
    closures = program.closures
    chained: Collection[int] = ()
    if closures is not None:
        chained = {*closures.impulses, *closures.moved}
    integrated = set(range(len(program.states)))
    if program.mass is not None:
        integrated = {entry.column for entry in program.mass if entry.value != program.dag.zero}
    for jump, raw in zip(program.jumps, graph.jumps, strict=True):
        for reset, source in zip(jump.resets, raw.resets, strict=True):
            if reset.state in chained:
                raise BgError([messages.dependent_reset(source.span, source.name, [], None)])
            if reset.state not in integrated:
                why = "equations determine it at each instant"
                raise BgError([messages.not_resettable(source.span, source.name, why)])


def reset_places(jumps: Sequence[StateJump]) -> dict[int, StateJump]:
    """The first jump that resets each state."""
    found: dict[int, StateJump] = {}
    for jump in jumps:
        for reset in jump.resets:
            found.setdefault(reset.state, jump)
    return found
