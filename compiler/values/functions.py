"""The functions of the language: their names, arguments, shapes and units."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import TypeAlias

from bgc.algebra.dag import Dag, Op
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.catalogue import values as catalogue
from bgc.diagnostics.source import Span
from bgc.values import vectors
from bgc.values.arithmetic import Operand, failure, require_plain, require_scalar, unify
from bgc.values.units import DIMENSIONLESS, Dimension, power
from bgc.values.value import Value, describe_shape

Operands: TypeAlias = Sequence[Operand]
Implementation: TypeAlias = Callable[[Dag, str, Operands, Span], Value]


@dataclass(frozen=True, slots=True)
class Builtin:
    """A function: how many arguments it takes (`most` None: any number) and what it does."""

    least: int
    most: int | None
    apply: Implementation


def call(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """Apply the function of that name, which must be one of `BUILTINS`."""
    builtin = BUILTINS[name]
    found = len(arguments)
    if found < builtin.least or (builtin.most is not None and found > builtin.most):
        raise failure(catalogue.wrong_argument_count(span, name, _arity(builtin), found))
    return builtin.apply(dag, name, arguments, span)


def _arity(builtin: Builtin) -> str:
    if builtin.most is None:
        return f"at least {count(builtin.least)}"
    if builtin.least == builtin.most:
        return count(builtin.least)
    return f"{builtin.least} or {count(builtin.most)}"


def count(number: int) -> str:
    """`1 argument`, `3 arguments`."""
    return f"{number} argument" + ("" if number == 1 else "s")


# --- of real numbers --------------------------------------------------------------------


def _each(
    dag: Dag, operand: Operand, op: Op, unit: Callable[[Dimension | None], Dimension | None]
) -> Value:
    """A function of one number, of each component of a vector."""
    value = operand.value
    nodes = tuple(dag.call(op, node) for node in value.nodes)
    return Value(value.shape, nodes, tuple(unit(each) for each in value.units))


def _refuse_matrix(name: str, operand: Operand) -> None:
    if len(operand.shape) == 2:
        found = describe_shape(operand.shape)
        raise failure(
            shape_messages.wrong_argument_shape(operand.span, name, "a scalar or a vector", found)
        )


def _plain(op: Op, dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """From plain numbers to plain numbers: `sin`, `exp`."""
    _refuse_matrix(name, arguments[0])
    require_plain(arguments[0], f"the argument of `{name}`")
    return _each(dag, arguments[0], op, lambda unit: DIMENSIONLESS)


def _root(
    op: Op, exponent: Fraction, dag: Dag, name: str, arguments: Operands, span: Span
) -> Value:
    _refuse_matrix(name, arguments[0])
    return _each(dag, arguments[0], op, lambda unit: unit and power(unit, exponent))


def _abs(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    _refuse_matrix(name, arguments[0])
    return _each(dag, arguments[0], Op.ABS, lambda unit: unit)


def _signum(dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    _refuse_matrix(name, arguments[0])
    return _each(dag, arguments[0], Op.SIGN, lambda unit: DIMENSIONLESS)


def _binary(op: Op, plain: bool, dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """Of two scalars of one kind: `atan2`, `hypot`, `fmod`."""
    nodes = [require_scalar(argument, f"an argument of `{name}`") for argument in arguments]
    _, units = unify(arguments, name)
    return Value.scalar(dag.call(op, *nodes), DIMENSIONLESS if plain else units[0])


def _extreme(op: Op, dag: Dag, name: str, arguments: Operands, span: Span) -> Value:
    """`min`, `max`: of several values component by component, or of the components of one."""
    if len(arguments) == 1:
        arguments = [Operand(part, arguments[0].span) for part in arguments[0].value.components]
    shape, units = unify(arguments, name)
    nodes = list(arguments[0].value.nodes)
    for argument in arguments[1:]:
        pairs = zip(nodes, argument.value.nodes, strict=True)
        nodes = [dag.call(op, x, y) for x, y in pairs]
    return Value(shape, tuple(nodes), units)


# --- the table --------------------------------------------------------------------------

_PLAIN_FUNCTIONS = {
    "sin": Op.SIN,
    "cos": Op.COS,
    "tan": Op.TAN,
    "asin": Op.ASIN,
    "acos": Op.ACOS,
    "atan": Op.ATAN,
    "sinh": Op.SINH,
    "cosh": Op.COSH,
    "tanh": Op.TANH,
    "asinh": Op.ASINH,
    "acosh": Op.ACOSH,
    "atanh": Op.ATANH,
    "exp": Op.EXP,
    "log": Op.LOG,
    "log10": Op.LOG10,
    "expm1": Op.EXPM1,
    "log1p": Op.LOG1P,
    "floor": Op.FLOOR,
    "ceil": Op.CEIL,
    "erf": Op.ERF,
}

BUILTINS: Mapping[str, Builtin] = {
    **{name: Builtin(1, 1, partial(_plain, op)) for name, op in _PLAIN_FUNCTIONS.items()},
    "sqrt": Builtin(1, 1, partial(_root, Op.SQRT, Fraction(1, 2))),
    "cbrt": Builtin(1, 1, partial(_root, Op.CBRT, Fraction(1, 3))),
    "abs": Builtin(1, 1, _abs),
    "sign": Builtin(1, 1, _signum),
    "atan2": Builtin(2, 2, partial(_binary, Op.ATAN2, True)),
    "hypot": Builtin(2, 2, partial(_binary, Op.HYPOT, False)),
    "fmod": Builtin(2, 2, partial(_binary, Op.FMOD, False)),
    "min": Builtin(1, None, partial(_extreme, Op.MIN)),
    "max": Builtin(1, None, partial(_extreme, Op.MAX)),
    "dot": Builtin(2, 2, vectors.dot),
    "cross": Builtin(2, 2, vectors.cross),
    "norm": Builtin(1, 1, vectors.norm),
    "sum": Builtin(1, 1, vectors.total),
    "length": Builtin(1, 1, vectors.length),
    "transpose": Builtin(1, 1, vectors.transpose),
    "outer": Builtin(2, 2, vectors.outer),
    "skew": Builtin(1, 1, vectors.skew),
    "diag": Builtin(1, 1, vectors.diag),
    "stack": Builtin(1, None, vectors.stack),
    "inv": Builtin(1, 1, vectors.inv),
    "zeros": Builtin(1, 2, vectors.filled),
    "ones": Builtin(1, 2, vectors.filled),
    "eye": Builtin(1, 1, vectors.eye),
}
"""All functions but `block` and `der`, whose arguments are no plain values."""
