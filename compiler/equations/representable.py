"""Refuse equations that hold a constant which a double cannot represent.

Constants are exact rationals until they are emitted, and folding makes new ones: the reciprocal of
a mass of 1e-320 kg is 1e320. In C it would be infinite, and one that is too small would be zero.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.evaluate import evaluate_nodes, to_double
from bgc.diagnostics.catalogue import equations as catalogue
from bgc.diagnostics.catalogue.values import division_by_zero
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.ir.fields import nodes_of
from bgc.ir.graph import FlatGraph, Node
from bgc.ir.program import Program

_SURE = 1000  # bits: a quotient of integers whose lengths differ by less fits a double


def require_representable(graph: FlatGraph, program: Program) -> None:
    """Check every constant of a program that was derived from a graph.

    Raises
    ------
    BgError
        A constant is too large, too small or undefined; names the variable whose equation holds it.
    """
    dag = program.dag
    wrong = {node for node in dag.reachable(nodes_of(program)) if _is_lost(dag, node)}
    if not wrong:
        return
    for node in sorted(wrong):
        if dag.op[node] == Op.DIV and dag.b[node] == dag.zero and node in dag.places:
            raise BgError([division_by_zero(dag.places[node])])
    for what, span, roots in _equations(graph, program):
        found = next((node for node in dag.reachable(roots) if node in wrong), None)
        if found is not None:
            raise BgError([catalogue.unrepresentable(span, what, _in_words(dag, found))])


def _is_lost(dag: Dag, node: Node) -> bool:
    """Test for a constant that is infinite, undefined, or zero only as a double."""
    if dag.level[node] != Level.CONST:
        return False
    exact = dag.value(node)
    if exact is None:
        return not math.isfinite(evaluate_nodes(dag, [node], {})[0])
    if abs(exact.numerator.bit_length() - exact.denominator.bit_length()) < _SURE:
        return False
    return not math.isfinite(to_double(exact)) or (exact != 0 and to_double(exact) == 0)


def _in_words(dag: Dag, node: Node) -> str:
    """The number as a power of ten where it is exact."""
    exact = dag.value(node)
    if exact is None:
        return f"{evaluate_nodes(dag, [node], {})[0]:g}"
    tens = math.log10(abs(exact.numerator)) - math.log10(exact.denominator)
    return f"{'-' if exact < 0 else ''}1e{math.floor(tens):+d}"


def _equations(
    graph: FlatGraph, program: Program
) -> Iterator[tuple[str, Span | None, Sequence[Node]]]:
    """The equations of a program, each with its place in the source."""
    owners = {element.name: element.span for element in graph.elements}
    declared = {state.name: state.span for state in graph.states}
    declared |= {unknown.name: unknown.span for unknown in graph.unknowns}
    for parameter in program.parameters:
        yield f"parameter `{parameter.name}`", parameter.span, [parameter.value]
    for state in program.states:
        span = declared.get(state.name)
        if span is None and state.stores:
            span = owners.get(state.stores[0])
        yield f"the equation of `{state.name}`", span, [state.derivative]
        yield f"the initial value of `{state.name}`", span, [state.initial, state.scale]
    for observation in program.observations:
        yield f"`{observation.name}`", observation.span, [observation.node]
    for guard in program.guards:
        yield "this condition", guard.span, [guard.condition]
    yield "an equation", None, nodes_of(program)
