"""`interpolate(xs, ys, x)` and `interpolate(xs, ys, Z, x, y)`: tables of data as nodes."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.table import Grid, Method, Outside, Table
from bgc.diagnostics.catalogue import data as catalogue
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.catalogue import values as value_messages
from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.record_class import dataclass, replace
from bgc.values.arithmetic import Operand, failure, require_scalar
from bgc.values.data_expressions import Column
from bgc.values.scope import Namespace
from bgc.values.slopes import pchip_slopes, spline_slopes
from bgc.values.units import Dimension, describe_dimension
from bgc.values.value import Value, describe_shape

if TYPE_CHECKING:
    from numpy.typing import NDArray

METHODS = ("linear", "pchip", "spline", "nearest")
OUTSIDE = ("hold", "error", "extrapolate", "repeat")
OPTIONS = {"method": METHODS, "outside": OUTSIDE}
_SAME = 1e-9  # difference of two slopes below which they are one, over the larger


@dataclass(frozen=True, slots=True)
class Known:
    """An argument of data: numbers, their unit and place."""

    name: str
    array: NDArray[Any]
    unit: Dimension | None
    span: Span


def read_options(named: Sequence[tuple[str, syntax.Expr]], span: Span) -> dict[str, str]:
    """The named arguments, with their defaults."""
    found = {"method": "linear", "outside": "hold"}
    given: set[str] = set()
    for name, value in named:
        allowed = OPTIONS.get(name)
        if allowed is None or name in given:
            raise failure(catalogue.interpolate_option(value.span, name, "", list(OPTIONS)))
        chosen = value.name if isinstance(value, syntax.Name) else value.span.text
        if chosen not in allowed:
            raise failure(catalogue.interpolate_option(value.span, name, chosen, list(allowed)))
        found[name] = chosen
        given.add(name)
    return found


def known(dag: Dag, found: Value | Namespace, span: Span, what: str) -> Known:
    """The numbers of an argument, which has to be data or an expression of constants."""
    import numpy as np  # takes longer to load than most models to compile

    if isinstance(found, Column):
        numbers = found.numbers
        return Known(numbers.name, numbers.array, numbers.unit, span)
    if not isinstance(found, Value):
        raise failure(value_messages.not_a_value(span, found.description))
    if any(dag.level[node] != Level.CONST for node in found.nodes):
        raise failure(value_messages.not_constant(span, what))
    values = np.array(evaluate_nodes(dag, found.nodes, {})).reshape(found.shape)
    if not np.isfinite(values).all():
        raise failure(value_messages.not_a_number(span))
    name = " ".join(span.text.split())
    units = list(dict.fromkeys(unit for unit in found.units if unit is not None))
    if len(units) > 1:
        raise failure(
            value_messages.wrong_unit(span, f"`{name}`", *map(describe_dimension, units[:2]))
        )
    return Known(name, values, units[0] if units else None, span)


def interpolate(
    dag: Dag, data: Sequence[Known], at: Sequence[Operand], options: Mapping[str, str], span: Span
) -> Value:
    """The value of an interpolant: nodes that look a table up, component by component."""
    for knots in data[: len(at)]:
        _check_knots(knots)
    for knots, place in zip(data, at, strict=False):
        _check_unit(knots, place)
    values = data[-1]
    if len(at) == 1:
        _check_shape(values, (len(data[0].array),))
        table = make_table(data[0], values, options)
        nodes = tuple(dag.look_up(table, node) for node in at[0].value.nodes)
        shape = at[0].shape
    else:
        if options["method"] == "pchip":
            raise failure(
                catalogue.interpolate_option(
                    span, "method", "pchip", ["linear", "spline", "nearest"]
                )
            )
        _check_shape(values, (len(data[0].array), len(data[1].array)))
        x, y = (require_scalar(place, "an argument of `interpolate`") for place in at)
        nodes, shape = (_on_grid(dag, data, (x, y), options),), ()
    for node in nodes:
        dag.mark(node, span)
    return Value.uniform(shape, nodes, values.unit)


# --- checks -------------------------------------------------------------------------------------


def _check_knots(knots: Known) -> None:
    import numpy as np

    if knots.array.ndim != 1:
        found = describe_shape(knots.array.shape)
        raise failure(
            shape_messages.wrong_argument_shape(knots.span, "interpolate", "a vector", found)
        )
    if len(knots.array) < 2:
        raise failure(catalogue.too_few_knots(knots.span, knots.name, len(knots.array)))
    falls = np.flatnonzero(np.diff(knots.array) <= 0)
    if len(falls):
        k = int(falls[0])
        before, after = float(knots.array[k]), float(knots.array[k + 1])
        raise failure(catalogue.knots_fall(knots.span, knots.name, k + 2, before, after))


def _check_shape(values: Known, expected: tuple[int, ...]) -> None:
    if values.array.shape != expected:
        found, needed = describe_shape(values.array.shape), describe_shape(expected)
        raise failure(catalogue.data_lengths(values.span, values.name, found, needed))


def _check_unit(knots: Known, place: Operand) -> None:
    for unit in place.value.units:
        if unit is not None and knots.unit is not None and unit != knots.unit:
            what = f"the argument for `{knots.name}`"
            raise failure(
                value_messages.wrong_unit(
                    place.span, what, describe_dimension(knots.unit), describe_dimension(unit)
                )
            )


# --- tables -------------------------------------------------------------------------------------


def make_table(knots: Known, values: Known, options: Mapping[str, str]) -> Table:
    """The table of one argument that a method makes of data, with its breaks."""
    import numpy as np

    x, y = knots.array, values.array
    repeat = options["outside"] == "repeat"
    if repeat and y[0] != y[-1]:
        raise failure(catalogue.repeat_jumps(values.span, values.name, float(y[0]), float(y[-1])))
    outside = {"extrapolate": Outside.EXTRAPOLATE, "repeat": Outside.REPEAT}.get(
        options["outside"], Outside.HOLD
    )
    slopes = np.empty(0)
    match options["method"]:
        case "nearest":
            method, outside = Method.NEAREST, outside if repeat else Outside.HOLD
            breaks = np.flatnonzero(np.diff(y) != 0)
            seam = False
        case "linear":
            method = Method.LINEAR
            chords = np.diff(y) / np.diff(x)
            beyond = 0.0 if outside is Outside.HOLD else 1.0  # of the slope at each end
            around = np.concatenate((chords[:1] * beyond, chords, chords[-1:] * beyond))
            breaks = np.flatnonzero(_differ(around[1:], around[:-1]))
            seam = bool(_differ(chords[:1], chords[-1:])[0])
            if repeat:
                breaks = np.flatnonzero(_differ(chords[1:], chords[:-1]))
        case name:
            method = Method.CUBIC
            slopes = (pchip_slopes if name == "pchip" else spline_slopes)(x, y, repeat)
            ends_at = np.array([0, len(x) - 1])
            moving = np.abs(slopes[ends_at]) > _SAME * np.abs(slopes).max()
            breaks = ends_at[moving] if outside is Outside.HOLD else ends_at[:0]
            seam = False
    boundaries = len(x) - 1 if method is Method.NEAREST else len(x) - 2 if repeat else len(x)
    return Table(
        method=method,
        outside=outside,
        x=_doubles(x),
        y=_doubles(y),
        d=_doubles(slopes),
        breaks=None if len(breaks) == boundaries else array("i", breaks.tolist()),
        smooth=not len(breaks) and not seam,
        continuous=method is not Method.NEAREST,
        source=values.name,
        strict=options["outside"] == "error",
    )


def _differ(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Find the knots at which two slopes differ by more than rounding."""
    import numpy as np

    found: NDArray[Any] = np.abs(a - b) > _SAME * np.maximum(np.abs(a), np.abs(b))
    return found


