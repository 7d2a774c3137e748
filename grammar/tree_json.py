"""Syntax trees as JSON, and the way back without parsing.

A tree is one list of values: its constants, its spans, then its nodes and tuples, each behind its
parts. A node is written as the number of its class and the places of its fields in the list. What
is one object in the tree is one object again. Long chains of operators need no recursion.
"""

from __future__ import annotations

import json
from dataclasses import fields
from fractions import Fraction
from typing import Any

from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax


def _as_tuple(*items: Any) -> tuple[Any, ...]:
    return items


_KINDS: dict[str, Any] = {"tuple": _as_tuple} | {
    name: kind for name, kind in vars(syntax).items() if isinstance(kind, type)
}


def tree_to_json(file: syntax.File) -> str:
    """Write the syntax tree of a text; equal trees give the same text."""
    constants: dict[tuple[type, object], None] = {}
    spans: dict[int, Span] = {}
    nodes: dict[int, tuple[object, list[object]]] = {}  # with their parts, each behind its parts
    stack: list[tuple[object, list[object] | None]] = [((file.imports, file.declarations), None)]
    while stack:
        value, parts = stack.pop()
        if parts is not None:
            nodes.setdefault(id(value), (value, parts))
        elif isinstance(value, Span):
            spans[id(value)] = value
        elif isinstance(value, str | int | None):
            constants[type(value), value] = None
        elif id(value) not in nodes:
            parts = _parts(value)
            stack += [(value, parts), *((part, None) for part in reversed(parts))]
    names = sorted({type(value).__name__ for value, _ in nodes.values()})
    numbers = {name: k for k, name in enumerate(names)}
    places: dict[object, int] = {key: k for k, key in enumerate([*constants, *spans, *nodes])}
    rows = [
        [numbers[type(value).__name__], *(places[_key(part)] for part in parts)]
        for value, parts in nodes.values()
    ]
    tree = {
        "kinds": names,
        "constants": [value for _, value in constants],
        "spans": [offset for span in spans.values() for offset in (span.start, span.end)],
        "nodes": rows,
    }
    return json.dumps(tree, separators=(",", ":"))


def tree_from_json(text: str, source: Source) -> syntax.File:
    """Read the syntax tree of a source from what `tree_to_json` wrote.

    Raises ValueError, TypeError or LookupError where it is none.
    """
    tree = json.loads(text)
    kinds = [_KINDS[name] for name in tree["kinds"]]
    values: list[Any] = tree["constants"]
    offsets = iter(tree["spans"])
    values += [Span(source, start, end) for start, end in zip(offsets, offsets, strict=True)]
    value_at = values.__getitem__
    for kind, *places in tree["nodes"]:
        values.append(kinds[kind](*map(value_at, places)))
    imports, declarations = values[-1]
    return syntax.File(source, imports, declarations)


def _parts(value: object) -> list[object]:
    """What a node or tuple is made from again: its fields, items, or value."""
    match value:
        case tuple():
            return [*value]
        case Fraction():
            return [value.numerator, value.denominator]
        case syntax.Direction():
            return [value.value]
        case _:
            return [getattr(value, field.name) for field in fields(value)]  # type: ignore[arg-type]


def _key(value: object) -> object:
    """What identifies a value: its type and itself if it is a constant, else the object."""
    return (type(value), value) if isinstance(value, str | int | None) else id(value)
