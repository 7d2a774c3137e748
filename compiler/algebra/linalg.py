"""Linear algebra on small matrices of DAG nodes.

Zeros known at compile time are never multiplied or divided by, so that sparse matrices give sparse
results. The inverse of a symmetric matrix is symmetric, node for node.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from fractions import Fraction
from math import isqrt

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.disjoint_sets import DisjointSets
from bgc.algebra.evaluate import evaluate_nodes, to_double
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.nodes import Matrix, Node
from bgc.algebra.rational_inverse import SingularRowsError, inverse_of

LARGE = 8  # rows from which on the number of operations decides


class SingularMatrixError(Exception):
    """The matrix is singular for all values of its symbols."""


def _freeze(rows: Sequence[Sequence[Node]]) -> Matrix:
    """Freeze rows of nodes."""
    return tuple(tuple(row) for row in rows)


def identity(dag: Dag, size: int) -> Matrix:
    """Ones on the diagonal."""
    return diagonal(dag, [dag.one] * size)


def diagonal(dag: Dag, nodes: Sequence[Node]) -> Matrix:
    """A square matrix with these nodes on its diagonal."""
    size = range(len(nodes))
    return tuple(tuple(nodes[i] if i == j else dag.zero for j in size) for i in size)


def transpose(matrix: Matrix) -> Matrix:
    """The transpose of a matrix."""
    return tuple(zip(*matrix, strict=True))


def multiply(dag: Dag, left: Matrix, right: Matrix) -> Matrix:
    """The product of an m x k and a k x n matrix."""
    columns = transpose(right)
    return tuple(tuple(dag.dot(row, column) for column in columns) for row in left)


def apply(dag: Dag, matrix: Matrix, vector: Sequence[Node]) -> tuple[Node, ...]:
    """The product of a matrix and a vector."""
    return tuple(dag.dot(row, vector) for row in matrix)


def connected_blocks(dag: Dag, matrix: Matrix) -> list[tuple[list[int], list[int]]]:
    """Rows and columns of a matrix that nonzero entries connect, as independent blocks.

    In the order of their first rows; blocks without a row come last.
    """
    height, width = len(matrix), len(matrix[0]) if matrix else 0
    sets = DisjointSets(height + width)
    for i, row in enumerate(matrix):
        for j, node in enumerate(row):
            if node != dag.zero:
                sets.unite(i, height + j)
    return [
        ([k for k in group if k < height], [k - height for k in group if k >= height])
        for group in sets.groups()
    ]


def inverse(dag: Dag, matrix: Matrix) -> Matrix:
    """The inverse of a square matrix.

    Blocks of rows and columns that no entry connects are inverted one by one: in rationals if
    constant, by cofactors up to 3 x 3 (which divides by the determinant only), otherwise by
    elimination. From `LARGE` rows on, a matrix of parameters is left to the start of a run
    (`Dag.inverted`), and a symmetric one that varies is eliminated in half a table. Pivots are
    diagonal entries where possible, which are safe in a symmetric positive definite matrix, then
    constants, then entries that may vanish for some parameter values.

    Raises
    ------
    SingularMatrixError
        The matrix is singular for all values of its symbols.
    """
    result = [[dag.zero] * len(matrix) for _ in matrix]
    for rows, columns in connected_blocks(dag, matrix):
        if len(rows) != len(columns):
            raise SingularMatrixError
        block = tuple(tuple(matrix[i][j] for j in columns) for i in rows)
        for column, line in zip(columns, _invert_block(dag, block), strict=True):
            for row, node in zip(rows, line, strict=True):
                result[column][row] = node
    return _freeze(result)


def _invert_block(dag: Dag, block: Matrix) -> Matrix:
    if all(dag.level[node] == Level.CONST for row in block for node in row):
        return _invert_constants(dag, block)
    if len(block) <= 3:
        return _invert_by_cofactors(dag, block)
    if len(block) < LARGE:
        return _invert_by_pivots(dag, block)
    if all(dag.level[node] <= Level.PARAM for row in block for node in row):
        return _invert_at_start(dag, block)
    return _invert_by_elimination(dag, block)


def _invert_at_start(dag: Dag, block: Matrix) -> Matrix:
    """Leave the inverse to the start of a run; of a symmetric one the entries are shared."""
    if Fingerprints(dag).inverse([node for row in block for node in row]) is None:
        raise SingularMatrixError
    size = range(len(block))
    found = dag.inverted(block)
    if not _is_symmetric(block):
        return _freeze(found)
    return tuple(tuple(found[max(i, j)][min(i, j)] for j in size) for i in size)


def spelled_out(dag: Dag, roots: Sequence[Node]) -> list[Node]:
    """The roots with the inverses that are left to a run as operations on their entries."""
    made: dict[Node, Node] = {}
    inverses: dict[Node, Matrix] = {}
    for node in dag.reachable(roots):
        operands = tuple(made[x] for x in dag.operands(node))
        made[node] = node if operands == dag.operands(node) else dag.rebuild(node, operands)
        if dag.op[node] == Op.INVERTED:
            listed = dag.a[made[node]]
            if listed not in inverses:
                entries = dag.listed(listed)
                size = isqrt(len(entries))
                block = [entries[size * i : size * (i + 1)] for i in range(size)]
                inverses[listed] = _invert_by_elimination(dag, _freeze(block))
            row, column = divmod(dag.place_in_inverse(node), len(inverses[listed]))
            made[node] = inverses[listed][row][column]
    return [made[root] for root in roots]


def _invert_by_elimination(dag: Dag, block: Matrix) -> Matrix:
    return _invert_by_sweeps(dag, block) or _invert_by_pivots(dag, block)


def _is_symmetric(block: Matrix) -> bool:
    return all(block[i][j] == block[j][i] for i in range(len(block)) for j in range(i))


def _invert_constants(dag: Dag, block: Matrix) -> Matrix:
    """Invert in rationals; constants that are not rational enter as doubles."""
    numbers = []
    for row in block:
        values = [_rational(dag, node) for node in row]
        numbers.append([value for value in values if value is not None])
        if len(numbers[-1]) < len(row):
            return _invert_by_pivots(dag, block)
    try:
        found = inverse_of(numbers)
    except SingularRowsError:
        raise SingularMatrixError from None
    return tuple(tuple(dag.const(_shorten(entry)) for entry in row) for row in found)


def _rational(dag: Dag, node: Node) -> Fraction | None:
    """The value of a constant; None of one that is infinite or undefined as a double."""
    exact = dag.value(node)
    if exact is not None:
        return exact
    (number,) = evaluate_nodes(dag, [node], {})
    return Fraction(number) if math.isfinite(number) else None


def _shorten(value: Fraction) -> Fraction:
    """The value itself, or its nearest double if the fraction is long and the double normal."""
    if value.numerator.bit_length() + value.denominator.bit_length() <= 256:
        return value
    double = to_double(value)
    normal = math.isfinite(double) and abs(double) >= sys.float_info.min
    return Fraction(double) if normal else value


def _invert_by_cofactors(dag: Dag, block: Matrix) -> Matrix:
    size = range(len(block))
    cofactors = [[_cofactor(dag, block, i, j) for j in size] for i in size]
    determinant = dag.dot(block[0], cofactors[0])
    if determinant == dag.zero:
        raise SingularMatrixError
    return tuple(tuple(dag.div(cofactors[i][j], determinant) for i in size) for j in size)


def _cofactor(dag: Dag, block: Matrix, row: int, column: int) -> Node:
    """The signed determinant of a matrix up to 3 x 3 without one row and one column."""
    minor = [
        [node for j, node in enumerate(line) if j != column]
        for i, line in enumerate(block)
        if i != row
    ]
    match minor:
        case []:
            return dag.one
        case [[single]]:
            determinant = single
        case [[a, b], [c, d]]:
            determinant = dag.sub(dag.mul(a, d), dag.mul(b, c))
        case _:
            raise AssertionError(f"a {len(block)} x {len(block)} matrix")
    return determinant if (row + column) % 2 == 0 else dag.neg(determinant)


def _invert_by_sweeps(dag: Dag, block: Matrix) -> Matrix | None:
    """Invert a symmetric matrix in half the table: n^3/2 products and as many differences.

    The sweep of k replaces `a_ij` by `a_ij - (a_ik/a_kk) a_kj`, `a_ik` by `a_ik/a_kk` and `a_kk` by
    `-1/a_kk`; after all sweeps the table is the negative inverse (Beaton 1964). None where the
    matrix is not symmetric node for node, or a diagonal pivot vanishes.
    """
    size = range(len(block))
    if not _is_symmetric(block):
        return None
    table = [list(row[: i + 1]) for i, row in enumerate(block)]
    left = set(size)
    while left:
        k = min(left, key=lambda k: (sum(table[max(i, k)][min(i, k)] != dag.zero for i in left), k))
        pivot = table[k][k]
        if pivot == dag.zero:
            return None
        left.remove(k)
        reciprocal = dag.div(dag.one, pivot)
        coupled = {
            i: table[max(i, k)][min(i, k)]
            for i in size
            if i != k and table[max(i, k)][min(i, k)] != dag.zero
        }
        for i, entry in coupled.items():
            factor = dag.mul(entry, reciprocal)
            for j in coupled:
                if j <= i:
                    table[i][j] = dag.sub(table[i][j], dag.mul(factor, coupled[j]))
            table[max(i, k)][min(i, k)] = factor
        table[k][k] = dag.neg(reciprocal)
    return tuple(tuple(dag.neg(table[max(i, j)][min(i, j)]) for j in size) for i in size)


def _invert_by_pivots(dag: Dag, block: Matrix) -> Matrix:
    """Invert by exchange steps: y = A x is solved for one x after the other, in place.

    An update is written `(a*b)/pivot`, symmetric in a and b: with diagonal pivots a symmetric
    matrix stays symmetric up to signs, node for node.
    """
    size = range(len(block))
    table = [list(row) for row in block]
    rows, columns = set(size), set(size)
    pivots = []
    while rows:
        r, c = _choose_pivot(dag, table, rows, columns)
        rows.remove(r)
        columns.remove(c)
        pivots.append((r, c))
        reciprocal = dag.div(dag.one, table[r][c])
        row, column = list(table[r]), [table[i][c] for i in size]
        for i in size:
            for j in size:
                if i != r and j != c:
                    change = dag.mul(dag.mul(column[i], row[j]), reciprocal)
                    table[i][j] = dag.sub(table[i][j], change)
                elif i != r:
                    table[i][c] = dag.mul(column[i], reciprocal)
                elif j != c:
                    table[r][j] = dag.neg(dag.mul(row[j], reciprocal))
        table[r][c] = reciprocal
    result = [[dag.zero] * len(block) for _ in size]
    column_of = dict(pivots)
    row_of = {c: r for r, c in pivots}
    for i in size:
        for j in size:
            result[column_of[i]][row_of[j]] = table[i][j]
    return _freeze(result)


def _choose_pivot(
    dag: Dag, table: Sequence[Sequence[Node]], rows: set[int], columns: set[int]
) -> tuple[int, int]:
    """The next pivot by the rules of `inverse`, then by least fill-in (Markowitz)."""
    in_row = {i: sum(table[i][j] != dag.zero for j in columns) for i in rows}
    in_column = {j: sum(table[i][j] != dag.zero for i in rows) for j in columns}
    symmetric = all(table[i][j] == table[j][i] for i in rows for j in columns if j in rows)
    symmetric = symmetric and rows == columns

    def rank(entry: tuple[int, int]) -> tuple[bool, bool, int, int, int]:
        i, j = entry
        off_diagonal = symmetric and i != j
        varies = not symmetric and dag.level[table[i][j]] != Level.CONST
        return off_diagonal, varies, (in_row[i] - 1) * (in_column[j] - 1), i, j

    entries = [(i, j) for i in rows for j in columns if table[i][j] != dag.zero]
    if not entries:
        raise SingularMatrixError
    return min(entries, key=rank)
