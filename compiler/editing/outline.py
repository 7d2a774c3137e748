"""The declarations of a file as a tree, for the outline of an editor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from bgc.diagnostics.source import Span
from bgc.editing.symbols import Kind
from bgc.grammar import syntax
from bgc.resolution.modules import flatten


@dataclass(frozen=True, slots=True)
class Heading:
    """A declaration: its name, a short text, its whole place and that of its name."""

    name: str
    detail: str
    kind: Kind
    span: Span
    name_span: Span
    inner: tuple[Heading, ...] = ()


def outline(file: syntax.File) -> tuple[Heading, ...]:
    """Return the declarations of a file with their members."""
    return tuple(map(_declaration, file.declarations))


def _declaration(node: syntax.Declaration) -> Heading:
    match node:
        case syntax.Model():
            base = f"is {node.base.name}" if node.base is not None else ""
            kind = Kind.INTERFACE if node.interface else Kind.MODEL
            inner = tuple(_members(node.items))
            return Heading(node.name, base, kind, node.span, node.name_span, inner)
        case syntax.Scene():
            detail = f"of {node.model.name}" if node.model is not None else ""
            detail = f"is {node.base.name}" if node.base is not None else detail
            return Heading(node.name, detail, Kind.SCENE, node.span, node.name_span)
        case syntax.Domain():
            return Heading(node.name, "", Kind.DOMAIN, node.span, node.name_span)
        case syntax.Function():
            arguments = ", ".join(formal.name for formal in node.formals)
            return Heading(node.name, f"({arguments})", Kind.FUNCTION, node.span, node.name_span)
        case syntax.Value():
            return Heading(node.name, node.kind, Kind.VALUE, node.span, node.name_span)


def _members(items: Iterable[syntax.Item]) -> Iterator[Heading]:
    for item in flatten(tuple(items)):
        match item:
            case syntax.Value():
                yield Heading(item.name, item.kind, Kind.VALUE, item.span, item.name_span)
            case syntax.Port():
                detail = item.domain or ""
                yield Heading(item.name, detail, Kind.PORT, item.span, item.name_span)
            case syntax.Part():
                yield Heading(item.name, item.type.name, Kind.PART, item.span, item.name_span)
            case _:
                pass
