"""Check a value against the shape, unit and variability required where it is used."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Dag, Level
from bgc.diagnostics.catalogue import shapes, values
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.values.units import Dimension, describe_dimension
from bgc.values.value import Shape, Value, describe_shape

_ALLOWED = {
    Level.CONST: "known at compile time",
    Level.PARAM: "computed from constants and parameters",
    Level.TIME: "computed from constants, parameters and time",
}
_FOUND = {
    Level.PARAM: "depends on a parameter",
    Level.TIME: "depends on time or a device",
    Level.STATE: "depends on a state",
}


def fit_shape(dag: Dag, value: Value, shape: Shape | None, span: Span, what: str) -> Value:
    """Reshape a value.

    A single component fits any shape with one component; a scalar is repeated over a vector; the
    number zero is repeated over a matrix too. Raises BgError for any other mismatch.
    """
    if shape is None or value.shape == shape:
        return value
    count = 1
    for size in shape:
        count *= size
    if len(value.nodes) == count == 1:
        return Value(shape, value.nodes, value.units)
    zero = value.nodes == (dag.zero,)
    if value.is_scalar and (len(shape) == 1 or zero):
        return Value(shape, value.nodes * count, value.units * count)
    expected, found = describe_shape(shape), describe_shape(value.shape)
    raise BgError([shapes.wrong_shape(span, what, expected, found)])


def fit_like(dag: Dag, value: Value, like: Value, span: Span, what: str) -> Value:
    """Give a value the shape of another one, and require the units of that one."""
    fitted = fit_shape(dag, value, like.shape, span, what)
    check_components(fitted, like.units, span, what)
    return fitted


def check_components(
    value: Value, units: Sequence[Dimension | None], span: Span, what: str
) -> None:
    """Raise BgError if a component has a known dimension other than that at its place."""
    for component, unit in zip(value.components, units, strict=True):
        check_units(component, unit, span, what)


def check_value(value: Value, shape: Shape, unit: Dimension | None, span: Span, what: str) -> None:
    """Raise BgError unless a value has this shape and, where both are known, this unit."""
    if value.shape != shape and not (len(value.nodes) == 1 and not shape):
        expected, found = describe_shape(shape), describe_shape(value.shape)
        raise BgError([shapes.wrong_shape(span, what, expected, found)])
    check_units(value, unit, span, what)


def check_units(value: Value, unit: Dimension | None, span: Span, what: str) -> None:
    """Raise BgError if a component has a known dimension other than `unit`."""
    for found in value.units:
        if unit is not None and found is not None and found != unit:
            expected = describe_dimension(unit)
            raise BgError([values.wrong_unit(span, what, expected, describe_dimension(found))])


def require_level(
    dag: Dag, value: Value, most: Level, span: Span, what: str, help: str = ""
) -> None:
    """Raise BgError if the level of a value exceeds `most`."""
    level = level_of(dag, value)
    if level > most:
        raise BgError([values.varies(span, what, _ALLOWED[most], _FOUND[level], help)])


def level_of(dag: Dag, value: Value) -> Level:
    """The highest level among a value's components: constant, parameter, time or state."""
    return Level(max((dag.level[n] for n in value.nodes), default=Level.CONST))
