"""Find and replace the nodes and indices in a representation, by the types of its fields.

A dataclass of `bgc.ir` tells by its types what its fields hold: a `Node` of the DAG, or an index
of a bond, an element, a state .. . A pass over the DAG is a function from nodes to nodes, and
needs no list of the fields.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import is_dataclass, replace
from functools import cache
from typing import Annotated, Any, TypeAlias, TypeVar, get_args, get_origin, get_type_hints

from bgc.algebra.dag import Dag
from bgc.algebra.nodes import Node

# Indices are named for the field of the representation that they number.
BondIndex: TypeAlias = Annotated[int, "bonds"]
ElementIndex: TypeAlias = Annotated[int, "elements"]
StateIndex: TypeAlias = Annotated[int, "states"]
RateIndex: TypeAlias = Annotated[int, "rates"]
PortIndex: TypeAlias = Annotated[int, "ports"]
ClassIndex: TypeAlias = Annotated[int, "classes"]
BasisIndex: TypeAlias = Annotated[int, "basis"]
RowIndex: TypeAlias = Annotated[int, "rows"]
INDICES: Mapping[str, Any] = {
    get_args(kind)[1]: kind
    for kind in (
        BondIndex,
        ElementIndex,
        StateIndex,
        RateIndex,
        PortIndex,
        ClassIndex,
        BasisIndex,
        RowIndex,
    )
}
"""The types of indices by the names of the fields that they number."""

_Record = TypeVar("_Record")
_Map: TypeAlias = Callable[[Any, Callable[[int], int]], Any]


def map_nodes(record: _Record, dag: Dag, new: Callable[[Node], Node]) -> _Record:
    """Replace every node `n` of a graph or a program by `new(n)`, a node of `dag`.

    Records within it that have a DAG of their own remain as they are.
    """
    kind: Any = type(record)
    mapped: _Record = replace(_record_map(kind, Node)(record, new), dag=dag)
    return mapped


def nodes_of(record: object) -> list[Node]:
    """All nodes of a record in the order of its fields, possibly repeated."""
    return values_of(record, Node)


def values_of(record: Any, kind: Any) -> list[int]:
    """All values of a record whose type is `kind`: `Node`, or one of the types of indices."""
    found: list[int] = []

    def note(value: int) -> int:
        found.append(value)
        return value

    own: Any = type(record)
    _record_map(own, kind)(record, note)
    return found


@cache
def _record_map(record: Any, kind: Any) -> _Map:
    """The function that replaces all values of a kind in a dataclass."""
    hints = get_type_hints(record, include_extras=True)
    maps = {name: found for name, hint in hints.items() if (found := _map_of(hint, kind))}

    def mapped(value: Any, new: Callable[[int], int]) -> Any:
        return replace(value, **{name: maps[name](getattr(value, name), new) for name in maps})

    return mapped if maps else _unchanged


@cache
def _map_of(hint: Any, kind: Any) -> _Map | None:
    """The function that replaces all values of a kind in a value of a type; None without any."""
    if hint == kind:
        return lambda value, new: new(value)
    if is_dataclass(hint):
        own = "dag" in hint.__dataclass_fields__
        found = _unchanged if own else _record_map(hint, kind)  # type: ignore[arg-type]
        return None if found is _unchanged else found
    items = [_map_of(item, kind) or _unchanged for item in get_args(hint)]
    if all(item is _unchanged for item in items):
        return None
    if get_origin(hint) is frozenset:
        return lambda value, new: frozenset(items[0](item, new) for item in value)
    if get_origin(hint) is not tuple:  # a union, of records or with None
        return _union_map(dict(zip(get_args(hint), items, strict=True)))
    if get_args(hint)[-1] is ...:
        return lambda value, new: tuple(items[0](item, new) for item in value)
    return lambda value, new: tuple(
        map_item(item, new) for map_item, item in zip(items, value, strict=True)
    )


def _union_map(maps: dict[Any, _Map]) -> _Map:
    """The map of a union: by the class of the value, else the one type beside None."""
    none = type(None)
    if none in maps and len(maps) == 2:
        (other,) = (found for hint, found in maps.items() if hint is not none)
        return lambda value, new: None if value is None else other(value, new)
    return lambda value, new: maps[type(value)](value, new)


def _unchanged(value: Any, _: Callable[[int], int]) -> Any:
    return value
