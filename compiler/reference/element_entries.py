"""The basic elements as entries of the reference."""

from __future__ import annotations

from collections.abc import Iterator

from bgc.language.elements import (
    ELEMENTS,
    VARIABLES_OF_ELEMENTS,
    ElementKind,
    Family,
    Role,
)
from bgc.printing.text_tables import Table
from bgc.reference.entry import Block, Code, Entry, Group, Text


def _entry(name: str) -> Entry:
    kind = ELEMENTS[name]
    related = tuple(dict.fromkeys((*kind.related, *_family(kind))))
    return Entry("element", name, kind.title, tuple(_body(kind)), related)


def _family(kind: ElementKind) -> tuple[str, ...]:
    """The modulated forms of an element."""
    return tuple(n for n, k in ELEMENTS.items() if k.basic == kind.name and n != kind.name)


def _body(kind: ElementKind) -> Iterator[Block]:
    yield Code("\n".join(kind.written))
    yield Text(f"Law: {kind.law}")
    yield Text(f"Causality: {kind.causality}")
    yield Text(kind.doc)
    if kind.arguments:
        rows = tuple((a.name, a.role.value, a.doc) for a in kind.arguments)
        first = kind.arguments[0]
        only_starts = all(a.role is Role.INITIAL for a in kind.arguments)
        note = "" if only_starts else f"{first.name} may be given without its name"
        yield Table("arguments", ("name", "kind", "meaning"), rows, note)
    laws = [f"{law.left} = .. in {law.right}" for law in kind.laws]
    laws += [f"H = .. in {' and '.join(kind.energy)}, an energy"] if kind.energy else []
    if laws:
        yield Text(f"A law block holds {', or '.join(laws)}.")
    if kind.observed:
        readable = (f"`x.{v}` ({_meaning(kind, v)})" for v in kind.observed)
        yield Text(f"To be read: {', '.join(readable)}.")


def _meaning(kind: ElementKind, variable: str) -> str:
    if variable != "power":
        return VARIABLES_OF_ELEMENTS[variable]
    return "power out of it" if kind.family is Family.SOURCE else "power into it"


GROUP = Group(
    "elements",
    "the basic elements of a bond graph",
    lambda: {name: kind.title for name, kind in ELEMENTS.items()},
    _entry,
    (
        Text(
            "A part is `name : Type(arguments);`, whether its type is an element or a model. Bonds "
            "are arrows, `a -> b;`, which point the way of positive power."
        ),
    ),
    ("element",),
)
"""All basic elements."""
