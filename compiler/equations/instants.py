"""Comparisons by `==` and `!=` that change for an instant only.

Two values of which one moves without a rest are equal at isolated instants. What a rate is there
adds nothing to an integral, but a method may evaluate the rate at that very instant, and count it
for a part of a step. Where time alone decides, the instant therefore counts as not equal in all
rates and powers, whatever the method. A state may rest, so its comparisons stay as they are. Both
give a warning.

Left alone are guards of quotients, `if x == 0 then 1 else sin(x)/x`, whose branches join at that
instant, and values that may rest in a branch (`max(x, 0) == 0`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.diagnostics.catalogue.jumps import equal_for_an_instant
from bgc.ir.graph import Node
from bgc.ir.program import Program

_SMOOTH = frozenset(
    map(int, (Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG, Op.ABS, Op.POW, Op.SQRT, Op.EXP, Op.LOG))
) | frozenset(map(int, (Op.SIN, Op.COS, Op.TAN, Op.TANH)))
_UNDEFINED_SOMEWHERE = frozenset(map(int, (Op.DIV, Op.LOG, Op.LOG10)))


def without_instants(program: Program) -> Program:
    """Count instants of time alone as not equal, and warn of all comparisons that hold for one."""
    dag, energy = program.dag, program.energy
    rates = [state.derivative for state in program.states]
    roots = [*rates, energy.supplied, energy.dissipated]
    below = dag.reachable(roots)
    found = [n for n in below if dag.op[n] == Op.EQ and dag.level[n] > Level.PARAM]
    moved_by = {n: kinds for n in found if (kinds := _moved_by(dag, n))}
    guards = _guards(dag, below, moved_by)
    never = {n: dag.zero for n, kinds in moved_by.items() if kinds == {Kind.TIME}}
    for guard in guards:
        never.pop(guard, None)
    negated = {dag.a[n]: n for n in below if dag.op[n] == Op.NOT}
    places = [
        (dag.places.get(n) or dag.places.get(negated.get(n, -1)), n in never)
        for n in moved_by
        if n not in guards
    ]
    warnings = tuple(equal_for_an_instant(span, timed) for span, timed in places if span)
    if never:
        *rates, supplied, dissipated = dag.substitute(roots, never)
        states = zip(program.states, rates, strict=True)
        program = replace(
            program,
            states=tuple(replace(state, derivative=rate) for state, rate in states),
            energy=replace(energy, supplied=supplied, dissipated=dissipated),
        )
    return replace(program, warnings=(*program.warnings, *warnings))


def _moved_by(dag: Dag, comparison: Node) -> set[Kind]:
    """The kinds, time or states, that move the compared values; empty where they may rest."""
    kinds: set[Kind] = set()
    for node in dag.reachable([comparison]):
        if node == comparison or dag.level[node] <= Level.PARAM:
            continue
        symbol = dag.symbol_of(node)
        if symbol is not None and symbol.kind in {Kind.STATE, Kind.TIME}:
            kinds.add(symbol.kind)
        elif symbol is not None or dag.op[node] not in _SMOOTH:
            return set()
    return kinds


def _guards(dag: Dag, below: Sequence[Node], comparisons: Collection[Node]) -> set[Node]:
    """The comparisons beside whose branch another has a quotient or logarithm of what they read."""
    guards: set[Node] = set()
    for choice in below if comparisons else ():
        if dag.op[choice] != Op.SELECT:
            continue
        decided = set(dag.reachable([dag.a[choice]])).intersection(comparisons)
        for comparison in decided:
            read = dag.symbols_in([comparison]).keys()
            for inner in dag.reachable([dag.b[choice], dag.c[choice]]):
                argument = dag.b[inner] if dag.op[inner] == Op.DIV else dag.a[inner]
                if dag.op[inner] in _UNDEFINED_SOMEWHERE and not read.isdisjoint(
                    dag.reachable([argument])
                ):
                    guards.add(comparison)
    return guards
