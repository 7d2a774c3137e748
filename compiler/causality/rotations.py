"""Inverses of matrices that need no division by anything that varies and may vanish."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.linalg import multiply, transpose
from bgc.ir.graph import Matrix, Node
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Inverse:
    """An inverse, and the nodes of at most PARAM level that it divides by."""

    matrix: Matrix
    divisors: tuple[Node, ...] = ()


def known_inverse(dag: Dag, fingerprints: Fingerprints, matrix: Matrix) -> Inverse | None:
    """The inverse of a matrix made of rotations and steady factors; None if none is proven.

    Rotations and other matrices up to 3 x 3 with constant determinant are recognised by their
    fingerprints, and multiples of them by a number or parameter, as in the moduli of a motor; block
    triangular matrices of invertible blocks, such as the transformation of a twist between frames,
    are inverted block by block.
    """
    size = len(matrix)
    if size == 0 or len(matrix[0]) != size:
        return None
    for scale in dict.fromkeys((dag.one, _scale_of(dag, matrix))):
        found = _of_multiple(dag, fingerprints, matrix, scale)
        if found is not None:
            return Inverse(found, () if scale == dag.one else (scale,))
    for split in range(1, size):
        if all(node == dag.zero for row in matrix[split:] for node in row[:split]):
            return _of_upper(dag, fingerprints, matrix, split)
        if all(node == dag.zero for row in matrix[:split] for node in row[split:]):
            turned = _of_upper(dag, fingerprints, transpose(matrix), split)
            return turned and Inverse(transpose(turned.matrix), turned.divisors)
    return None


def _scale_of(dag: Dag, matrix: Matrix) -> Node:
    """The product of the steady factors of the first entry other than zero."""
    node = next((node for row in matrix for node in row if node != dag.zero), dag.one)
    scale, open_ = dag.one, [node]
    while open_:
        node = open_.pop()
        if dag.level[node] <= Level.PARAM:
            scale = dag.mul(scale, node)
        elif dag.op[node] in {Op.NEG, Op.MUL}:
            open_ += dag.operands(node)
    return scale


def _of_multiple(
    dag: Dag, fingerprints: Fingerprints, matrix: Matrix, scale: Node
) -> Matrix | None:
    """The inverse of a scale times a matrix that is orthogonal, or has a constant determinant."""
    size = len(matrix)
    if size == 1:
        value = fingerprints.constant(dag.div(matrix[0][0], scale))
        return ((dag.div(dag.const(1 / value), scale),),) if value else None
    square = dag.mul(scale, scale)
    if _is_diagonal(dag, fingerprints, multiply(dag, matrix, transpose(matrix)), square):
        return _divided(dag, transpose(matrix), square)
    if size > 3:
        return None
    volume = square if size == 2 else dag.mul(square, scale)
    determinant = fingerprints.constant(dag.div(_determinant(dag, matrix), volume))
    if not determinant:
        return None
    return _divided(dag, _adjugate(dag, matrix, determinant), volume)


def _divided(dag: Dag, matrix: Matrix, divisor: Node) -> Matrix:
    return tuple(tuple(dag.div(node, divisor) for node in row) for row in matrix)


def _determinant(dag: Dag, matrix: Matrix) -> Node:
    match matrix:
        case ((a, b), (c, d)):
            return dag.sub(dag.mul(a, d), dag.mul(b, c))
        case _:
            first, second, third = matrix
            return dag.dot(first, _cross(dag, second, third))


def _adjugate(dag: Dag, matrix: Matrix, determinant: Fraction) -> Matrix:
    share = dag.const(1 / determinant)
    match matrix:
        case ((a, b), (c, d)):
            columns: Matrix = ((d, dag.neg(c)), (dag.neg(b), a))
        case _:
            x, y, z = matrix
            columns = (_cross(dag, y, z), _cross(dag, z, x), _cross(dag, x, y))
    return transpose(tuple(tuple(dag.mul(share, node) for node in line) for line in columns))


def _cross(dag: Dag, a: Sequence[Node], b: Sequence[Node]) -> tuple[Node, Node, Node]:
    def minor(i: int, j: int) -> Node:
        return dag.sub(dag.mul(a[i], b[j]), dag.mul(a[j], b[i]))

    return minor(1, 2), minor(2, 0), minor(0, 1)


def _of_upper(dag: Dag, fingerprints: Fingerprints, matrix: Matrix, split: int) -> Inverse | None:
    """The inverse of [[A, B], [0, D]] is [[A^-1, -A^-1 B D^-1], [0, D^-1]]."""
    first = known_inverse(dag, fingerprints, tuple(row[:split] for row in matrix[:split]))
    last = known_inverse(dag, fingerprints, tuple(row[split:] for row in matrix[split:]))
    if first is None or last is None:
        return None
    corner = tuple(row[split:] for row in matrix[:split])
    carried = multiply(dag, multiply(dag, first.matrix, corner), last.matrix)
    zeros = (dag.zero,) * split
    upper = tuple(
        (*left, *(dag.neg(x) for x in right))
        for left, right in zip(first.matrix, carried, strict=True)
    )
    lower = ((*zeros, *row) for row in last.matrix)
    return Inverse((*upper, *lower), (*first.divisors, *last.divisors))


def _is_diagonal(dag: Dag, fingerprints: Fingerprints, matrix: Matrix, entry: Node) -> bool:
    """Return whether a matrix is an entry times the identity."""
    return all(
        fingerprints.equal(node, entry if i == j else dag.zero)
        for i, row in enumerate(matrix)
        for j, node in enumerate(row)
    )
