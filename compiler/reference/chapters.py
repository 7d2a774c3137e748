"""Chapters of the manual, listed in `LANGUAGE.md`, as entries of the reference."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from importlib import resources

from bgc.printing.tables import Table
from bgc.reference.entry import Block, Code, Entry, Group, Heading, Text

_LISTED = re.compile(r"^\d+\. \[.+\]\((manual/\S+\.md)\)", re.MULTILINE)
_TOPIC = re.compile(r"^## (.+)$", re.MULTILINE)
_MOST_FOUND = 3  # titles that hold a word
_FENCE = re.compile(r"^```")
_ITEM = re.compile(r"^\s*(?:[-*]|\d+\.) ")
_RULE = re.compile(r"^\|[-:| ]+\|$")
_LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")


@cache
def _chapters() -> dict[str, str]:
    """Return the text of each chapter by its name, in the order of the index.

    Empty where there is no manual.
    """
    folder = resources.files("bgc.grammar")
    index = folder / "LANGUAGE.md"
    if not index.is_file():
        return {}
    files = _LISTED.findall(index.read_text("utf-8"))
    texts = ((folder / file).read_text("utf-8").removeprefix("# ") for file in files)
    return {_name(text.partition("\n")[0]): text for text in texts}


def _name(title: str) -> str:
    """The name by which a chapter is found: `bonds-arrows-and-signs`."""
    return "-".join(re.findall(r"[a-z0-9]+", title.casefold()))


def _summaries() -> dict[str, str]:
    return {name: text.partition("\n")[0] for name, text in _chapters().items()}


def _entry(name: str) -> Entry:
    title, _, text = _chapters()[name].partition("\n")
    return Entry("chapter", name, title, tuple(_blocks(text)))


def _others(text: str) -> tuple[Entry, ...]:
    """Find chapters and topics by their titles, else by a word of them: `signs`.

    A word of more than three titles finds none.
    """
    wanted = _name(text)
    known = [*_chapters(), *_topics()]
    found = [n for n in known if n == wanted] or [n for n in known if wanted in n.split("-")]
    if not wanted or len(found) > _MOST_FOUND:
        return ()
    return tuple(_entry(n) if n in _chapters() else _topic(n) for n in found)


@cache
def _topics() -> dict[str, tuple[str, str, str]]:
    """Return the sections of chapters by name: the chapter, the title and the text of each."""
    found: dict[str, tuple[str, str, str]] = {}
    for chapter, content in _chapters().items():
        pieces = _TOPIC.split(content)
        for title, text in zip(pieces[1::2], pieces[2::2], strict=True):
            found.setdefault(_name(title), (chapter, title, text))
    return {name: topic for name, topic in found.items() if name not in _chapters()}


def _topic(name: str) -> Entry:
    chapter, title, text = _topics()[name]
    return Entry("topic", name, _plain(title), tuple(_blocks(text)), (f"manual {chapter}",))


def _blocks(text: str) -> Iterator[Block]:
    """Read the part of Markdown that the manual uses."""
    lines = iter(text.splitlines())
    paragraph: list[str] = []
    for line in lines:
        if _FENCE.match(line) or line.startswith("|"):
            yield from _paragraph(paragraph)
        if _FENCE.match(line):
            yield Code("\n".join(_until_fence(lines)))
        elif line.startswith("|"):
            yield _table([line, *_while_table(lines, paragraph)])
        elif line.startswith("#"):
            yield from _paragraph(paragraph)
            yield Heading(_plain(line.lstrip("# ")))
        elif not line.strip():
            yield from _paragraph(paragraph)
        elif _ITEM.match(line):
            yield from _paragraph(paragraph)
            paragraph.append(line)
        else:
            paragraph.append(line)
    yield from _paragraph(paragraph)


def _paragraph(lines: list[str]) -> Iterator[Text]:
    if lines:
        yield Text(_plain(" ".join(line.strip() for line in lines)))
        lines.clear()


def _until_fence(lines: Iterator[str]) -> Iterator[str]:
    for line in lines:
        if _FENCE.match(line):
            return
        yield line


def _while_table(lines: Iterator[str], rest: list[str]) -> Iterator[str]:
    """The other lines of a table; the one behind it begins the next paragraph."""
    for line in lines:
        if not line.startswith("|"):
            rest.extend([line] if line.strip() else [])
            return
        yield line


def _table(lines: list[str]) -> Table:
    rows = [
        tuple(_plain(cell.strip()) for cell in re.split(r"(?<!\\)\|", line.strip().strip("|")))
        for line in lines
        if not _RULE.match(line)
    ]
    header, *others = rows
    width = len(header)
    return Table("", header, tuple((*row, *[""] * width)[:width] for row in others))


def _plain(text: str) -> str:
    """Drop links and emphasis; backticks stay."""
    text = _LINK.sub(r"\1", text).replace("\\|", "|")
    return re.sub(r"(?<![\w*])(\*\*|\*)(?=\S)(.+?)(?<=\S)\1(?![\w*])", r"\2", text)


GROUP = Group(
    "manual",
    "chapters of the manual",
    _summaries,
    _entry,
    aliases=("chapters", "language"),
    other=_others,
)
"""The chapters of the manual."""
