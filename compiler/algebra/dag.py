"""Scalar expressions as one hash-consed graph: a node is an int, equal nodes are one node.

Nothing is ever expanded into a tree, so every pass costs time proportional to the number of
nodes. Creation order is a topological order: a node's operands have smaller numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import IntEnum
from fractions import Fraction
from math import isqrt

from bgc.algebra.operations import ROWS
from bgc.algebra.operations import Op as Op
from bgc.algebra.table import AnyTable, Grid, base_of, orders_of
from bgc.diagnostics.source import Span
from bgc.record_class import dataclass


class Level(IntEnum):
    """Frequency with which a node changes, which is the outermost loop it can be computed in."""

    CONST = 0
    PARAM = 1
    TIME = 2  # time and device inputs
    STATE = 3


class Kind(IntEnum):
    """Kind of quantity that a symbol denotes; its `index` counts within the kind."""

    PARAM = 0
    TIME = 1
    INPUT = 2  # one component of a device's channel
    STATE = 3  # of the program: x[index]; of a flat graph: a declared `state`
    EFFORT = 4  # of scalar bond `index`, along its own half arrow
    FLOW = 5
    DISPLACEMENT = 6  # q of a storage port; index counts storage ports over the graph
    MOMENTUM = 7  # p of a storage port; the same count
    UNKNOWN = 8  # a declared `unknown`
    RATE = 9  # der(x) of a declared state, inside an `equation`
    START = 10  # an unknown of the start, which the runtime solves for once
    SPEED = 11  # of `SpeedEquations`: an independent flow of merged inertias
    SELECTOR = 12  # of a closing row, 0 or 1: see `Closures`; counts on from the parameters
    OWN = 13  # an element's own variable while its linear law is read: see `Laws.linear_law`
    CHANGE = 14  # the derivative of a state, of time or of a START unknown by a parameter
    HOISTED_CHANGE = 15  # the same of element `index` of the hoisted nodes


# Operations as plain ints: comparing with a member of an enumeration takes several times longer.
_CONST, _SYMBOL, _ADD, _SUB, _MUL, _DIV, _NEG, _POW, _SELECT = map(
    int,
    (Op.CONST, Op.SYMBOL, Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG, Op.POW, Op.SELECT),
)
_LISTED, _INVERTED = int(Op.LISTED), int(Op.INVERTED)

TABLE_OPS = frozenset(map(int, (Op.LOOKUP, Op.PLACE, Op.PIECE, Op.LOOKUP2)))
_SYMBOL_LEVEL = {
    Kind.PARAM: Level.PARAM,
    Kind.SELECTOR: Level.PARAM,
    Kind.TIME: Level.TIME,
    Kind.INPUT: Level.TIME,
}
_MAX_BITS = 512  # of an exact constant; operations with a longer result are left to C


@dataclass(frozen=True, slots=True)
class Symbol:
    """The payload of a SYMBOL node."""

    kind: Kind
    index: int


class Dag:
    """The node store. `op[n]`, `a[n]`, `b[n]`, `c[n]`, `level[n]` describe node n.

    Operands that an operation lacks are -1. For CONST, `a` indexes `constants`; for SYMBOL, it
    indexes `symbols`. `places` holds the place in the source of the operations passed to `mark`,
    and of the nodes that `rebuild` made from them; `owners` the element whose law has an operation,
    likewise. `tables` holds the data that nodes look up, by
    the number that is their first operand. Nodes LISTED have no number of their own: they are read
    by INVERTED only (`inverted`).
    """

    def __init__(self) -> None:
        self.op: list[int] = []
        self.a: list[int] = []
        self.b: list[int] = []
        self.c: list[int] = []
        self.level: list[int] = []
        self.constants: list[Fraction] = []
        self.symbols: list[Symbol] = []
        self.places: dict[int, Span] = {}
        self.owners: dict[int, str] = {}
        self.tables: dict[int, AnyTable] = {}
        self._nodes: dict[tuple[int, int, int, int], int] = {}
        self._constant_nodes: dict[tuple[int, int], int] = {}
        self._symbol_nodes: dict[Symbol, int] = {}
        self.zero = self.const(0)
        self.one = self.const(1)

    def __len__(self) -> int:
        return len(self.op)

    def copy(self) -> Dag:
        """Copy the graph; nodes added to one are not added to the other."""
        other = Dag.__new__(Dag)
        other.op, other.a, other.b, other.c = self.op[:], self.a[:], self.b[:], self.c[:]
        other.level = self.level[:]
        other.constants, other.symbols = self.constants[:], self.symbols[:]
        other.places, other.tables = self.places.copy(), self.tables.copy()
        other.owners = self.owners.copy()
        other._nodes = self._nodes.copy()
        other._constant_nodes = self._constant_nodes.copy()
        other._symbol_nodes = self._symbol_nodes.copy()
        other.zero, other.one = self.zero, self.one
        return other

    # --- leaves ---------------------------------------------------------------------

    def const(self, value: int | float | Fraction) -> int:
        """The node of an exact constant; a float is converted to its exact rational value."""
        ratio = value.as_integer_ratio()  # hashed many times faster than a Fraction
        node = self._constant_nodes.get(ratio)
        if node is None:
            self.constants.append(Fraction(value))
            node = self._append(Op.CONST, len(self.constants) - 1, -1, -1, Level.CONST)
            self._constant_nodes[ratio] = node
        return node

    def symbol(self, kind: Kind, index: int = 0) -> int:
        """The node of a leaf."""
        symbol = Symbol(kind, index)
        node = self._symbol_nodes.get(symbol)
        if node is None:
            self.symbols.append(symbol)
            level = _SYMBOL_LEVEL.get(kind, Level.STATE)
            node = self._append(Op.SYMBOL, len(self.symbols) - 1, -1, -1, level)
            self._symbol_nodes[symbol] = node
        return node

    # --- queries --------------------------------------------------------------------

    def value(self, node: int) -> Fraction | None:
        """The exact value of a CONST node, None for any other."""
        return self.constants[self.a[node]] if self.op[node] == Op.CONST else None

    def symbol_of(self, node: int) -> Symbol | None:
        """The symbol of a SYMBOL node, None for any other."""
        return self.symbols[self.a[node]] if self.op[node] == Op.SYMBOL else None

    def leaf(self, node: int) -> Symbol:
        """The symbol of a node that is known to be one."""
        symbol = self.symbol_of(node)
        assert symbol is not None, node
        return symbol

    def symbols_in(self, roots: Iterable[int], *kinds: Kind) -> dict[int, Symbol]:
        """The symbols that nodes hold, by their own nodes; those of some kinds if any is given."""
        least = min((_SYMBOL_LEVEL.get(kind, Level.STATE) for kind in kinds), default=Level.CONST)
        nodes = (n for n in self.reachable(roots, least) if self.op[n] == _SYMBOL)
        held = {n: self.symbols[self.a[n]] for n in nodes}
        return {n: s for n, s in held.items() if s.kind in kinds} if kinds else held

    def operands(self, node: int) -> tuple[int, ...]:
        """The nodes from which a node is computed."""
        if self.op[node] <= _SYMBOL:
            return ()
        if self.b[node] < 0:
            return (self.a[node],)
        if self.c[node] < 0:
            return (self.a[node], self.b[node])
        return (self.a[node], self.b[node], self.c[node])

    def reachable(self, roots: Iterable[int], least: int = Level.CONST) -> list[int]:
        """All nodes that the roots need, themselves included, in topological order.

        Nodes below the level `least` are left out: no operand of theirs has that level either.
        """
        op, a, b, c, level, least = self.op, self.a, self.b, self.c, self.level, int(least)
        seen = {root for root in roots if level[root] >= least}
        stack = list(seen)
        while stack:
            node = stack.pop()
            if op[node] <= _SYMBOL:
                continue
            for operand in (a[node], b[node], c[node]):
                if operand < 0:
                    break
                if operand not in seen and level[operand] >= least:
                    seen.add(operand)
                    stack.append(operand)
        return sorted(seen)

    def repeated(self, roots: Iterable[int]) -> set[int]:
        """The operations that are repeated at each evaluation of the roots."""
        return {n for n in self.reachable(roots, Level.TIME) if self.op[n] > _SYMBOL}

    # --- arithmetic -----------------------------------------------------------------
    # Called once per node in every pass, hence plain ints and inlined look-ups.

    def add(self, a: int, b: int) -> int:
        """A + b."""
        if a == self.zero:
            return b
        if b == self.zero:
            return a
        op = self.op
        if op[b] == _NEG:
            return self.sub(a, self.a[b])
        if op[a] == _NEG:
            return self.sub(b, self.a[a])
        if op[a] == _CONST and op[b] == _CONST:
            folded = self._exact(self.constants[self.a[a]] + self.constants[self.a[b]])
            if folded is not None:
                return folded
        return self._make(_ADD, a, b) if a < b else self._make(_ADD, b, a)

    def sub(self, a: int, b: int) -> int:
        """A - b."""
        if b == self.zero:
            return a
        if a == b:
            return self.zero
        if a == self.zero:
            return self.neg(b)
        op = self.op
        if op[b] == _NEG:
            return self.add(a, self.a[b])
        if op[a] == _NEG:
            return self.neg(self.add(self.a[a], b))
        if op[a] == _CONST and op[b] == _CONST:
            folded = self._exact(self.constants[self.a[a]] - self.constants[self.a[b]])
            if folded is not None:
                return folded
        opposite = self._nodes.get((_SUB, b, a, -1))
        return self.neg(opposite) if opposite is not None else self._make(_SUB, a, b)

    def neg(self, a: int) -> int:
        """The opposite of a."""
        op = self.op[a]
        if op == _NEG:
            return self.a[a]
        if op == _CONST:
            return self.const(-self.constants[self.a[a]])
        return self._make(_NEG, a)

    def mul(self, a: int, b: int) -> int:
        """A * b."""
        zero, one = self.zero, self.one
        if a == zero or b == zero:
            return zero
        if a == one:
            return b
        if b == one:
            return a
        op = self.op
        op_a, op_b = op[a], op[b]
        if op_a == _NEG:
            return self.neg(self.mul(self.a[a], b))
        if op_b == _NEG:
            return self.neg(self.mul(a, self.a[b]))
        if op_a == _CONST:
            x = self.constants[self.a[a]]
            if op_b == _CONST:
                folded = self._exact(x * self.constants[self.a[b]])
                if folded is not None:
                    return folded
            if x < 0:
                return self.neg(self.mul(self.const(-x), b))
        elif op_b == _CONST:
            return self.mul(b, a)
        return self._make(_MUL, a, b) if a < b else self._make(_MUL, b, a)

    def div(self, a: int, b: int) -> int:
        """A / b. A constant zero divisor is kept; the caller reports it."""
        if b == self.one:
            return a
        if b == self.zero:
            return self._make(_DIV, a, b)
        if a == self.zero:
            return a
        op = self.op
        if op[a] == _NEG:
            return self.neg(self.div(self.a[a], b))
        if op[b] == _NEG:
            return self.neg(self.div(a, self.a[b]))
        if op[b] == _CONST:
            y = self.constants[self.a[b]]
            if op[a] == _CONST:
                folded = self._exact(self.constants[self.a[a]] / y)
                if folded is not None:
                    return folded
            if y < 0:
                return self.neg(self.div(a, self.const(-y)))
        elif op[a] == _CONST and self.constants[self.a[a]] < 0:
            return self.neg(self.div(self.neg(a), b))
        return self._make(_DIV, a, b)

    def pow(self, a: int, b: int) -> int:
        """A ^ b; small whole powers become products."""
        exponent = self.value(b)
        if exponent is not None and exponent.denominator == 1 and abs(exponent) <= 8:
            return self._whole_power(a, int(exponent))
        if exponent == Fraction(1, 2):
            return self.call(Op.SQRT, a)
        if a == self.zero and exponent is not None and exponent > 0:
            return a
        return self._make(_POW, a, b)

    def select(self, condition: int, yes: int, no: int) -> int:
        """`yes` where the condition is not zero, else `no`."""
        if yes == no:
            return yes
        value = self.value(condition)
        if value is not None:
            return yes if value != 0 else no
        return self._make(_SELECT, condition, yes, no)

    def call(self, op: int, *operands: int) -> int:
        """Make any other operation: a comparison, logic or a function."""
        values = [self.value(x) for x in operands]
        exact = [v for v in values if v is not None]
        if len(exact) == len(values):
            row = ROWS[op]
            folded = row.folded(exact)
            if folded is not None:
                return self.const(folded)
            root = row.root(exact[0]) if row.root is not None else None
            if root is not None:
                share, square = root
                return self.mul(self.const(share), self.call(Op.SQRT, self.const(square)))
        return self._make(int(op), *operands)

    def sum(self, nodes: Iterable[int]) -> int:
        """The sum, left to right; zero if there are no nodes."""
        total = self.zero
        for node in nodes:
            total = self.add(total, node)
        return total

    def dot(self, left: Iterable[int], right: Iterable[int]) -> int:
        """Sum of the products of two sequences of equal length."""
        return self.sum(self.mul(x, y) for x, y in zip(left, right, strict=True))

    # --- tables ---------------------------------------------------------------------

    def table_of(self, node: int) -> AnyTable:
        """The table that a node of one of `TABLE_OPS` looks up."""
        number = self.constants[self.a[self.a[node]]]
        return self.tables[base_of(int(number))]

    def shown_look_up(self, node: int) -> tuple[str, str, tuple[int, ...]]:
        """A look-up as text: the name of the data, a mark of each derivative, the arguments."""
        orders = orders_of(int(self.constants[self.a[self.a[node]]]))
        marks = (
            "'" * orders[0] if self.op[node] != Op.LOOKUP2 else "x" * orders[0] + "y" * orders[1]
        )
        count = 2 if self.op[node] == Op.LOOKUP2 else 1
        return self.table_of(node).source, marks, self.operands(node)[1 : 1 + count]

    def look_up(self, table: AnyTable, *arguments: int) -> int:
        """A table at one or two arguments; a table with breaks, on the segment of its argument."""
        present = self.tables.setdefault(table.number, table)
        number = self.const(present.number)
        if isinstance(table, Grid):
            return self.call(Op.LOOKUP2, number, *arguments)
        if table.smooth:
            return self.call(Op.LOOKUP, number, *arguments)
        segment = self.call(Op.FLOOR, self.call(Op.PLACE, number, *arguments))
        return self.call(Op.PIECE, number, *arguments, segment)

    # --- inverses -------------------------------------------------------------------

    def inverted(self, matrix: Sequence[Sequence[int]]) -> list[list[int]]:
        """The inverse of a square matrix of parameters, which a run computes once in doubles.

        An entry is a node of its own. All refer to one list of the entries of the matrix, row by
        row, that begins with the number of rows. The entries of a singular matrix are NaN.
        """
        size = len(matrix)
        listed = self.const(size)
        for row in matrix:
            for entry in row:
                listed = self._make(_LISTED, listed, entry)
        places = (self.const(k) for k in range(size * size))
        found = [self._make(_INVERTED, listed, place) for place in places]
        return [found[size * i : size * (i + 1)] for i in range(size)]

    def listed(self, node: int) -> list[int]:
        """The entries, row by row, of a matrix to be inverted, by the end of its list."""
        entries = []
        while self.op[node] == _LISTED:
            entries.append(self.b[node])
            node = self.a[node]
        return entries[::-1]

    def place_in_inverse(self, node: int) -> int:
        """The place of an INVERTED node in its inverse, row by row from zero."""
        return int(self.constants[self.a[self.b[node]]])

    def shown_inverse(self, node: int) -> tuple[int, tuple[int, int]]:
        """An INVERTED node for printing: the first entry of the matrix, its own row and column."""
        entries = self.listed(self.a[node])
        row, column = divmod(self.place_in_inverse(node), isqrt(len(entries)))
        return entries[0], (row + 1, column + 1)

    # --- rebuilding -----------------------------------------------------------------

    def rebuild(self, node: int, operands: tuple[int, ...]) -> int:
        """The operation of `node` on other operands, simplified again."""
        if self.op[node] <= _SYMBOL:
            return node
        made = self.apply(self.op[node], operands)
        self.mark_as(made, self, node)
        return made

    def mark(self, node: int, place: Span) -> None:
        """Record the place of an operation in the source; the first place of equal ones stays."""
        if self.op[node] > _SYMBOL:
            self.places.setdefault(node, place)

    def mark_as(self, node: int, other: Dag, old: int) -> None:
        """Record of an operation what another graph records of the one that it was made from."""
        if self.op[node] > _SYMBOL:
            if old in other.places:
                self.places.setdefault(node, other.places[old])
            if old in other.owners:
                self.owners.setdefault(node, other.owners[old])

    def apply(self, op: int, operands: tuple[int, ...]) -> int:
        """Make an operation given by its number, which is not a leaf's."""
        method = _METHODS.get(op)
        return method(self, *operands) if method is not None else self.call(op, *operands)

    def adopt(self, other: Dag, node: int, operands: tuple[int, ...]) -> int:
        """Make a node of another graph in this one, on operands that are nodes of this one."""
        op, a = other.op[node], other.a[node]
        if op == _CONST:
            return self.const(other.constants[a])
        if op == _SYMBOL:
            symbol = other.symbols[a]
            return self.symbol(symbol.kind, symbol.index)
        if op in TABLE_OPS:
            table = other.table_of(node)
            self.tables.setdefault(table.number, table)
        return self.apply(op, operands)

    def adopted(
        self, other: Dag, roots: Iterable[int], given: Mapping[Symbol, int] | None = None
    ) -> list[int]:
        """Nodes of another graph as nodes of this one; given symbols become nodes of this one."""
        new: dict[int, int] = {}
        roots, given = list(roots), given or {}
        for node in other.reachable(roots):
            symbol = other.symbol_of(node)
            if symbol is not None and symbol in given:
                new[node] = given[symbol]
            else:
                new[node] = self.adopt(other, node, tuple(new[x] for x in other.operands(node)))
        return [new[root] for root in roots]

    def substitute(self, roots: Iterable[int], replacement: Mapping[int, int]) -> list[int]:
        """Replace nodes below the roots; replacements are not searched again."""
        done = dict(replacement)
        roots = list(roots)
        for node in self.reachable(roots):
            if node not in done:
                operands = self.operands(node)
                new = tuple(done[x] for x in operands)
                done[node] = node if new == operands else self.rebuild(node, new)
        return [done[root] for root in roots]

    # --- inside ---------------------------------------------------------------------

    def _append(self, op: int, a: int, b: int, c: int, level: int) -> int:
        self.op.append(op)
        self.a.append(a)
        self.b.append(b)
        self.c.append(c)
        self.level.append(level)
        return len(self.op) - 1

    def _make(self, op: int, a: int, b: int = -1, c: int = -1) -> int:
        key = (op, a, b, c)
        node = self._nodes.get(key)
        if node is not None:
            return node
        levels = self.level
        level = levels[a]
        if b >= 0 and levels[b] > level:
            level = levels[b]
        if c >= 0 and levels[c] > level:
            level = levels[c]
        node = self._nodes[key] = len(self.op)
        self.op.append(op)
        self.a.append(a)
        self.b.append(b)
        self.c.append(c)
        levels.append(level)
        return node

    def _exact(self, value: Fraction) -> int | None:
        """The node of a computed constant, None if the fraction is too long."""
        long = value.numerator.bit_length() + value.denominator.bit_length() > _MAX_BITS
        return None if long else self.const(value)

    def _whole_power(self, a: int, exponent: int) -> int:
        if exponent < 0:
            return self.div(self.one, self._whole_power(a, -exponent))
        if exponent == 0:
            return self.one
        half = self._whole_power(a, exponent // 2)
        square = self.mul(half, half)
        return self.mul(square, a) if exponent % 2 else square


_METHODS: dict[int, Callable[..., int]] = {
    _ADD: Dag.add,
    _SUB: Dag.sub,
    _MUL: Dag.mul,
    _DIV: Dag.div,
    _NEG: Dag.neg,
    _POW: Dag.pow,
    _SELECT: Dag.select,
}
