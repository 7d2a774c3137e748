"""Constant folding of parameters that the scene fixes at zero or one.

A zero removes every term that it multiplies: a resistor with zero friction does not appear in f, in
the Jacobian or in the pattern of its factors. Folding any other value gains nothing, so it stays a
run-time parameter.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from bgc.algebra.dag import Dag, Kind
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import FlatGraph, Node, Parameter
from bgc.record_class import dataclass, replace
from bgc.slicing.keep_patterns import is_kept


@dataclass(frozen=True, slots=True)
class Folding:
    """A graph without its fixed parameters, and the names and values of these."""

    graph: FlatGraph
    parameters: tuple[tuple[str, float], ...]


def fold_parameters(graph: FlatGraph) -> Folding:
    """Fold the parameters that the scene fixes at zero or one.

    These are the zeros and ones that the scene or the command line sets, and the zeros that parts
    have by default or as arguments: effects that are switched off. A parameter of the scene's own
    model is folded only if it is set. `keep` excludes parameters, and a model without a scene has
    none folded. Parameters that depend on folded ones alone are folded with them. A default start
    that may have to close a chain is not fixed.
    """
    if not graph.scene.name:
        return Folding(graph, ())
    dag = Dag()
    new: dict[Node, Node] = {}
    given: dict[Node, Node] = {}  # a parameter's symbol -> its value, or its new symbol
    starts = {node for state in graph.states for node in state.free if graph.conditions}
    left: list[Parameter] = []
    folded: list[tuple[str, float]] = []
    for parameter in graph.parameters:  # each after those it depends on
        symbol = graph.dag.symbol(Kind.PARAM, parameter.index)
        _rebuild(graph.dag, dag, [parameter.value], given, new)
        value = dag.value(new[parameter.value])
        if symbol not in starts and _is_fixed(parameter, value, graph.kept):
            assert value is not None
            given[symbol] = new[parameter.value]
            folded.append((parameter.name, float(value)))
        else:
            given[symbol] = dag.symbol(Kind.PARAM, len(left))
            left.append(replace(parameter, index=len(left)))
    if not folded:
        return Folding(graph, ())
    smaller = replace(graph, parameters=tuple(left))
    _rebuild(graph.dag, dag, nodes_of(smaller), given, new)
    return Folding(map_nodes(smaller, dag, new.__getitem__), tuple(folded))


def _is_fixed(parameter: Parameter, value: Fraction | None, kept: tuple[str, ...]) -> bool:
    if is_kept(parameter.name, kept):
        return False
    if parameter.is_set:
        return value in (0, 1)
    return value == 0 and not parameter.is_own


def _rebuild(
    dag: Dag, other: Dag, roots: list[Node], given: Mapping[Node, Node], new: dict[Node, Node]
) -> None:
    """Rebuild the roots in another DAG with `given` nodes replaced; `new` maps old to new."""
    for node in dag.reachable(roots):
        if node in new:
            continue
        if node in given:
            new[node] = given[node]
        else:
            new[node] = other.adopt(dag, node, tuple(new[x] for x in dag.operands(node)))
        other.mark_as(new[node], dag, node)
