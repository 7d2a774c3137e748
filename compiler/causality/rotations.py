"""Inverses of matrices that need no division by anything that may vanish."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from bgc.algebra.dag import Dag
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.linalg import multiply, transpose
from bgc.ir.graph import Matrix, Node


def known_inverse(dag: Dag, fingerprints: Fingerprints, matrix: Matrix) -> Matrix | None:
    """The inverse of a matrix made of rotations and constants; None if none is proven.

    Rotations and other matrices up to 3 x 3 with constant determinant are recognised by their
    fingerprints; block triangular matrices of invertible blocks, such as the transformation of a
    twist between frames, are inverted block by block.
    """
    size = len(matrix)
    if size == 0 or len(matrix[0]) != size:
        return None
    if size == 1:
        value = fingerprints.constant(matrix[0][0])
        return ((dag.const(1 / value),),) if value else None
    if _is_identity(fingerprints, multiply(dag, matrix, transpose(matrix))):
        return transpose(matrix)
    determinant = fingerprints.constant(_determinant(dag, matrix)) if size <= 3 else None
    if determinant:
        return _adjugate(dag, matrix, determinant)
    for split in range(1, size):
        if all(node == dag.zero for row in matrix[split:] for node in row[:split]):
            return _of_upper(dag, fingerprints, matrix, split)
        if all(node == dag.zero for row in matrix[:split] for node in row[split:]):
            turned = _of_upper(dag, fingerprints, transpose(matrix), split)
            return transpose(turned) if turned else None
    return None


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


def _of_upper(dag: Dag, fingerprints: Fingerprints, matrix: Matrix, split: int) -> Matrix | None:
    """The inverse of [[A, B], [0, D]] is [[A^-1, -A^-1 B D^-1], [0, D^-1]]."""
    first = known_inverse(dag, fingerprints, tuple(row[:split] for row in matrix[:split]))
    last = known_inverse(dag, fingerprints, tuple(row[split:] for row in matrix[split:]))
    if first is None or last is None:
        return None
    corner = tuple(row[split:] for row in matrix[:split])
    carried = multiply(dag, multiply(dag, first, corner), last)
    zeros = (dag.zero,) * split
    upper = tuple(
        (*left, *(dag.neg(x) for x in right)) for left, right in zip(first, carried, strict=True)
    )
    return (*upper, *((*zeros, *row) for row in last))


def _is_identity(fingerprints: Fingerprints, matrix: Matrix) -> bool:
    return all(
        fingerprints.constant(node) == int(i == j)
        for i, row in enumerate(matrix)
        for j, node in enumerate(row)
    )
