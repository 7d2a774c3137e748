"""Prove that states whose start is solved for start at zero.

The equations of the start are regular, so one solution is the solution. Assume that some of the
unknowns are zero. An equation that does not hold identically then releases all its unknowns, until
no more are released. The equations of those that are left hold, and the other equations, which do
not contain them, determine the other unknowns. A crane on a vessel that heaves and pitches starts
in its own plane in this way.
"""

from __future__ import annotations

from collections.abc import Iterable

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.fingerprint import Fingerprints
from bgc.ir.graph import Node
from bgc.ir.program import Program

_ALMOST_ZERO = 1e-12  # a guess that may be a rounded zero


def zero_starts(program: Program) -> set[int]:
    """The states that `program.start` solves for and that provably start at zero."""
    start = program.start
    if start is None:
        return set()
    dag = program.dag.copy()
    fingerprints = Fingerprints(dag)
    symbols = [dag.symbol(Kind.START, k) for k in range(len(start.guess))]
    zero = {s for s, guess in zip(symbols, start.guess, strict=True) if abs(guess) <= _ALMOST_ZERO}
    reads = [set(symbols).intersection(dag.reachable([row])) for row in start.residuals]
    while zero:
        new = _with_zeros(dag, zero, start.residuals)
        failing = [
            read
            for row, read in zip(start.residuals, reads, strict=True)
            if not (zero.isdisjoint(read) or fingerprints.is_zero(new[row]))
        ]
        if not failing:
            break
        zero = zero.difference(*failing)
    new = _with_zeros(dag, zero, [node for _, node in start.values])
    return {
        state
        for state, node in start.values
        if fingerprints.is_zero(new[node]) and dag.value(program.states[state].initial) == 0
    }


def _with_zeros(dag: Dag, zero: set[Node], roots: Iterable[Node]) -> dict[Node, Node]:
    """The nodes under the roots with zero for some symbols."""
    new: dict[Node, Node] = {}
    for node in dag.reachable(list(roots)):
        operands = dag.operands(node)
        if node in zero:
            new[node] = dag.zero
        elif all(new[x] == x for x in operands):
            new[node] = node
        else:
            new[node] = dag.rebuild(node, tuple(new[x] for x in operands))
    return new
