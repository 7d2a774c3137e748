"""Chapters of the manual, listed in `LANGUAGE.md`, as entries of the reference."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from importlib import resources

from bgc.printing.text_tables import Table
from bgc.reference.entry import Block, Code, Entry, Group, Heading, Text

_LISTED = re.compile(r"^\d+\. \[.+\]\((manual/\S+\.md)\)", re.MULTILINE)
_SECTION = re.compile(r"^## (.+)$", re.MULTILINE)
_MOST_FOUND = 3  # titles that hold a word
_BLOCK = re.compile(
    r"""
    ^```[^\n]*\n (?P<code>.*?) (?:\n```$|\Z)
    | ^(?P<table>(?:\|[^\n]*(?:\n|\Z))+)
    | ^\#+\ (?P<heading>[^\n]+)
    # a paragraph or an item of a list, which ends before a block of another kind
    | ^(?P<text>[^\n]*\S[^\n]*(?:\n(?!```|\||\#|\s*(?:[-*]|\d+\.)\ |\s*$)[^\n]+)*)
    """,
    re.MULTILINE | re.DOTALL | re.VERBOSE,
)
_RULE = re.compile(r"^\|[-:| ]+\|$")
_LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")


@cache
def _chapters() -> dict[str, tuple[str, str]]:
    """Return the title and text of each chapter by its name, in the order of the index.

    Empty where there is no manual.
    """
    folder = resources.files("bgc.grammar")
    index = folder / "LANGUAGE.md"
    files = _LISTED.findall(index.read_text("utf-8")) if index.is_file() else ()
    texts = ((folder / file).read_text("utf-8").removeprefix("# ") for file in files)
    split = (text.partition("\n") for text in texts)
    return {_name(title): (title, text) for title, _, text in split}


def _name(title: str) -> str:
    """The name by which a chapter is found: `bonds-arrows-and-signs`."""
    return "-".join(re.findall(r"[a-z0-9]+", title.casefold()))


def _summaries() -> dict[str, str]:
    return {name: title for name, (title, _) in _chapters().items()}


def _entry(name: str) -> Entry:
    title, text = _chapters()[name]
    return Entry("chapter", name, title, tuple(_blocks(text)))


def _others(text: str) -> tuple[Entry, ...]:
    """Find chapters and sections by their titles, else by a word of them: `signs`.

    A word of more than three titles finds none.
    """
    wanted = _name(text)
    known = [*_chapters(), *_sections()]
    found = [n for n in known if n == wanted] or [n for n in known if wanted in n.split("-")]
    if not wanted or len(found) > _MOST_FOUND:
        return ()
    return tuple(_entry(n) if n in _chapters() else _section(n) for n in found)


@cache
def _sections() -> dict[str, tuple[str, str, str]]:
    """Return the sections of chapters by name: the chapter, the title and the text of each."""
    found: dict[str, tuple[str, str, str]] = {}
    for chapter, (_, content) in _chapters().items():
        pieces = _SECTION.split(content)
        for title, text in zip(pieces[1::2], pieces[2::2], strict=True):
            found.setdefault(_name(title), (chapter, title, text))
    return {name: section for name, section in found.items() if name not in _chapters()}


def _section(name: str) -> Entry:
    chapter, title, text = _sections()[name]
    return Entry("section", name, _plain(title), tuple(_blocks(text)), (f"manual {chapter}",))


def _blocks(text: str) -> Iterator[Block]:
    """Read the part of Markdown that the manual uses."""
    for found in _BLOCK.finditer(text):
        match found.lastgroup:
            case "code":
                yield Code(found["code"])
            case "table":
                yield _table(found["table"].splitlines())
            case "heading":
                yield Heading(_plain(found["heading"]))
            case _:
                yield Text(_plain(" ".join(found["text"].split())))


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


def _texts() -> dict[str, tuple[str, str]]:
    """The title and the text of each section, and of each chapter up to its first section."""
    sections = {name: (_plain(title), text) for name, (_, title, text) in _sections().items()}
    return sections | {
        name: (title, _SECTION.split(text)[0]) for name, (title, text) in _chapters().items()
    }


GROUP = Group(
    "manual",
    "chapters of the manual",
    _summaries,
    _entry,
    aliases=("chapters", "language"),
    other=_others,
    texts=_texts,
)
"""The chapters of the manual."""
