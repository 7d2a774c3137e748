"""Check that closed chains start at the flows and momenta that the model gives.

The momenta of the start are projected until the closing rows hold. What a model gives may be moved
by that: which rows are independent is known only where the chain is closed, after initial values
have been chosen.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.catalogue import closures as catalogue
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.equations.closures.manifold import Point, closed_flows
from bgc.ir.program import GivenValue, Program

_MOVED = 1e-6  # of the value: less is rounding
_ROUNDING_OF_ZERO = 1e-9  # in SI: smaller values are zero but for rounding
_AT_ROUNDED = 1e-2  # the same where positions were moved by the rounding of given values


def require_given(program: Program, start: Point, *, rounded: bool) -> None:
    """Refuse given flows that the projection of the start onto the closed chains moves.

    `start` has the parameters and states at their defaults, with closed positions; `rounded`: these
    were moved by the rounding of given values. A flow that holds an unknown of a loop or a
    multiplier is not examined.

    Raises
    ------
    BgError
        BG546 for each value at which the program does not start.
    """
    given = [g for g in program.given if g.variable in ("p0", "f0") and not g.is_default]
    if not given:
        return
    point = closed_flows(program, start)
    share = _AT_ROUNDED if rounded else _MOVED
    found: list[Diagnostic] = []
    for one in given:
        pair = _values(program, one, point)
        if pair is None:
            continue
        actual, wanted = pair
        size = max(abs(actual), abs(wanted))
        if not math.isfinite(actual) or abs(actual - wanted) <= share * size + _ROUNDING_OF_ZERO:
            continue
        found.append(catalogue.moved_start(one.span, one.name, one.variable, actual))
    if found:
        raise BgError(found)


def _values(
    program: Program, one: GivenValue, point: Mapping[Symbol, float]
) -> tuple[float, float] | None:
    """A variable and the value given to it; None where the point does not determine them."""
    dag = program.dag
    symbols = dag.symbols_in([one.node, one.value]).values()
    loops = {Symbol(Kind.STATE, k) for k, s in enumerate(program.states) if s.kind == "algebraic"}
    if any(s not in point or s in loops for s in symbols):
        return None
    actual, wanted = evaluate_nodes(dag, [one.node, one.value], point)
    return actual, wanted
