"""Operations at which a node jumps, as a function of time and of the other symbols.

A node is continuous where an operation changes its result if both results give the same value
there. This is proven by fingerprints, on the set where the argument of the operation is zero; what
cannot be proven continuous counts as a jump.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.derivatives import gradient
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.nodes import Node
from bgc.algebra.table import Table, orders_of

_COMPARISONS = frozenset(map(int, (Op.LT, Op.LE)))
_ROUNDINGS = frozenset(map(int, (Op.FLOOR, Op.CEIL)))
_SUDDEN = _COMPARISONS | _ROUNDINGS | {int(Op.SIGN), int(Op.FMOD)}


def jumps_in(dag: Dag, fingerprints: Fingerprints, root: Node) -> list[Node]:
    """The operations at which a node may jump; `==` is true at isolated instants and is none."""
    below = dag.reachable([root])
    found = [n for n in below if dag.op[n] in _SUDDEN and dag.level[n] > Level.PARAM]
    segments = {n for n in found if is_segment(dag, n)}
    joined = segments - {
        n for m in below for n in dag.operands(m) if n in segments and not joins(dag, n, m)
    }
    return [n for n in found if n not in joined and not _is_continuous(dag, fingerprints, root, n)]


def is_segment(dag: Dag, node: Node) -> bool:
    """Test whether a node is the segment of a table at an argument."""
    return dag.op[node] == Op.FLOOR and dag.op[dag.a[node]] == Op.PLACE


def joins(dag: Dag, segment: Node, reader: Node) -> bool:
    """Return whether a reader of the segment of a table is continuous where the segment changes."""
    if dag.op[reader] != Op.PIECE or dag.c[reader] != segment:
        return False
    table, place = dag.table_of(reader), dag.a[segment]
    order, _ = orders_of(int(dag.constants[dag.a[dag.a[reader]]]))
    same = dag.table_of(place) is table and dag.b[place] == dag.b[reader]
    return same and order == 0 and isinstance(table, Table) and table.continuous


def at_threshold(dag: Dag, roots: Iterable[Node], threshold: Mapping[Node, Node]) -> list[Node]:
    """The roots at a point where an operation changes its result.

    Zero to a power that is not known is zero there: `sign(x)*abs(x)^n` is continuous for n > 0.
    """
    there = dag.substitute(roots, threshold)
    powers = (n for n in dag.reachable(there) if dag.op[n] == Op.POW and dag.a[n] == dag.zero)
    vanishing = {n: dag.zero for n in powers if dag.value(dag.b[n]) is None}
    return dag.substitute(there, vanishing) if vanishing else there


def holding_sudden(dag: Dag, roots: Iterable[Node]) -> set[Node]:
    """The nodes below roots that depend on an operation which changes its result at once."""
    found: set[Node] = set()
    for node in dag.reachable(roots):
        sudden = dag.op[node] in _SUDDEN and dag.level[node] > Level.PARAM
        if sudden or not found.isdisjoint(dag.operands(node)):
            found.add(node)
    return found


def _is_continuous(dag: Dag, fingerprints: Fingerprints, root: Node, node: Node) -> bool:
    return any(
        fingerprints.equal(*(_put(dag, root, node, result, at) for result in results))
        for at, results in _changes(dag, node)
    )


def _put(dag: Dag, root: Node, node: Node, result: Node, at: Mapping[Node, Node]) -> Node:
    """The root with a result for an operation, at a point where that result changes."""
    (given,) = dag.substitute([root], {node: result})
    (there,) = at_threshold(dag, [given], at)
    return there


def _changes(dag: Dag, node: Node) -> Iterator[tuple[dict[Node, Node], tuple[Node, Node]]]:
    """The place at which an operation jumps, as a substitution, and its results on both sides."""
    one = dag.one
    if dag.op[node] in _ROUNDINGS:
        whole = dag.symbol(Kind.UNKNOWN, len(dag))  # any whole number
        below, above = (whole, one) if dag.op[node] == Op.FLOOR else (dag.sub(whole, one), one)
        for at in _zeros(dag, dag.a[node], dag.add(below, one)):
            yield at, (below, dag.add(below, above))
        return
    if dag.op[node] == Op.FMOD:  # from the divisor to zero, or from zero to minus the divisor
        yield {}, (dag.zero, dag.b[node])
        return
    results = (dag.neg(one), one) if dag.op[node] == Op.SIGN else (dag.zero, one)
    other = dag.zero if dag.op[node] == Op.SIGN else dag.b[node]
    for at in _zeros(dag, dag.a[node], other):
        yield at, results


def _zeros(dag: Dag, left: Node, right: Node) -> Iterator[dict[Node, Node]]:
    """Substitutions under which two nodes are equal: of a symbol, else of one node by the other."""
    difference = dag.sub(left, right)
    symbols = [n for n in dag.reachable([difference]) if _varies(dag, n)]
    for symbol, slope in zip(symbols, gradient(dag, difference, symbols), strict=True):
        if slope != dag.zero and symbol not in dag.reachable([slope]):
            yield {symbol: dag.sub(symbol, dag.div(difference, slope))}
    yield from ({x: y} for x, y in ((left, right), (right, left)) if dag.level[x] > Level.PARAM)


def _varies(dag: Dag, node: Node) -> bool:
    return dag.symbol_of(node) is not None and dag.level[node] > Level.PARAM
