"""XML elements with their places in the text, without entities."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property
from typing import Any
from xml.parsers import expat

import numpy as np

from bgc.diagnostics.catalogue.imported import not_importable, wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source, Span
from bgc.record_class import dataclass, field

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_DEEPEST = 1_000  # elements within elements
# The text is decoded already, and editors leave blank lines before the declaration.
_DECLARATION = re.compile(r"\A\s*<\?xml\s[^>]*\?>")
_LARGEST_NUMBER = 1e18  # of any number in a robot


@dataclass(slots=True, eq=False)
class Element:
    """An element: its tag, attributes, children, and the place of its opening tag."""

    tag: str
    attributes: dict[str, str]
    span: Span
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> Iterator[Element]:
        """Iterate over the children with a tag."""
        return (child for child in self.children if child.tag == tag)

    def first(self, tag: str) -> Element | None:
        """Return the first child with a tag."""
        return next(self.all(tag), None)

    def place(self, attribute: str) -> Span:
        """Return the place of an attribute's value, or that of the opening tag."""
        pattern = rf"\s{re.escape(attribute)}\s*=\s*([\"'])(.*?)\1"
        found = re.compile(pattern, re.DOTALL).search(
            self.span.source.text, self.span.start, self.span.end
        )
        return self.span if found is None else Span(self.span.source, found.start(2), found.end(2))

    def need(self, attribute: str) -> str:
        """Return an attribute that has to be there; BG138 otherwise."""
        value = self.attributes.get(attribute, "").strip()
        if not value:
            what = f"`<{self.tag}>` has no `{attribute}`"
            raise BgError([wrong_value(self.span, what, f'write `{attribute}=".."`')])
        return value

    def walk(self) -> Iterator[Element]:
        """Iterate over the element and all below it, in the order of the text."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting += reversed(element.children)

    def number(self, attribute: str, default: float | None = None) -> float:
        """Return a number; BG138 where it is not one, or absent without a default."""
        if default is not None and attribute not in self.attributes:
            return default
        return self._read(attribute, self.need(attribute))

    def vector(self, attribute: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Return as many numbers as the default has; BG138 where they are not."""
        if attribute not in self.attributes:
            return default
        words = self.attributes[attribute].split()
        if len(words) != len(default):
            what = f"`{attribute}` has {len(words)} numbers instead of {len(default)}"
            help = f"give {len(default)} numbers, separated by blanks"
            raise BgError([wrong_value(self.place(attribute), what, help)])
        return tuple(self._read(attribute, word) for word in words)

    def _read(self, attribute: str, word: str) -> float:
        value = float(word) if _NUMBER.fullmatch(word) else None
        if value is None or abs(value) > _LARGEST_NUMBER:
            fault = "is not a number" if value is None else "is beyond 1e18"
            what = f"`{attribute}` {fault}: {word[:40]!r}"
            raise BgError([wrong_value(self.place(attribute), what, "write a number, as `0.25`")])
        return value


def read_elements(source: Source) -> Element:
    """Read the root element of an XML text.

    Raises
    ------
    BgError
        BG137 where the text is not well-formed, has a document type with entities, or is nested
        more than a thousand deep.
    """
    return _Reader(source).read()


class _Reader:
    """Builds the elements from the events of expat."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.data = _DECLARATION.sub(lambda found: " " * len(found[0]), source.text).encode()
        self.parser = expat.ParserCreate("utf-8")
        self.root: Element | None = None
        self.open: list[Element] = []

    def read(self) -> Element:
        parser = self.parser
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = lambda tag: self.open.pop()
        parser.CharacterDataHandler = self._characters
        parser.EntityDeclHandler = self._entity
        parser.ExternalEntityRefHandler = self._entity
        try:
            parser.Parse(self.data, True)
        except expat.ExpatError as fault:
            at = self._offset(parser.ErrorByteIndex)
            what = f"this is not well-formed XML: {expat.ErrorString(fault.code)}"
            span = Span(self.source, at, min(at + 1, len(self.source.text)))
            help = "correct the text here, or the tag before it"
            raise BgError([not_importable(what, span, help)]) from None
        assert self.root is not None, "expat reports a text without an element"
        return self.root

    @cached_property
    def _characters_before(self) -> Any:
        """Number of characters before each byte, where they differ."""
        octets = np.frombuffer(self.data, np.uint8)
        return np.concatenate([[0], np.cumsum((octets & 0xC0) != 0x80)])

    def _offset(self, octet: int) -> int:
        octet = min(max(octet, 0), len(self.data))
        if len(self.data) == len(self.source.text):
            return octet
        return int(self._characters_before[octet])

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        start = self._offset(self.parser.CurrentByteIndex)
        end = self.source.text.find(">", start) + 1 or len(self.source.text)
        element = Element(tag, attributes, Span(self.source, start, end))
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)
        if len(self.open) > _DEEPEST:
            what = f"elements are nested more than {_DEEPEST} deep"
            raise BgError([not_importable(what, element.span, "check where they are closed")])

    def _characters(self, text: str) -> None:
        if self.open:
            self.open[-1].text += text

    def _entity(self, *_: object) -> int:
        at = self._offset(self.parser.CurrentByteIndex)
        span = Span(self.source, at, min(at + 8, len(self.source.text)))
        what = "entities are not read: they can name other files, or expand without end"
        raise BgError(
            [not_importable(what, span, "write their text out, and remove the declaration")]
        )
