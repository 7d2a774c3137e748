"""Select components of values: `v[2]`, `v[2..4]`, `A[1, 2]`, `A[1..3, 2]`, `v.x`."""

from __future__ import annotations

from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.source import Span
from bgc.record_class import dataclass
from bgc.values.arithmetic import failure
from bgc.values.value import Shape, Value, describe_shape

_AXES = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class Selection:
    """One evaluated index: `first..last`, both inclusive from 1, or a single place."""

    first: int
    last: int
    single: bool
    span: Span


def axis_of(name: str) -> int:
    """The place of component `x`, `y` or `z`, from 1; 0 for another name."""
    return _AXES.index(name) + 1 if name in _AXES else 0


def member(value: Value, name: str, span: Span) -> Value:
    """Component `.x`, `.y` or `.z` of a vector."""
    if name in _AXES and len(value.shape) == 1 and len(value.nodes) > _AXES.index(name):
        return value.components[_AXES.index(name)]
    raise failure(shape_messages.no_component(span, name, describe_shape(value.shape)))


def check_selection(shape: Shape, selections: tuple[Selection, ...], span: Span) -> None:
    """Refuse indices that a value of this shape does not have."""
    described = describe_shape(shape)
    if len(selections) != len(shape):
        raise failure(
            shape_messages.wrong_index_count(span, described, len(shape), len(selections))
        )
    for selection, size in zip(selections, shape, strict=True):
        for place in (selection.first, selection.last):
            if not 1 <= place <= size:
                raise failure(
                    shape_messages.index_out_of_range(selection.span, place, size, described)
                )


def select(value: Value, selections: tuple[Selection, ...], span: Span) -> Value:
    """Select components of a vector or matrix; a single index removes its dimension."""
    check_selection(value.shape, selections, span)
    places = [0]
    for selection, size in zip(selections, value.shape, strict=True):
        chosen = range(selection.first - 1, selection.last)
        places = [place * size + k for place in places for k in chosen]
    return Value(
        tuple(s.last - s.first + 1 for s in selections if not s.single),
        tuple(value.nodes[place] for place in places),
        tuple(value.units[place] for place in places),
    )