def _doubles(values: NDArray[Any]) -> array[float]:
    import numpy as np

    return array("d", np.ascontiguousarray(values, float).tobytes())


def _on_grid(
    dag: Dag, data: Sequence[Known], at: tuple[int, int], options: Mapping[str, str]
) -> int:
    """A grid at two nodes.

    Each argument first passes a table of its own knots, which continues it outside. The breaks of
    `linear` and `nearest` are those of tables of one argument: the knots around it, the nearest.
    """
    method, outside = options["method"], options["outside"]
    axes, values = data[:2], data[2]
    z = values.array
    if outside == "repeat" and ((z[0] != z[-1]).any() or (z[:, 0] != z[:, -1]).any()):
        row = int((z[:, 0] != z[:, -1]).argmax())
        first, last = (z[row, 0], z[row, -1]) if z[row, 0] != z[row, -1] else (z[0, 0], z[-1, 0])
        raise failure(catalogue.repeat_jumps(values.span, values.name, float(first), float(last)))
    inside = [_inside(dag, k, node, outside) for k, node in zip(axes, at, strict=True)]
    fields: tuple[NDArray[Any], ...] = ()
    if method == "spline":
        repeat = outside == "repeat"
        by_x, by_y = (
            spline_slopes(axes[0].array, z, repeat),
            spline_slopes(axes[1].array, z.T, repeat).T,
        )
        fields = (by_x, by_y, spline_slopes(axes[1].array, by_x.T, repeat).T)
    grid = Grid(
        _doubles(axes[0].array),
        _doubles(axes[1].array),
        _doubles(z.ravel()),
        tuple(_doubles(each.ravel()) for each in fields),
        values.name,
    )
    if method == "nearest":
        nearest = {"method": "nearest", "outside": "hold"}
        at_knots = (
            dag.look_up(make_table(k, _named(k, "nearest"), nearest), x)
            for k, x in zip(axes, inside, strict=True)
        )
        return dag.look_up(grid, *at_knots)
    if method == "linear":
        return _bilinear(dag, grid, axes, at if outside == "extrapolate" else inside)
    value = dag.look_up(grid, *inside)
    if outside == "extrapolate":
        over = [dag.sub(x, held) for x, held in zip(at, inside, strict=True)]
        by = [dag.call(Op.LOOKUP2, dag.const(grid.number + k), *inside) for k in (1, 4, 5)]
        terms = zip(by, (*over, dag.mul(*over)), strict=True)
        value = dag.sum((value, *(dag.mul(slope, way) for slope, way in terms)))
    return value


