"""Render diagnostics as text: the place, the underlined line, and the way out.

::

    error[BG102]: expected `;` after `2 ohm`
     --> rlc.bg:3:18
      |
    3 |   param R = 2 ohm
      |                  ^
      = help: end the statement with `;`
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Sequence

from bgc.diagnostics.diagnostic import Diagnostic, Label, Severity
from bgc.diagnostics.source import Source, Span
from bgc.record_class import dataclass

_WIDTH = 100  # shown columns of a source line
_TAB = 4

_BOLD = "\x1b[1m"
_BLUE = "\x1b[1;34m"
_RESET = "\x1b[0m"
_COLOUR_OF = {
    Severity.ERROR: "\x1b[1;31m",
    Severity.WARNING: "\x1b[1;33m",
    Severity.INFO: "\x1b[1;36m",
}


def render(diagnostics: Iterable[Diagnostic], *, colour: bool) -> str:
    """Render diagnostics, separated by blank lines, with a line end after the last."""
    paint = _Paint(colour)
    return "\n".join(_one(diagnostic, paint) for diagnostic in diagnostics)


def excerpt(diagnostic: Diagnostic) -> str:
    """Render the places of a diagnostic with their lines; empty where it has none."""
    return "\n".join(_excerpts(diagnostic, Severity.ERROR, _Paint(False)))


def escaped(text: str) -> str:
    r"""Write characters that a terminal would obey as escapes: controls, marks of direction.

    Bytes of a file's name that are not UTF-8 become `\xff`.
    """
    if text.isprintable():
        return text
    return "".join(char if char.isprintable() else _escape(ord(char)) for char in text)


def _escape(code: int) -> str:
    if 0xDC80 <= code <= 0xDCFF:  # how Python keeps a byte that is not UTF-8
        code -= 0xDC00
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


@dataclass(frozen=True, slots=True)
class _Paint:
    """Adds colour codes to texts if `colour` is set."""

    colour: bool

    def __call__(self, code: str, text: str) -> str:
        return f"{code}{text}{_RESET}" if self.colour and text else text


def _one(diagnostic: Diagnostic, paint: _Paint) -> str:
    colour = _COLOUR_OF[diagnostic.severity]
    gutter = _gutter(diagnostic)
    head = paint(colour, f"{diagnostic.severity.value}[{diagnostic.code}]")
    lines = [f"{head}{paint(_BOLD, f': {escaped(diagnostic.message)}')}"]
    lines += _excerpts(diagnostic, diagnostic.severity, paint)
    for word, text in (("note", diagnostic.note), ("help", diagnostic.help)):
        if text:
            first, *more = map(escaped, text.expandtabs(_TAB).split("\n"))
            lines.append(f"{' ' * gutter} {paint(_BLUE, '=')} {paint(_BOLD, word)}: {first}")
            lines += [f"{' ' * (gutter + len(word) + 5)}{line}" for line in more]
    return "\n".join(lines) + "\n"


def _gutter(diagnostic: Diagnostic) -> int:
    """Return the columns that the numbers of its lines take."""
    return max((_gutter_width(place.span) for place in _places(diagnostic)), default=1)


def _excerpts(diagnostic: Diagnostic, severity: Severity, paint: _Paint) -> list[str]:
    """Show the lines of all its places, file by file."""
    lines: list[str] = []
    for at, (source, group) in enumerate(_by_source(_places(diagnostic))):
        main = diagnostic.span if at == 0 else None
        lines += _excerpt(source, group, main, _gutter(diagnostic), _COLOUR_OF[severity], paint)
    return lines


def _places(diagnostic: Diagnostic) -> list[Label]:
    """List the place at fault, with the labels at the same place, then the other labels."""
    span = diagnostic.span
    if span is None:
        return list(diagnostic.labels)
    same = [label for label in diagnostic.labels if _is_at(label, span)]
    others = [label for label in diagnostic.labels if not _is_at(label, span)]
    return [Label(span, "; ".join(label.text for label in same)), *others]


def _is_at(label: Label, span: Span) -> bool:
    here = label.span
    return here.source is span.source and (here.start, here.end) == (span.start, span.end)


def _gutter_width(span: Span) -> int:
    return len(str(span.source.position(span.start)[0]))


def _by_source(places: Sequence[Label]) -> list[tuple[Source, list[Label]]]:
    """Group places by file, in order of first occurrence."""
    groups: list[tuple[Source, list[Label]]] = []
    for place in places:
        for source, group in groups:
            if source is place.span.source:
                group.append(place)
                break
        else:
            groups.append((place.span.source, [place]))
    return groups


def _excerpt(
    source: Source,
    places: Sequence[Label],
    main: Span | None,
    gutter: int,
    colour: str,
    paint: _Paint,
) -> list[str]:
    """Show the lines of one file that contain places, and underline each place."""
    line, column = source.position((main or places[0].span).start)
    bar = paint(_BLUE, "|")
    margin = " " * gutter
    lines = [f"{margin}{paint(_BLUE, '-->')} {source.name}:{line}:{column}", f"{margin} {bar}"]
    numbers = sorted({source.position(place.span.start)[0] for place in places})
    for previous, number in zip((None, *numbers), numbers, strict=False):
        if previous is not None and number > previous + 1:
            lines.append(f"{paint(_BLUE, '...')}")
        here = [place for place in places if source.position(place.span.start)[0] == number]
        window = _Window.around(source, number, here)
        number_text = paint(_BLUE, f"{number:>{gutter}}")
        lines.append(f"{number_text} {bar} {window.text}".rstrip())
        # the fault itself first, then the labels from left to right
        for place in sorted(here, key=lambda p: (p.span is not main, p.span.start)):
            mark = "^" if place.span is main else "-"
            start, width = window.columns(place.span)
            underline = f"{mark * width} {escaped(place.text)}".rstrip()
            painted = paint(colour if mark == "^" else _BLUE, underline)
            lines.append(f"{margin} {bar} {' ' * start}{painted}")
    return lines


@dataclass(frozen=True, slots=True)
class _Window:
    """The shown part of a source line: all of it, unless the line is long."""

    line_start: int
    first: int
    last: int
    raw: str
    text: str

    @staticmethod
    def around(source: Source, number: int, places: Sequence[Label]) -> _Window:
        """Choose a part that contains the first place and, if they fit, the others."""
        line_start = source.line_starts[number - 1]
        length = source.line_length(number)
        at = places[0].span.start - line_start
        first, last = 0, length
        if length > _WIDTH:
            first = max(0, min(at - _WIDTH // 3, length - _WIDTH))
            last = min(length, first + _WIDTH)
        raw = source.text[line_start + first : line_start + last]
        before = "..." if first > 0 else ""
        after = "..." if last < length else ""
        return _Window(line_start, first, last, raw, before + _shown(raw) + after)

    def columns(self, span: Span) -> tuple[int, int]:
        """Return column and width of the shown part of a span; the width is at least 1."""
        start = min(max(span.start - self.line_start, self.first), self.last)
        end = min(max(span.end - self.line_start, start), self.last)
        indent = 3 if self.first > 0 else 0
        before = _shown(self.raw[: start - self.first])
        inside = _shown(self.raw[start - self.first : end - self.first])
        return indent + _columns(before), max(1, _columns(inside))


def _shown(text: str) -> str:
    """Make part of a line printable: tabs become blanks, control characters U+FFFD."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        " " * _TAB if char == "\t" else char if char.isprintable() else "\ufffd" for char in text
    )


def _columns(text: str) -> int:
    """Count the terminal columns of a printed text."""
    if text.isascii():
        return len(text)
    return sum(
        0 if unicodedata.combining(char) else 2 if unicodedata.east_asian_width(char) in "WF" else 1
        for char in text
    )
