"""Operators on values, with the checks of shapes and units that belong to them.

A vector or matrix of one component is accepted wherever a scalar is needed, so that models of any
width may have width 1, and `transpose(p)*W*p` is a number.

Every function takes operands with their places in the source, and raises BgError at such a place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction

from bgc.algebra.dag import Dag, Op
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.catalogue import values as catalogue
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Span
from bgc.record_class import dataclass
from bgc.values.units import (
    DIMENSIONLESS,
    Dimension,
    describe_dimension,
    divide,
    power,
    preferred,
    written_text,
)
from bgc.values.units import multiply as multiply_dimensions
from bgc.values.value import Shape, Value, describe_shape

MAX_COMPONENTS = 100_000
_MAX_PRODUCTS = 4_000_000
_MAX_UNIT_EXPONENT = 100
_MAX_EXACT_BITS = 512


@dataclass(frozen=True, slots=True)
class Operand:
    """A value, and the place of the expression that it comes from."""

    value: Value
    span: Span

    @property
    def shape(self) -> Shape:
        """The shape of the value."""
        return self.value.shape


def failure(diagnostic: Diagnostic) -> BgError:
    """Make the error that ends the evaluation of an expression."""
    return BgError([diagnostic])


# --- requirements -----------------------------------------------------------------------


def require_scalar(operand: Operand, what: str, help: str = "") -> int:
    """Return the node of a scalar operand; refuse any other shape."""
    if len(operand.value.nodes) != 1:
        found = describe_shape(operand.shape)
        raise failure(shape_messages.needs_scalar(operand.span, what, found, help))
    return operand.value.node


def require_plain(operand: Operand, what: str) -> None:
    """Refuse components with a unit; an unknown unit is accepted."""
    for unit in operand.value.units:
        if unit is not None and unit != DIMENSIONLESS:
            raise failure(
                catalogue.needs_plain_number(operand.span, what, describe_dimension(unit))
            )


def require_size(span: Span, components: int, what: str) -> None:
    """Refuse a size that would take the compiler minutes or all memory."""
    if components > MAX_COMPONENTS:
        raise failure(shape_messages.too_large(span, what))


# --- componentwise ----------------------------------------------------------------------


def unify(operands: Sequence[Operand], operator: str) -> tuple[Shape, tuple[Dimension | None, ...]]:
    """The shape and units that all operands share; a known unit replaces an unknown one."""
    first = operands[0]
    shape, units = first.shape, list(first.value.units)
    for operand in operands[1:]:
        if operand.shape != shape and not len(units) == len(operand.value.units) == 1:
            one, two = describe_shape(shape), describe_shape(operand.shape)
            context = _CONTEXTS.get(operator, f"`{operator}`")
            pair = ((first.span, one), (operand.span, two))
            raise failure(shape_messages.shapes_differ(context, *pair))
        shape = max(shape, operand.shape, key=len)
        for place, unit in enumerate(operand.value.units):
            if unit is not None and units[place] not in (unit, None):
                known = next(x for x in operands if x.value.units[place] == units[place])
                raise _different_kinds(known, operand, operator, place)
            units[place] = preferred(units[place], unit)
    return shape, tuple(units)


_CONTEXTS = {
    "+": "a sum",
    "-": "a difference",
    "if": "the two branches of `if`",
    **dict.fromkeys(("<", "<=", ">", ">=", "==", "!="), "a comparison"),
}


def _different_kinds(left: Operand, right: Operand, operator: str, place: int) -> BgError:
    one, two = (_kind(operand.value, place) for operand in (left, right))
    row, column = divmod(place, right.shape[-1] if right.shape else 1)
    index = ("", f"[{place + 1}]", f"[{row + 1}, {column + 1}]")[len(right.shape)]
    context = _CONTEXTS.get(operator, f"`{operator}`")
    return failure(
        catalogue.cannot_combine(operator, context, (left.span, one), (right.span, two), index)
    )


def _kind(value: Value, place: int) -> str:
    """The kind of quantity of a component whose unit is known."""
    unit = value.units[place]
    assert unit is not None
    return describe_dimension(unit)


def combine(
    operator: str, function: Callable[[int, int], int], left: Operand, right: Operand
) -> Value:
    """Combine two values of equal shapes and units component by component: sums, differences."""
    shape, units = unify((left, right), operator)
    pairs = zip(left.value.nodes, right.value.nodes, strict=True)
    return Value(shape, tuple(function(x, y) for x, y in pairs), units)


def negate(dag: Dag, operand: Operand) -> Value:
    """The opposite of each component."""
    value = operand.value
    return Value(value.shape, tuple(dag.neg(node) for node in value.nodes), value.units)


# `a > b` is `b < a`, and `a != b` is `not a == b`.
_RELATIONS = {"<": Op.LT, ">": Op.LT, "<=": Op.LE, ">=": Op.LE, "==": Op.EQ, "!=": Op.EQ}


def compare(dag: Dag, operator: str, left: Operand, right: Operand) -> Value:
    """Compare two scalars by `< <= > >= == !=`: 1 if it holds, else 0."""
    a = require_scalar(left, f"what `{operator}` compares", "compare `norm(v)`, or a component")
    b = require_scalar(right, f"what `{operator}` compares", "compare `norm(v)`, or a component")
    unify((left, right), operator)
    if operator in (">", ">="):
        a, b = b, a
    if operator in ("==", "!="):
        a, b = min(a, b), max(a, b)
    node = dag.call(_RELATIONS[operator], a, b)
    return Value.scalar(dag.call(Op.NOT, node) if operator == "!=" else node, DIMENSIONLESS)


def truth(operand: Operand, what: str) -> int:
    """The node of a condition: a dimensionless scalar, true if it is not zero."""
    node = require_scalar(operand, what)
    require_plain(operand, what)
    return node


def select(dag: Dag, condition: int, yes: Operand, no: Operand) -> Value:
    """Choose between two values of one shape, component by component."""
    shape, units = unify((yes, no), "if")
    pairs = zip(yes.value.nodes, no.value.nodes, strict=True)
    return Value(shape, tuple(dag.select(condition, x, y) for x, y in pairs), units)


# --- products, quotients, powers --------------------------------------------------------


def product_unit(left: Dimension | None, right: Dimension | None) -> Dimension | None:
    """The unit of a product; unknown if that of a factor is."""
    if left is None or right is None:
        return None
    for factor, other in ((left, right), (right, left)):
        if factor == DIMENSIONLESS and written_text(factor) in ("", "1"):
            return other  # with its words
    return multiply_dimensions(left, right)


def multiply(dag: Dag, left: Operand, right: Operand) -> Value:
    """Multiply scalars, a scalar and any value, or matrices and vectors."""
    if not left.shape or not right.shape:
        scalar, other = (left, right) if not left.shape else (right, left)
        return scale(dag, scalar.value, other.value)
    shape: Shape
    match left.shape, right.shape:
        case (_, inner), (size,) if inner == size:
            columns, shape = 1, (left.shape[0],)
        case (_, inner), (rows, columns) if inner == rows:
            shape = (left.shape[0], columns)
        case _ if len(left.value.nodes) == 1:
            return scale(dag, left.value, right.value)
        case _ if len(right.value.nodes) == 1:
            return scale(dag, right.value, left.value)
        case _:
            raise _no_product(left, right)
    span = left.span.to(right.span)
    if left.shape[0] * inner * columns > _MAX_PRODUCTS:
        raise failure(shape_messages.too_large(span, "this product"))
    sums = [
        dot_product(
            dag,
            left.value.components_at(range(i * inner, (i + 1) * inner)),
            right.value.components_at(range(j, inner * columns, columns)),
            span,
        )
        for i in range(left.shape[0])
        for j in range(columns)
    ]
    return Value(shape, tuple(node for node, _ in sums), tuple(unit for _, unit in sums))


def _no_product(left: Operand, right: Operand) -> BgError:
    match len(left.shape), len(right.shape):
        case 1, 1:
            help = "use `dot(a, b)`, `cross(a, b)` or `outer(a, b)`"
        case 1, 2 if left.shape[0] == right.shape[0]:
            help = "a vector is a column: use `transpose(A)*v`"
        case _:
            help = "the columns of the left must be as many as the rows of the right"
    one, two = describe_shape(left.shape), describe_shape(right.shape)
    return failure(shape_messages.no_product((left.span, one), (right.span, two), help))


Component = tuple[int, Dimension | None]


def dot_product(
    dag: Dag,
    left: Iterable[Component],
    right: Iterable[Component],
    span: Span,
) -> Component:
    """Sum products of nodes with units; a product with a constant zero fits any unit."""
    total, known = dag.zero, None
    for (x, x_unit), (y, y_unit) in zip(left, right, strict=True):
        if dag.zero in (x, y):
            continue
        total = dag.add(total, dag.mul(x, y))
        unit = product_unit(x_unit, y_unit)
        if unit is not None and known is not None and unit != known:
            one, two = describe_dimension(known), describe_dimension(unit)
            raise failure(catalogue.mixed_terms(span, one, two))
        known = unit if known is None else known
    return total, known


def scale(dag: Dag, scalar: Value, other: Value) -> Value:
    """Multiply any value by a scalar."""
    node, unit = scalar.node, scalar.units[0]
    return Value(
        other.shape,
        tuple(dag.mul(node, each) for each in other.nodes),
        tuple(product_unit(unit, each) for each in other.units),
    )


def quotient(dag: Dag, left: Operand, right: Operand) -> Value:
    """Divide any value by a scalar."""
    help = "there is `inv(A)` for matrices" if len(right.shape) == 2 else "divide by a component"
    divisor = require_scalar(right, "a divisor", help)
    if divisor == dag.zero:
        raise failure(catalogue.division_by_zero(right.span))
    unit = right.value.units[0]
    return Value(
        left.shape,
        tuple(dag.div(node, divisor) for node in left.value.nodes),
        tuple(
            None if each is None or unit is None else divide(each, unit)
            for each in left.value.units
        ),
    )


def raise_to(dag: Dag, base: Operand, exponent: Operand) -> Value:
    """Raise a scalar to a scalar power, which must be constant if the base has a unit."""
    a = require_scalar(base, "the base of `^`", "a matrix is multiplied with `*`")
    b = require_scalar(exponent, "an exponent")
    require_plain(exponent, "an exponent")
    constant = dag.value(b)
    if a == dag.zero and constant is not None and constant < 0:
        raise failure(catalogue.division_by_zero(base.span.to(exponent.span)))
    unit = base.value.units[0]
    if unit is not None and unit != DIMENSIONLESS:
        if constant is None or abs(constant) > _MAX_UNIT_EXPONENT:
            raise failure(
                catalogue.needs_constant_exponent(exponent.span, describe_dimension(unit))
            )
        unit = power(unit, Fraction(constant).limit_denominator(1000))
    exact = dag.value(a)
    if exact is not None and constant is not None and _is_short_power(exact, constant):
        return Value.scalar(dag.const(exact ** int(constant)), unit)
    return Value.scalar(dag.pow(a, b), unit)


def _is_short_power(base: Fraction, exponent: Fraction) -> bool:
    """Test whether a constant power is whole and its exact value short."""
    digits = base.numerator.bit_length() + base.denominator.bit_length()
    return exponent.denominator == 1 and abs(exponent) * digits <= _MAX_EXACT_BITS
