"""The functions of the language, one row each: arguments, shapes, units, documentation.

Functions of real numbers come from `algebra.operations`; those of vectors and matrices, and the two
whose arguments are not plain values, have their rows here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import TypeAlias

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.operation import Operation
from bgc.diagnostics.catalogue import data as data_messages
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.catalogue import values as catalogue
from bgc.diagnostics.catalogue.syntax import empty_vector
from bgc.diagnostics.source import Span
from bgc.record_class import dataclass
from bgc.values import vectors
from bgc.values.arithmetic import Operand, failure, require_plain, require_scalar, unify
from bgc.values.constants import constant_number
from bgc.values.units import DIMENSIONLESS, Dimension, power
from bgc.values.value import Value, describe_shape

Operands: TypeAlias = Sequence[Operand]
Implementation: TypeAlias = Callable[[Dag, str, Operands, Span], Value]


@dataclass(frozen=True, slots=True)
class Builtin:
    """A function of the language.

    Attributes
    ----------
    arguments
        The names of its arguments, as `y, x`.
    doc
        Its meaning in one line.
    shapes, units
        Shapes and units, in one line each, written `arguments -> result`.
    least, most
        How many arguments it takes; `most` is None for any number.
    apply
        The function on values. None for `block` and `der`, which `expressions` evaluates, since
        their arguments are not plain values.
    jumps
        Whether the result jumps, so that a run has to locate the jump and end a step there.
    """

    arguments: str
    doc: str
    shapes: str
    units: str
    least: int
    most: int | None
    apply: Implementation | None
    jumps: bool = False


_OF_SOME = frozenset({"sum", "max", "min"})  # a vector of no components has none of these


def call(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """Apply the function of that name, which must be one of `BUILTINS` with an `apply`."""
    builtin = BUILTINS[name]
    assert builtin.apply is not None, name
    require_count(name, len(arguments), span)
    for argument in arguments if name in _OF_SOME else ():
        if not argument.value.nodes:
            raise failure(empty_vector(argument.span))
    return builtin.apply(dag, name, arguments, span)


def require_count(name: str, found: int, span: Span) -> None:
    """Refuse a number of arguments that the function of that name does not take."""
    builtin = BUILTINS[name]
    if found < builtin.least or (builtin.most is not None and found > builtin.most):
        raise failure(catalogue.wrong_argument_count(span, name, _arity(builtin), found))


def _arity(builtin: Builtin) -> str:
    if builtin.most is None:
        return f"at least {count(builtin.least)}"
    if builtin.least == builtin.most:
        return count(builtin.least)
    return f"{builtin.least} or {count(builtin.most)}"


def count(number: int) -> str:
    """Count arguments in words: `1 argument`, `3 arguments`."""
    return f"{number} argument" + ("" if number == 1 else "s")


# --- functions of real numbers ------------------------------------------------------------------


def _result_unit(row: Operation, unit: Dimension | None) -> Dimension | None:
    """The unit of the result from that of the argument; None where it is not known."""
    if row.unit_power == 0:
        return DIMENSIONLESS
    return unit if unit is None or row.unit_power == 1 else power(unit, row.unit_power)


def _componentwise(op: Op, dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """A function of one number, or of each component of a vector."""
    (operand,) = arguments
    if len(operand.shape) == 2:
        found = describe_shape(operand.shape)
        raise failure(
            shape_messages.wrong_argument_shape(operand.span, name, "a scalar or a vector", found)
        )
    if op.row.plain:
        require_plain(operand, f"the argument of `{name}`")
    value = operand.value
    nodes = tuple(dag.call(op, node) for node in value.nodes)
    return Value(value.shape, nodes, tuple(_result_unit(op.row, unit) for unit in value.units))


def _of_two(op: Op, dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """A function of two scalars of one unit."""
    nodes = [require_scalar(argument, f"an argument of `{name}`") for argument in arguments]
    _, units = unify(arguments, name)
    return Value.scalar(dag.call(op, *nodes), _result_unit(op.row, units[0]))


def _of_several(op: Op, dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """A function of several values component by component, or of the components of one."""
    if len(arguments) == 1:
        arguments = [Operand(part, arguments[0].span) for part in arguments[0].value.components]
    shape, units = unify(arguments, name)
    nodes = list(arguments[0].value.nodes)
    for argument in arguments[1:]:
        pairs = zip(nodes, argument.value.nodes, strict=True)
        nodes = [dag.call(op, x, y) for x, y in pairs]
    return Value(shape, tuple(nodes), tuple(_result_unit(op.row, unit) for unit in units))


def _random(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """A random number at an index; whole numbers that are known here are checked."""
    for argument, what in zip(arguments, ("the seed", "the index"), strict=True):
        node = require_scalar(argument, f"{what} of `{name}`")
        require_plain(argument, f"{what} of `{name}`")
        number = constant_number(dag, node)
        if dag.level[node] > Level.PARAM or (number is not None and not _is_whole(number)):
            found = "" if number is None else f"{float(number):.15g}"
            raise failure(data_messages.random_of_what_varies(argument.span, what, found))
    return _of_two(Op.RANDOM, dag, name, arguments, span)


def _is_whole(number: Fraction | float) -> bool:
    return number == int(number) and -_MOST_WHOLE < number < _MOST_WHOLE


_MOST_WHOLE = 2**53  # whole numbers below it are exact doubles


def _builtin_of(op: Op) -> Builtin:
    """The function that an operation is in the language."""
    row = op.row
    jumps = row.jump is not None and not row.kink
    units = _describe_units(row)
    arguments = ", ".join(row.arguments)
    if row.variadic:
        shapes = "values of one shape -> the same shape, or a vector -> a scalar"
        apply = partial(_of_several, op)
        return Builtin(f"{arguments}, ..", row.doc, shapes, units, 1, None, apply, jumps)
    if row.arity == 1:
        shapes = "a scalar, or a vector component by component -> the same shape"
        return Builtin(arguments, row.doc, shapes, units, 1, 1, partial(_componentwise, op), jumps)
    shapes = "scalars -> a scalar"
    apply = partial(_of_two, op)
    return Builtin(arguments, row.doc, shapes, units, row.arity, row.arity, apply, jumps)


def _describe_units(row: Operation) -> str:
    """The units of arguments and result of an operation, in words."""
    several = row.arity > 1
    argument = "dimensionless" if row.plain else "any, the same for all" if several else "any"
    if row.unit_power in (0, 1):
        return f"{argument} -> {'the same' if row.unit_power else 'dimensionless'}"
    return f"{argument} -> that of x to the power {row.unit_power}"


# --- the table ----------------------------------------------------------------------------------

BUILTINS: Mapping[str, Builtin] = {
    **{op.row.name: _builtin_of(op) for op in Op if op.row.name and op.row.smooth},
    "random": Builtin(
        "seed, i",
        Op.RANDOM.row.doc,
        "scalars of constants and parameters -> a scalar",
        "dimensionless -> dimensionless",
        2,
        2,
        _random,
    ),
    "dot": Builtin(
        "a, b",
        "Scalar product of two vectors.",
        "two vectors of one length -> a scalar",
        "any whose products agree -> that of the products",
        2,
        2,
        vectors.dot,
    ),
    "cross": Builtin(
        "a, b",
        "Vector product of two vectors.",
        "two vectors of 3 -> a vector of 3",
        "any whose products agree -> that of the products",
        2,
        2,
        vectors.cross,
    ),
    "norm": Builtin(
        "a",
        "Euclidean length of a vector.",
        "a vector -> a scalar",
        "any, the same for all components -> the same",
        1,
        1,
        vectors.norm,
    ),
    "sum": Builtin(
        "a",
        "Sum of all components.",
        "any -> a scalar",
        "any, the same for all components -> the same",
        1,
        1,
        vectors.total,
    ),
    "length": Builtin(
        "a",
        "Number of components of a vector, known when the model is compiled.",
        "a vector -> a scalar",
        "any -> dimensionless",
        1,
        1,
        vectors.length,
    ),
    "transpose": Builtin(
        "a",
        "Transpose of a matrix; a vector, which is a column, becomes a matrix of one row.",
        "an m x n matrix or a vector of n -> an n x m or a 1 x n matrix",
        "any -> those of the components",
        1,
        1,
        vectors.transpose,
    ),
    "outer": Builtin(
        "a, b",
        "Matrix of the products of every component of a with every component of b.",
        "vectors of m and n -> an m x n matrix",
        "any -> those of the products",
        2,
        2,
        vectors.outer,
    ),
    "skew": Builtin(
        "a",
        "Skew-symmetric matrix S with S b = cross(a, b).",
        "a vector of 3 -> a 3 x 3 matrix",
        "any -> those of the components",
        1,
        1,
        vectors.skew,
    ),
    "diag": Builtin(
        "a",
        "Diagonal matrix of a vector, or the diagonal of a square matrix.",
        "a vector of n -> an n x n matrix, or an n x n matrix -> a vector of n",
        "any -> those of the components",
        1,
        1,
        vectors.diag,
    ),
    "stack": Builtin(
        "a, ..",
        "Scalars and vectors end to end, or matrices of one width above each other.",
        "scalars and vectors, or matrices of one width -> a vector, or a matrix",
        "any -> those of the components",
        1,
        None,
        vectors.stack,
    ),
    "inv": Builtin(
        "a",
        "Inverse of a square matrix of constants and parameters.",
        "a scalar or an n x n matrix -> the same shape",
        "any -> its reciprocal if all components share it, else unknown",
        1,
        1,
        vectors.inv,
    ),
    "zeros": Builtin(
        "m, n",
        "Vector of m zeros, or m x n matrix of zeros.",
        "one or two whole constants -> a vector of m, or an m x n matrix",
        "dimensionless -> fits any",
        1,
        2,
        vectors.filled,
    ),
    "ones": Builtin(
        "m, n",
        "Vector of m ones, or m x n matrix of ones.",
        "one or two whole constants -> a vector of m, or an m x n matrix",
        "dimensionless -> fits any",
        1,
        2,
        vectors.filled,
    ),
    "eye": Builtin(
        "n",
        "Identity matrix.",
        "a whole constant -> an n x n matrix",
        "dimensionless -> fits any",
        1,
        1,
        vectors.eye,
    ),
    "block": Builtin(
        "[[A, B], [C, D]]",
        "Matrix made of matrices; a plain 0 is a block of zeros of the size that fits.",
        "rows of matrices, vectors and scalars that fit -> a matrix",
        "any -> those of the components",
        1,
        1,
        None,
    ),
    "data": Builtin(
        "file",
        "Columns of a CSV file or values of a JSON file, by name.",
        "a text -> a table of columns, or of values by key",
        "none -> those of the titles, as `z [mm]`",
        1,
        1,
        None,
    ),
    "interpolate": Builtin(
        "xs, ys, Z, x, y",
        "Value at x of data ys at knots xs, or at (x, y) of a matrix Z; by `method`, `outside`.",
        "vectors of n, and a scalar or vector -> the shape of x; or m, n, m x n and two scalars "
        "-> a scalar",
        "those of x fit xs -> that of the data",
        3,
        5,
        None,
    ),
    "fmu": Builtin(
        "file, read, name, value",
        "Variables of an FMU of another tool, which steps with a sampled part (`bgc import`); FMUs "
        "of your own are made by `bgc build --target fmu2`.",
        "a text, a list of n texts, then pairs of a text and a scalar -> a vector of n",
        "those of the FMU's variables -> those of the FMU's variables",
        2,
        None,
        None,
    ),
    "jacobian": Builtin(
        "y, x",
        "Partial derivatives of y by the states, signals or inputs x, all others held constant.",
        "a scalar or vector of m, and a list of n quantities or one scalar -> an m x n matrix, or "
        "the shape of y",
        "any -> those of y over those of x",
        2,
        2,
        None,
    ),
    "der": Builtin(
        "x",
        "Time derivative of a declared state, in an equation.",
        "any -> the same shape",
        "any -> that of x per second",
        1,
        1,
        None,
    ),
}
"""All functions of the language by name."""
