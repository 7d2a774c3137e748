"""Functions of vectors and matrices, with checks of shapes and units."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import prod
from typing import TypeAlias

from bgc.algebra import linalg
from bgc.algebra.dag import Dag, Level, Op
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.catalogue import values as catalogue
from bgc.diagnostics.source import Span
from bgc.values.arithmetic import (
    Component,
    Operand,
    combine,
    dot_product,
    failure,
    product_unit,
    require_size,
)
from bgc.values.constants import whole_number
from bgc.values.units import DIMENSIONLESS, power
from bgc.values.value import Value, describe_shape

Operands: TypeAlias = Sequence[Operand]

_MAX_INVERSE = 48
_LARGEST_SIZE = 10**9  # larger sizes are refused anyway

# --- of vectors -------------------------------------------------------------------------


def _vector(name: str, operand: Operand, size: int | None = None) -> Value:
    shape = operand.shape
    if len(shape) != 1 or (size is not None and shape[0] != size):
        expected = "a vector" if size is None else f"a vector of {size}"
        raise failure(
            shape_messages.wrong_argument_shape(operand.span, name, expected, describe_shape(shape))
        )
    return operand.value


def _parts(value: Value) -> list[Component]:
    return list(zip(value.nodes, value.units, strict=True))


def _from_parts(shape: tuple[int, ...], parts: Sequence[Component]) -> Value:
    return Value(shape, tuple(node for node, _ in parts), tuple(unit for _, unit in parts))


def dot(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """Sum of products of two vectors."""
    one, two = arguments
    left, right = _vector(name, one), _vector(name, two)
    if left.shape != right.shape:
        shapes = [(each.span, describe_shape(each.shape)) for each in arguments]
        raise failure(shape_messages.shapes_differ(f"`{name}`", shapes[0], shapes[1]))
    return _from_parts((), [dot_product(dag, _parts(left), _parts(right), span)])


def cross(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The vector product."""
    one, two = arguments
    a, b = _parts(_vector(name, one, 3)), _parts(_vector(name, two, 3))
    negative = [(dag.neg(node), unit) for node, unit in b]
    parts = [
        dot_product(dag, (a[i], a[j]), (b[j], negative[i]), span)
        for i, j in ((1, 2), (2, 0), (0, 1))
    ]
    return _from_parts((3,), parts)


def norm(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The Euclidean length."""
    (argument,) = arguments
    parts = _parts(_vector(name, argument))
    square, unit = dot_product(dag, parts, parts, span)
    return Value.scalar(dag.call(Op.SQRT, square), unit and power(unit, Fraction(1, 2)))


def total(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The sum of all components."""
    parts = [Operand(part, arguments[0].span) for part in arguments[0].value.components]
    so_far = parts[0]
    for part in parts[1:]:
        so_far = Operand(combine("+", dag.add, so_far, part), part.span)
    return so_far.value


def length(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The number of components."""
    return Value.scalar(dag.const(len(_vector(name, arguments[0]).nodes)), DIMENSIONLESS)


# --- of matrices ------------------------------------------------------------------------


def transpose(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The transpose; a vector, which is a column, becomes a matrix of one row."""
    value = arguments[0].value
    match value.shape:
        case ():
            return value
        case (size,):
            return Value((1, size), value.nodes, value.units)
        case rows, columns:
            order = (i * columns + j for j in range(columns) for i in range(rows))
            return _from_parts((columns, rows), list(value.components_at(order)))
    raise AssertionError(value.shape)


def outer(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The outer product of two vectors."""
    left, right = (_vector(name, argument) for argument in arguments)
    require_size(span, len(left.nodes) * len(right.nodes), "this matrix")
    parts = [
        (dag.mul(x, y), product_unit(x_unit, y_unit))
        for x, x_unit in _parts(left)
        for y, y_unit in _parts(right)
    ]
    return _from_parts((left.shape[0], right.shape[0]), parts)


def skew(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The skew-symmetric matrix S(a) with S(a) b = a x b."""
    (x, u), (y, v), (z, w) = _parts(_vector(name, arguments[0], 3))
    zero = (dag.zero, None)
    parts = [
        zero, (dag.neg(z), w), (y, v),
        (z, w), zero, (dag.neg(x), u),
        (dag.neg(y), v), (x, u), zero,
    ]  # fmt: skip
    return _from_parts((3, 3), parts)


def diag(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The diagonal matrix of a vector, or the diagonal of a square matrix."""
    value = arguments[0].value
    if len(value.shape) == 2:
        _require_square(name, arguments[0])
        places = range(0, len(value.nodes), value.shape[0] + 1)
        return _from_parts((value.shape[0],), list(value.components_at(places)))
    size = len(_vector(name, arguments[0]).nodes)
    require_size(span, size * size, "this matrix")
    parts = _parts(value)
    zero: Component = (dag.zero, None)
    return _from_parts(
        (size, size), [parts[i] if i == j else zero for i in range(size) for j in range(size)]
    )


def _require_square(name: str, operand: Operand) -> int:
    if len(operand.shape) != 2 or operand.shape[0] != operand.shape[1]:
        found = describe_shape(operand.shape)
        raise failure(
            shape_messages.wrong_argument_shape(operand.span, name, "a square matrix", found)
        )
    return operand.shape[0]


def stack(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """Concatenate scalars and vectors, or matrices of equal width row by row."""
    first = arguments[0]
    for argument in arguments[1:]:
        matrices = len(first.shape) == 2 or len(argument.shape) == 2
        if matrices and first.shape[1:] != argument.shape[1:]:
            one, two = describe_shape(first.shape), describe_shape(argument.shape)
            raise failure(
                shape_messages.shapes_differ(f"`{name}`", (first.span, one), (argument.span, two))
            )
    parts = [part for argument in arguments for part in _parts(argument.value)]
    require_size(span, len(parts), "this vector")
    if len(first.shape) < 2:
        return _from_parts((len(parts),), parts)
    return _from_parts((len(parts) // first.shape[1], first.shape[1]), parts)


def inv(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The inverse of a matrix of constants and parameters."""
    (argument,) = arguments
    value = argument.value
    if any(dag.level[node] > Level.PARAM for node in value.nodes):
        raise failure(catalogue.varying_inverse(argument.span))
    size = 1
    if value.shape:
        size = _require_square(name, argument)
    if size > _MAX_INVERSE:
        raise failure(shape_messages.too_large(argument.span, "this matrix, to be inverted,"))
    try:
        inverse = linalg.inverse(dag, value.rows)
    except linalg.SingularMatrixError:
        raise failure(catalogue.singular_matrix(argument.span)) from None
    unit = value.unit
    nodes = (node for row in inverse for node in row)
    return Value.uniform(value.shape, nodes, unit and power(unit, -1))


# --- matrices from sizes ----------------------------------------------------------------


def filled(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """A vector (`zeros(n)`, `ones(n)`) or matrix (`zeros(m, n)`) of equal numbers."""
    shape = tuple(_size_argument(dag, name, argument) for argument in arguments)
    require_size(span, prod(shape), "this value")
    return Value.uniform(shape, [dag.zero if name == "zeros" else dag.one] * prod(shape))


def eye(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """The identity matrix."""
    size = _size_argument(dag, name, arguments[0])
    require_size(span, size * size, "this matrix")
    return Value.matrix(linalg.identity(dag, size))


def _size_argument(dag: Dag, name: str, argument: Operand) -> int:
    return whole_number(dag, argument, f"an argument of `{name}`", 1, _LARGEST_SIZE)
