"""Plain YAML, as BondGraphTools writes it: mappings and lists by indentation, and scalars.

Tags, anchors, aliases, flow collections and block scalars are refused.
"""

from __future__ import annotations

import re

from bgc.diagnostics.catalogue.imported import not_importable
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source, Span
from bgc.record_class import dataclass

_KEY = re.compile(r"([^\s:#'\"\[\]{}&*!|>%@`,?][^:#]*?|'[^']*'|\"[^\"\\]*\")\s*:(?=\s|$)")
_REFUSED = re.compile(r"[&*!|>%@`{\[]")
_DEEPEST = 100


@dataclass(frozen=True, slots=True)
class Scalar:
    """A text with its place."""

    text: str
    span: Span


Value = Scalar | list["Value"] | dict[str, "Value"] | None


@dataclass(slots=True)
class _Line:
    indent: int
    text: str
    start: int


def read_yaml(source: Source) -> Value:
    """Read a text; BG137 where it is not plain YAML."""
    lines = []
    for number, start in enumerate(source.line_starts, 1):
        text = source.line(number)
        bare = text.strip()
        if not bare or bare.startswith("#") or bare in ("---", "..."):
            continue
        indent = len(text) - len(text.lstrip(" "))
        lines.append(_Line(indent, bare, start + indent))
    reader = _Reader(source, lines)
    value = reader.block(0) if lines else None
    if reader.at < len(lines):
        raise reader.fault("this line is indented otherwise than those before it")
    return value


class _Reader:
    """Reads blocks of lines; `at` is the next line."""

    def __init__(self, source: Source, lines: list[_Line]) -> None:
        self.source, self.lines, self.at = source, lines, 0

    def fault(self, what: str) -> BgError:
        line = self.lines[min(self.at, len(self.lines) - 1)]
        span = Span(self.source, line.start, line.start + len(line.text))
        help = "write mappings `key: value` and lists `- value`, as BondGraphTools saves them"
        return BgError([not_importable(what, span, help)])

    def block(self, depth: int) -> Value:
        """Read the mapping, list or scalar that begins at the next line."""
        if depth > _DEEPEST:
            raise self.fault("the text is nested too deeply")
        line = self.lines[self.at]
        if line.text == "-" or line.text.startswith("- "):
            return self._list(line.indent, depth)
        if _KEY.match(line.text):
            return self._mapping(line.indent, depth)
        self.at += 1
        return self._scalar(line.text, line.start, line.indent - 1)

    def _list(self, indent: int, depth: int) -> list[Value]:
        found: list[Value] = []
        while self.at < len(self.lines):
            line = self.lines[self.at]
            if line.indent != indent or not (line.text == "-" or line.text.startswith("- ")):
                break
            text = line.text[1:].strip()
            start = line.start + len(line.text) - len(text)
            self.at += 1
            found.append(self._value(text, start, indent, depth))
        return found

    def _mapping(self, indent: int, depth: int) -> dict[str, Value]:
        found: dict[str, Value] = {}
        while self.at < len(self.lines) and self.lines[self.at].indent == indent:
            line = self.lines[self.at]
            key = _KEY.match(line.text)
            if key is None:
                break
            name = key[1].strip("'\"")
            if name in found:
                raise self.fault(f"`{name[:40]}` occurs twice")
            text = line.text[key.end() :].strip()
            start = line.start + len(line.text) - len(text)
            self.at += 1
            # A list may stand as far left as its key.
            below = self.at < len(self.lines) and self.lines[self.at]
            if not text and below and below.indent == indent and below.text.startswith("-"):
                found[name] = self._list(indent, depth + 1)
            else:
                found[name] = self._value(text, start, indent, depth)
        return found

    def _value(self, text: str, start: int, indent: int, depth: int) -> Value:
        """Read what stands behind a dash or a colon, or below it."""
        if text in ("[]", "{}", "null", "~"):
            return [] if text == "[]" else {} if text == "{}" else None
        if text:
            return self._scalar(text, start, indent)
        if self.at < len(self.lines) and self.lines[self.at].indent > indent:
            return self.block(depth + 1)
        return None

    def _scalar(self, text: str, start: int, indent: int) -> Scalar:
        """Read a scalar, which goes on in lines that are indented further."""
        end = start + len(text)
        while self.at < len(self.lines) and self.lines[self.at].indent > indent:
            line = self.lines[self.at]
            text = f"{text} {line.text}"
            end = line.start + len(line.text)
            self.at += 1
        quoted = len(text) > 1 and text[0] == text[-1] and text[0] in "'\""
        if not quoted and _REFUSED.match(text):
            self.at -= 1
            raise self.fault(f"`{text[0]}` begins a form of YAML that is not read")
        if quoted:
            text = text[1:-1].replace("''", "'") if text[0] == "'" else text[1:-1]
        else:
            text = re.split(r"\s#", text)[0].strip()
        return Scalar(text, Span(self.source, start, end))
