"""Nodes as readable text in infix notation.

The DAG is never expanded into a tree: a node that is used more than once is printed once, as a
temporary `t1`, `t2`, ...
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction

from bgc.algebra.dag import TABLE_OPS, Dag, Op, Symbol
from bgc.algebra.discontinuities import is_segment

_ATOM = 9  # binds more tightly than any operator


def number(value: Fraction) -> str:
    """A whole number in digits, any other as the shortest decimal of its nearest double."""
    return str(value) if value.denominator == 1 and abs(value) < 10**15 else repr(float(value))


def infix_lines(
    dag: Dag, equations: Sequence[tuple[str, int]], name: Callable[[Symbol], str]
) -> list[str]:
    """Print `left = right` for each equation, after the temporaries that they share."""
    roots = [node for _, node in equations]
    order = dag.reachable(roots)
    shared = _shared(dag, order, roots)
    text: dict[int, tuple[str, int]] = {}
    lines: list[str] = []
    for node in order:
        body = _body(dag, node, text, name)
        if node in shared:
            temporary = f"t{len(lines) + 1}"
            lines.append(f"{temporary} = {body[0]}")
            body = (temporary, _ATOM)
        text[node] = body
    return lines + [f"{left} = {text[node][0]}" for left, node in equations]


def _shared(dag: Dag, order: Iterable[int], roots: Iterable[int]) -> set[int]:
    """The nodes that become temporaries: operations that are used more than once."""
    uses = Counter(roots)
    for node in order:
        uses.update(dag.operands(node))
    return {
        n
        for n, count in uses.items()
        if count > 1
        and dag.op[n] not in (Op.NOT, Op.NEG, Op.CONST, Op.SYMBOL, Op.PLACE, Op.LISTED)
        and not is_segment(dag, n)
    }


def _body(
    dag: Dag, node: int, text: dict[int, tuple[str, int]], name: Callable[[Symbol], str]
) -> tuple[str, int]:
    """The text of a node from the texts of its operands, with its binding strength."""
    value, symbol = dag.value(node), dag.symbol_of(node)
    if value is not None:
        return number(value), _ATOM if value >= 0 else 7
    if symbol is not None:
        return name(symbol), _ATOM
    op = Op(dag.op[node])
    if op in TABLE_OPS:
        source, marks, arguments = dag.shown_look_up(node)
        suffix = f"_{marks}" if marks.strip("'") else marks
        shown = ", ".join([f'"{source}"', *(text[x][0] for x in arguments)])
        return f"{op.row.name}{suffix}({shown})", _ATOM
    if op is Op.LISTED:
        return "", _ATOM  # shown by its first entry
    if op is Op.INVERTED:
        entry, place = dag.shown_inverse(node)
        return f"inv([{text[entry][0]}, ..]){list(place)}", _ATOM
    operands = [text[x] for x in dag.operands(node)]
    infix = op.row.infix
    if op is Op.SELECT:
        condition, yes, no = (t for t, _ in operands)
        return f"if {condition} then {yes} else {no}", 0
    if infix is None:
        return f"{op.row.name}({', '.join(t for t, _ in operands)})", _ATOM
    if op.row.arity == 1:
        return infix.symbol + _bracketed(operands[0], infix.binding + 1), infix.binding
    left = _bracketed(operands[0], infix.binding + infix.strict_left)
    right = _bracketed(operands[1], infix.binding + infix.strict_right)
    space = "" if op is Op.POW else " "
    return f"{left}{space}{infix.symbol}{space}{right}", infix.binding


def _bracketed(text: tuple[str, int], needed: int) -> str:
    return text[0] if text[1] >= needed else f"({text[0]})"
