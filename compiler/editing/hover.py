"""The text that an editor shows for the name, number or word under the pointer, in Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from bgc.diagnostics.source import Span
from bgc.editing.facts import Facts, place_of
from bgc.editing.file_analysis import Analysis
from bgc.editing.hints import bond_text
from bgc.editing.symbols import Kind, Symbol
from bgc.grammar import syntax
from bgc.grammar.language_words import TABLE
from bgc.grammar.tokens import span_of
from bgc.language.elements import ELEMENTS, VARIABLES_OF_ELEMENTS
from bgc.language.scene_tables import ACCOUNTS, DEVICE_COMMANDS, DEVICE_INPUTS
from bgc.language.shape_table import SHAPES
from bgc.language.solver import SOLVER_OPTIONS
from bgc.reference import (
    element_entries,
    function_entries,
    library_entries,
    unit_entries,
    word_entries,
)
from bgc.reference.entry import Block, Code, Entry, Heading, Text
from bgc.resolution.library import library_modules
from bgc.resolution.modules import flatten

_UNIT = re.compile(r"(?<=\d )\S+\Z")
_READABLE = {
    **VARIABLES_OF_ELEMENTS,
    "H": "energy, in a law",
    "power": "effort times flow",
    "time": "the time in s, from 0 at the start of the run",
    "pi": "the ratio of a circle's circumference to its diameter",
    "energy": "the energy accounts of the scene",
    "x": "first component",
    "y": "second component",
    "z": "third component",
}


def hover(analysis: Analysis, offset: int, facts: Facts) -> tuple[Span, str] | None:
    """Return the place that a text is about, and the text; None where there is nothing to say."""
    found = analysis.at(offset)
    if found is not None and found.symbol is not None:
        return found.span, describe(found.symbol, facts, analysis)
    token = analysis.words.at(offset)
    if token is None:
        return None
    span = span_of(analysis.document.source, token)
    text = str(token)
    if token.type == "NUMBER" and (unit := _UNIT.search(text)):
        return span, _unit(unit[0])
    if token.type == "UNIT":
        return span, _unit(text)
    if token.type == "ARROW":
        return _arrow(analysis, offset, span, facts)
    if text in TABLE and token.type != "NAME":
        return span, _entry(word_entries.WORDS.entry(text))
    return None


def describe(symbol: Symbol, facts: Facts, analysis: Analysis | None = None) -> str:
    """Describe a symbol: its declaration, what the compiler found, its documentation."""
    parts = [*_declaration(symbol), *_found(symbol, facts), *_documentation(symbol)]
    if analysis is not None and symbol.span is not None:
        parts += _bonded(symbol, facts, analysis)
    return "\n\n".join(parts)


def _declaration(symbol: Symbol) -> Iterator[str]:
    node = symbol.node
    if node is None:
        return
    match node:
        case syntax.Model() | syntax.Scene() | syntax.Domain() | syntax.For():
            text = node.span.text.partition("{")[0]
        case syntax.Observe():
            text = f"observe {node.span.text}"
        case _:
            text = node.span.text
    shown = " ".join(text.split())
    home = f"  // of {symbol.owner}" if symbol.owner else ""
    yield f"```bg\n{shown if len(shown) < 200 else shown[:200] + ' ..'}{home}\n```"


def _found(symbol: Symbol, facts: Facts) -> Iterator[str]:
    if symbol.span is None:
        return
    place = place_of(symbol.span)
    values = facts.values.get(place, ())
    if values:
        shown = [
            f"`{v.path}` = {v.value}" if v.value else f"`{v.path}` in {v.unit}" for v in values
        ]
        yield "; ".join(shown[:4]) + (" .." if len(shown) > 4 else "")
    equations = [line for part in facts.parts.get(place, ()) for line in part.equations]
    if equations:
        lines = "\n".join(equations[:6])
        yield f"```text\n{lines}\n```"


def _documentation(symbol: Symbol) -> Iterator[str]:
    if symbol.doc:
        yield symbol.doc
    match symbol.kind:
        case Kind.ELEMENT:
            yield _entry(element_entries.GROUP.entry(symbol.name))
        case Kind.BUILTIN if symbol.name in function_entries.GROUP.summaries():
            yield _entry(function_entries.GROUP.entry(symbol.name))
        case Kind.BUILTIN:
            yield _entry(word_entries.WORDS.entry(symbol.name))
        case Kind.MODULE if symbol.name in library_modules():
            yield f"**{symbol.name}**: {library_entries.GROUP.summaries()[symbol.name]}"
        case Kind.READABLE:
            yield _readable(symbol.name)
        case Kind.OPTION:
            yield _option(symbol)
        case _:
            pass
    node = symbol.node
    if isinstance(node, syntax.Part):
        yield from _type_doc(node.type.name, symbol)


def _type_doc(name: str, symbol: Symbol) -> Iterator[str]:
    if name in ELEMENTS:
        kind = ELEMENTS[name]
        yield f"**{name}**: {kind.title}. {kind.law}"
    elif symbol.module is not None and name in symbol.module.models:
        doc = symbol.module.models[name].syntax.doc
        if doc:
            yield f"**{name}**: {doc}"


def _readable(name: str) -> str:
    channel = DEVICE_INPUTS.get(name) or DEVICE_COMMANDS.get(name)
    if channel is not None:
        return f"**{name}**: {channel.doc}"
    doc = _READABLE.get(name) or ACCOUNTS.get(name) or "a variable"
    return f"**{name}**: {doc}"


def _option(symbol: Symbol) -> str:
    name = symbol.name
    if symbol.owner in ELEMENTS:
        found = [a.doc for a in ELEMENTS[symbol.owner].arguments if a.name == name]
        return f"**{name}**: {found[0]}" if found else f"**{name}**"
    if name in SHAPES:
        return f"**{name}**: {SHAPES[name].doc}\n\n```bg\nshape {SHAPES[name].form(name)};\n```"
    if name in SOLVER_OPTIONS:
        option = SOLVER_OPTIONS[name]
        return f"**{name}**: {option.doc}; by default {option.default}"
    return f"**{name}**"


def _bonded(symbol: Symbol, facts: Facts, analysis: Analysis) -> Iterator[str]:
    """The bonds of a part or port within its own file, with the reasons of their strokes."""
    if symbol.kind not in {Kind.PART, Kind.PORT} or symbol.module is not analysis.module:
        return
    assert symbol.span is not None
    model = analysis.declaration_at(symbol.span.start)
    if not isinstance(model, syntax.Model):
        return
    links = (link for link in _links(model) if symbol.name in map(_first_name, link))
    yield from _bond_texts(links, facts)[:6]


def _links(model: syntax.Model) -> Iterator[tuple[syntax.Expr, syntax.Expr]]:
    for item in flatten(model.items):
        if isinstance(item, syntax.Chain):
            yield from item.links


def _bond_texts(links: Iterable[tuple[syntax.Expr, syntax.Expr]], facts: Facts) -> list[str]:
    found = (facts.bonds.get(place_of(tail.span.to(head.span))) for tail, head in links)
    return [bond_text(bonds) for bonds in found if bonds]


def _first_name(expr: syntax.Expr) -> str:
    while isinstance(expr, syntax.Member | syntax.Index):
        expr = expr.base
    return expr.name if isinstance(expr, syntax.Name) else ""


def _arrow(analysis: Analysis, offset: int, span: Span, facts: Facts) -> tuple[Span, str] | None:
    """The bonds of the arrow under the pointer."""
    model = analysis.declaration_at(offset)
    if not isinstance(model, syntax.Model):
        return None
    links = (
        (tail, head)
        for tail, head in _links(model)
        if tail.span.end <= span.start and span.end <= head.span.start
    )
    texts = _bond_texts(links, facts)
    return (span, "\n\n".join(texts)) if texts else None


def _unit(text: str) -> str:
    found = unit_entries.GROUP.other(text) if unit_entries.GROUP.other is not None else ()
    return _entry(found[0]) if found else f"`{text}` is not a unit"


def _entry(entry: Entry) -> str:
    """The beginning of a page of the reference, without its tables."""
    shown = [f"**{entry.name}**: {entry.summary}"]
    shown += [_block(b) for b in entry.body if isinstance(b, Text | Code | Heading)][:6]
    return "\n\n".join(shown)


def _block(block: Block) -> str:
    match block:
        case Code(text=text):
            return f"```bg\n{text}\n```"
        case Text(text=text) | Heading(text=text):
            return text
        case _:
            return ""
