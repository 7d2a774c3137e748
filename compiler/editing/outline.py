"""The declarations of a file as a tree, for the outline of an editor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from bgc.diagnostics.source import Span
from bgc.editing.symbols import Kind, kind_of
from bgc.grammar import syntax
from bgc.record_class import dataclass
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
    detail = ""
    match node:
        case syntax.Model() | syntax.Scene() if node.base is not None:
            detail = f"is {node.base.name}"
        case syntax.Scene(model=syntax.TypeUse(name=name)):
            detail = f"of {name}"
        case syntax.Function():
            detail = f"({', '.join(formal.name for formal in node.formals)})"
        case syntax.Value():
            detail = node.kind
        case _:
            pass
    inner = tuple(_members(node.items)) if isinstance(node, syntax.Model) else ()
    return Heading(node.name, detail, kind_of(node), node.span, node.name_span, inner)


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
