"""Choose the form of the Jacobian that costs least, with the plan of its factorisation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import chain

from bgc.emission.differentiate import differentiate, differentiate_within, operation_count
from bgc.emission.implicit_speeds import implicit_forms
from bgc.emission.print_lu import solve_operations
from bgc.emission.simplification import number_values
from bgc.emission.sparse import mass_places, plan_lu, plan_pattern
from bgc.emission.timed_terms import find_timed_terms, with_rates
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import Node
from bgc.ir.lowered import Jacobian, LuPlan, Switch
from bgc.ir.program import MassEntry, Program

Planned = tuple[Program, tuple[Switch, ...], Jacobian, tuple[Node, ...], LuPlan]
_SOLUTIONS = 6  # for each Jacobian: of ros34prw 4, of rodas5p 8
_GAIN = 0.9  # of the operations: what takes more is not worth inner unknowns
_COMPARED_OPERATIONS = 2_000  # operations that are worth a comparison
_KEPT_GAIN = (
    0.75  # solutions along a chain take longer than their operations: one waits for another
)
_KEEPING_OPERATIONS = 20_000  # operations from which on intermediate values may be worth keeping
_NODES = 1.3  # for each operation, at most: some are made and not used
_LONG = 8_000  # products with kept vertices below which the other forms are not as large


def planned(program: Program, switches: tuple[Switch, ...]) -> Planned:
    """The Jacobian of a program and the plan of its factorisation, in the form of least cost.

    With the results of `_optimised`. The form with kept vertices comes first: what it costs is
    known from patterns, and bounds the work on the others.
    """
    forms = implicit_forms(program)
    if forms is None:
        return _with_plan(_optimised(*differentiate(program), switches))
    other, most = None, None
    kept = forms.order()
    if kept is not None and kept.order.products > _LONG:
        other = _with_plan(_optimised(*forms.with_kept_vertices(kept), switches))
        most = max(_KEEPING_OPERATIONS, int(_cost(other) / _KEPT_GAIN))
    nodes = None if most is None else _nodes(program, most, forms.size, forms.places())
    accumulated = forms.accumulated(nodes)
    if accumulated is not None:
        wide = _with_plan(_optimised(*accumulated, switches))
        if other is None or most is None or _cost(wide) <= most:
            other = wide
    assert other is not None
    cost = _cost(other)
    least = int(max(cost / _GAIN, _COMPARED_OPERATIONS))
    explicit = differentiate_within(
        program, _nodes(program, least, len(program.states), forms.slopes)
    )
    if explicit is None:
        return other
    usual = _with_plan(_optimised(*explicit, switches))
    return other if cost < _GAIN * _cost(usual) and _cost(usual) > _COMPARED_OPERATIONS else usual


def _nodes(program: Program, most: int, size: int, places: Iterable[tuple[int, int]]) -> int:
    """The nodes that derivatives at these places may take where `most` operations are allowed.

    Factorisation and solutions are counted on the pattern.
    """
    plan = plan_pattern(size, mass_places(program), places)
    left = most - plan.operations - _SOLUTIONS * solve_operations(plan, len(program.states))
    return int(_NODES * left)


def _with_plan(
    optimised: tuple[Program, tuple[Switch, ...], Jacobian, tuple[Node, ...]],
) -> Planned:
    program, switches, jacobian, timed = optimised
    program = _with_stored_mass(program, jacobian)
    return program, switches, jacobian, timed, plan_lu(program, jacobian)


def _cost(planned: Planned) -> int:
    """The operations of a Jacobian, its factorisation and the solutions with it."""
    program, _, jacobian, _, plan = planned
    made = operation_count(program.dag, jacobian) + plan.operations
    return made + _SOLUTIONS * _solution(planned)


def _solution(planned: Planned) -> int:
    """The operations of one solution."""
    return solve_operations(planned[4], len(planned[0].states))


def _optimised(
    program: Program, jacobian: Jacobian, switches: tuple[Switch, ...]
) -> tuple[Program, tuple[Switch, ...], Jacobian, tuple[Node, ...]]:
    """Optimise a differentiated program with its Jacobian; zero entries are removed.

    Also returns the terms of time alone, each followed by its derivative.
    """
    timed = tuple(chain.from_iterable(find_timed_terms(program, switches)))
    switches = with_rates(program, switches)
    rates = (switch.rate for switch in switches if switch.rate is not None)
    others = (*jacobian.entries, *jacobian.by_time, *(switch.argument for switch in switches))
    dag, new = number_values(program.dag, (*nodes_of(program), *others, *rates, *timed))
    switches = tuple(
        replace(
            switch,
            argument=new[switch.argument],
            rate=None if switch.rate is None else new[switch.rate],
        )
        for switch in switches
    )
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
    program = map_nodes(program, dag, new.__getitem__)
    return program, switches, optimised, tuple(new[node] for node in timed)


def _with_stored_mass(program: Program, jacobian: Jacobian) -> Program:
    """Store one zero in an empty mass matrix, since the runtime takes no entries as identity."""
    if program.mass != () or not program.states:
        return program
    place = next(zip(jacobian.rows, jacobian.columns, strict=True), (0, 0))
    return replace(program, mass=(MassEntry(*place, program.dag.zero),))
