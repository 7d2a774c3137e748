"""Topics: words of other tools, each with its place here or with a way to do without.

The table is a page of the manual, `grammar/manual/topics.md`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from importlib import resources

from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.reference.entry import Entry, Group, Text, first_sentence, rows_of

_ROW = re.compile(r"^\| (.+?) \| (.+) \| (.+?) \|$", re.MULTILINE)
_HEADING = "looked for"


@dataclass(frozen=True, slots=True)
class Topic:
    """A row of the table: names of a thing, where it is, and names of the reference to see."""

    names: tuple[str, ...]
    text: str
    see_also: tuple[str, ...]


@cache
def topics() -> tuple[Topic, ...]:
    """Return all rows in their order; none where there is no manual."""
    file = resources.files("bgc.grammar") / "manual" / "topics.md"
    rows = _ROW.findall(file.read_text("utf-8")) if file.is_file() else []
    return tuple(
        Topic(tuple(names.split(", ")), text, tuple(re.findall(r"`(.+?)`", see)))
        for names, text, see in rows
        if names != _HEADING
    )


def _named() -> Iterator[tuple[str, Topic]]:
    return ((name, topic) for topic in topics() for name in topic.names)


def _entry(name: str) -> Entry:
    topic = dict(_named())[name]
    others = [other for other in topic.names if other != name]
    body = (Text(topic.text), *([Text(f"Also: {', '.join(others)}.")] if others else ()))
    return Entry("topic", name, first_sentence(topic.text), body, topic.see_also)


def _texts() -> dict[str, tuple[str, str]]:
    """The text of each row, by the first of its names."""
    return {
        topic.names[0]: (first_sentence(topic.text), f"{', '.join(topic.names)}: {topic.text}")
        for topic in topics()
    }


def _listing() -> tuple[Table]:
    return (rows_of({topic.names[0]: first_sentence(topic.text) for topic in topics()}),)


GROUP = Group(
    "topics",
    "what users look for: where it is, or what to do instead",
    lambda: {name: first_sentence(topic.text) for name, topic in _named()},
    _entry,
    aliases=("topic",),
    listing=_listing,
    texts=_texts,
)
"""All topics."""
