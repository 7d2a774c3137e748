"""Frozen dataclasses as JSON, and the way back by the types of their fields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

from bgc.diagnostics.source import Source

_NO_TEXTS: Mapping[str, str] = {}
_hints_of = cache(get_type_hints)


def to_json(value: Any) -> Any:
    """Write a dataclass, a tuple or a plain value for JSON; a source as its name alone.

    Other values, such as arrays, are left as they are.
    """
    match value:
        case Source():
            return value.name
        case Enum():
            return value.value
        case tuple():
            return [to_json(item) for item in value]
        case _ if is_dataclass(value):
            return {each.name: to_json(getattr(value, each.name)) for each in fields(value)}
        case _:
            return value


def from_json(kind: Any, value: Any, texts: Mapping[str, str] = _NO_TEXTS) -> Any:
    """Read a value of a type from what `to_json` wrote; `texts` are those of sources by name.

    Raises KeyError, TypeError or ValueError where it is none of that type.
    """
    if kind is Source:
        return Source(value, texts[value])
    choices = get_args(kind)
    if get_origin(kind) is type(value):  # an array
        return value
    if get_origin(kind) is UnionType:
        kind = next((choice for choice in choices if type(value) is choice), choices[0])
        return from_json(kind, value, texts)
    if get_origin(kind) is tuple:
        kinds = choices[:1] * len(value) if Ellipsis in choices else choices
        return tuple(from_json(*pair, texts) for pair in zip(kinds, value, strict=True))
    if get_origin(kind) is Mapping:
        return {key: from_json(choices[1], part, texts) for key, part in {**value}.items()}
    if isinstance(kind, type) and is_dataclass(kind):
        hints = _hints_of(kind)
        read = {name: from_json(hints[name], part, texts) for name, part in {**value}.items()}
        return kind(**read)
    if issubclass(kind, Enum):
        return kind(value)
    if type(value) is not kind and (kind, type(value)) != (float, int):
        raise TypeError(f"{value!r} is not of the type {kind.__name__}")
    return value
