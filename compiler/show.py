"""Every intermediate result as text, for `bgc show --after PASS` and the golden files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from typing import Any

from bgc.dag import Kind, Symbol
from bgc.grammar.source import Source, Span
from bgc.grammar.syntax import File
from bgc.infix import infix_lines, number
from bgc.program import Program

_WIDTH = 100


def show_syntax(file: File) -> str:
    """The syntax tree, a node a line where it fits, indented where it does not; no spans."""
    nodes = (*file.imports, *file.declarations)
    return "".join(f"{_tree(node, 0)}\n" for node in nodes)


def _tree(node: Any, indent: int) -> str:
    flat = _flat(node)
    if len(flat) + indent <= _WIDTH:
        return flat
    pad = " " * (indent + 2)
    if isinstance(node, tuple):
        inner = [_tree(item, indent + 2) for item in node]
        return "(\n" + "".join(f"{pad}{item}\n" for item in inner) + " " * indent + ")"
    named = [f"{name} = {_tree(value, indent + 2)}" for name, value in _fields(node)]
    body = "".join(f"{pad}{item}\n" for item in named)
    return f"{type(node).__name__}(\n{body}{' ' * indent})"


def _flat(node: Any) -> str:
    match node:
        case tuple():
            return f"({', '.join(_flat(item) for item in node)})"
        case Fraction():
            return number(node)
        case Enum():
            return str(node.value)
        case _ if is_dataclass(node):
            inner = ", ".join(f"{name} = {_flat(value)}" for name, value in _fields(node))
            return f"{type(node).__name__}({inner})"
        case _:
            return repr(node)


def _fields(node: Any) -> list[tuple[str, Any]]:
    """What tells two nodes apart: no spans, and nothing that is absent or empty."""
    found = ((f.name, getattr(node, f.name)) for f in fields(node))
    return [
        (name, value)
        for name, value in found
        if not isinstance(value, Span | Source) and value not in (None, (), "", False)
    ]
