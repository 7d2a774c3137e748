"""Read jumps: `when condition { reset x = value; }`."""

from __future__ import annotations

from collections.abc import Iterator

from bgc.algebra.dag import Dag, Kind, Level, Op, Symbol
from bgc.diagnostics.catalogue import jumps as messages
from bgc.diagnostics.catalogue import names
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.checks import check_value, fit_like
from bgc.elaboration.instances.components import component_names
from bgc.elaboration.instances.scopes import path_of
from bgc.elaboration.instances.tree import Environment
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.ir.graph import Jump, Node, Reset

_STATES = frozenset({Kind.STATE, Kind.DISPLACEMENT, Kind.MOMENTUM})
_FOLLOWS = {
    Kind.EFFORT: "an effort follows from the states",
    Kind.FLOW: "a flow follows from the states",
    Kind.UNKNOWN: "an equation determines it",
    Kind.PARAM: "it is a parameter",
    Kind.TIME: "it is the time",
}


def read_jump(world: World, when: syntax.When, env: Environment) -> Jump:
    """Read a `when` of an instance: its condition and the components of its resets.

    Raises
    ------
    BgError
        BG481: a target is not a state. BG483: the condition has no rising edge. BG220: a target
        occurs twice.
    """
    value = world.evaluate(when.condition, env)
    check_value(value, (), None, when.condition.span, "the condition")
    (condition,) = value.nodes
    _require_edge(world.dag, condition, when.condition.span)
    resets: list[Reset] = []
    first: dict[Node, Span] = {}
    for reset in when.resets:
        for made in _read_reset(world, reset, env):
            if made.target in first:
                raise BgError([names.given_twice(made.span, made.name, first[made.target])])
            first[made.target] = made.span
            resets.append(made)
    return Jump(condition, tuple(resets), when.span)


def _read_reset(world: World, reset: syntax.Reset, env: Environment) -> Iterator[Reset]:
    """The components of a reset."""
    target = world.evaluate(reset.target, env)
    name = path_of(reset.target)
    for node in target.nodes:
        symbol = world.dag.symbol_of(node)
        if symbol is None or symbol.kind not in _STATES:
            raise BgError([messages.not_resettable(reset.target.span, name, _why_not(symbol))])
    span, what = reset.value.span, f"`{name}`"
    value = fit_like(world.dag, world.evaluate(reset.value, env), target, span, what)
    labels = component_names(name, target.shape)
    for label, symbol_node, node in zip(labels, target.nodes, value.nodes, strict=True):
        yield Reset(symbol_node, node, label, reset.target.span)


def _why_not(symbol: Symbol | None) -> str:
    """The reason why a value other than a state cannot be reset."""
    if symbol is None:
        return "it is computed from other values"
    return _FOLLOWS.get(symbol.kind, "it is held between samples")


def _require_edge(dag: Dag, condition: Node, span: Span) -> None:
    """Raise BG483 unless a condition is made of comparisons, and varies."""
    if dag.level[condition] <= Level.PARAM:
        raise BgError(
            [
                messages.condition_without_edge(
                    span,
                    "never changes during a run",
                    "compare a state, or a value that follows from states or the time; what "
                    "parameters decide belongs to the start: `state x = if .. then .. else ..;`",
                )
            ]
        )
    stack = [condition]
    while stack:
        node = stack.pop()
        if dag.level[node] <= Level.PARAM:
            continue
        match dag.op[node]:
            case Op.AND | Op.OR | Op.NOT | Op.SELECT:
                stack.extend(dag.operands(node))
            case Op.LT | Op.LE:
                pass
            case Op.EQ if not _moves(dag, node):
                pass
            case Op.EQ:
                raise BgError(
                    [
                        messages.condition_without_edge(
                            span,
                            "compares by `==` or `!=` what moves",
                            "compare by `<`, `<=`, `>` or `>=`",
                        )
                    ]
                )
            case _:
                raise BgError(
                    [
                        messages.condition_without_edge(
                            span, "is not a comparison", "write a comparison, such as `x > 0`"
                        )
                    ]
                )


def _moves(dag: Dag, node: Node) -> bool:
    """Return whether a node may change between the instants at which held values change."""
    symbols = (dag.symbol_of(inner) for inner in dag.reachable([node]))
    return any(s is not None and s.kind not in {Kind.PARAM, Kind.INPUT} for s in symbols)
