"""Fixed parameters: zeros and ones that the scene fixes become part of the equations.

A zero removes what it multiplies: the resistor of a zero friction has no part in f, in the
Jacobian or in the pattern of its factors. Any other value gains nothing by being folded, and
stays a run-time parameter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from bgc.algebra.dag import Dag, Kind, Op
from bgc.ir.graph import FlatGraph, Node, Parameter
from bgc.ir.graph_nodes import graph_roots, map_graph
from bgc.slicing.names import is_kept


@dataclass(frozen=True, slots=True)
class Folding:
    """A graph without its fixed parameters, and those: names and values."""

    graph: FlatGraph
    parameters: tuple[tuple[str, float], ...]


def fold_parameters(graph: FlatGraph) -> Folding:
    """The graph without the parameters that the scene fixes at zero or one.

    Fixed are the zeros and ones that the scene (or the command line) sets, and the zeros that
    parts have by default or are given: what is switched off. Parameters of the scene's own
    model are its face to the outside, and are left unless they are set; so is everything that
    `keep` names, and every parameter of a model without a scene. What follows from folded
    parameters alone is folded with them.
    """
    if not graph.scene.name:
        return Folding(graph, ())
    dag = Dag()
    new: dict[Node, Node] = {}
    given: dict[Node, Node] = {}  # a parameter's symbol -> its value, or its new symbol
    left: list[Parameter] = []
    folded: list[tuple[str, float]] = []
    for parameter in graph.parameters:  # each after those it depends on
        symbol = graph.dag.symbol(Kind.PARAM, parameter.index)
        _rebuild(graph.dag, dag, [parameter.value], given, new)
        value = dag.value(new[parameter.value])
        if _is_fixed(parameter, value, graph.kept):
            assert value is not None
            given[symbol] = new[parameter.value]
            folded.append((parameter.name, float(value)))
        else:
            given[symbol] = dag.symbol(Kind.PARAM, len(left))
            left.append(replace(parameter, index=len(left)))
    if not folded:
        return Folding(graph, ())
    smaller = replace(graph, parameters=tuple(left))
    _rebuild(graph.dag, dag, graph_roots(smaller), given, new)
    return Folding(map_graph(smaller, dag, new.__getitem__), tuple(folded))


def _is_fixed(parameter: Parameter, value: Fraction | None, kept: tuple[str, ...]) -> bool:
    if is_kept(parameter.name, kept):
        return False
    if parameter.is_set:
        return value in (0, 1)
    return value == 0 and not parameter.is_own


def _rebuild(
    dag: Dag, other: Dag, roots: list[Node], given: Mapping[Node, Node], new: dict[Node, Node]
) -> None:
    """Make the roots again in another graph, `given` nodes replaced; `new` knows old to new."""
    for node in dag.reachable(roots):
        if node in new:
            continue
        op = dag.op[node]
        if node in given:
            new[node] = given[node]
        elif op == Op.CONST:
            new[node] = other.const(dag.constants[dag.a[node]])
        elif op == Op.SYMBOL:
            symbol = dag.symbols[dag.a[node]]
            new[node] = other.symbol(symbol.kind, symbol.index)
        else:
            new[node] = other.apply(op, tuple(new[x] for x in dag.operands(node)))
        if node in dag.places:
            other.mark(new[node], dag.places[node])