def _inside(dag: Dag, knots: Known, node: int, outside: str) -> int:
    """An argument within its knots: held at the ends, or taken back by whole periods."""
    if outside != "repeat":
        held = "error" if outside == "error" else "hold"
        options = {"method": "linear", "outside": held}
        return dag.look_up(make_table(knots, _named(knots, "within"), options), node)
    x = _doubles(knots.array)
    ends = array("d", (x[0], x[-1]))
    wrapped = Table(
        method=Method.LINEAR,
        outside=Outside.REPEAT,
        x=ends,
        y=ends,
        d=array("d"),
        breaks=array("i"),
        smooth=False,
        continuous=False,
        source=f"{knots.name}, within",
    )
    return dag.look_up(wrapped, node)


def _named(knots: Known, what: str) -> Known:
    """The knots as values, with a name that says what they are."""
    return replace(knots, name=f"{knots.name}, {what}")


def _bilinear(dag: Dag, grid: Grid, axes: Sequence[Known], at: Sequence[int]) -> int:
    """A bilinear function by the corners of the cell, which changes at the knots."""
    corners, parts = [], []
    for knots, x in zip(axes, at, strict=True):
        low, high = (_step(dag, grid, knots, shift, x) for shift in (0, 1))
        corners.append((low, high))
        parts.append(dag.div(dag.sub(x, low), dag.sub(high, low)))
    (a, b), (c, d) = corners
    first, last = (
        _between(dag, dag.look_up(grid, x, c), dag.look_up(grid, x, d), parts[1]) for x in (a, b)
    )
    return _between(dag, first, last, parts[0])


def _between(dag: Dag, low: int, high: int, part: int) -> int:
    return dag.add(low, dag.mul(part, dag.sub(high, low)))


def _step(dag: Dag, grid: Grid, knots: Known, shift: int, x: int) -> int:
    """The knot at the start (shift 0) or the end (1) of the interval of a node."""
    import numpy as np

    values = knots.array[shift : shift + len(knots.array) - 1]
    table = Table(
        method=Method.STEP,
        outside=Outside.HOLD,
        x=_doubles(knots.array),
        y=_doubles(np.append(values, values[-1])),
        d=array("d"),
        breaks=None,
        smooth=len(knots.array) == 2,
        continuous=False,
        source=f"{knots.name}, {'after' if shift else 'before'}",
    )
    return dag.look_up(table, x)
