"""The page of topics: what users look for, under a heading each, which the search finds."""

from __future__ import annotations

import re
from pathlib import PurePosixPath

from modules import holds_parts
from pages import Page

from bgc.reference import chapters
from bgc.reference.entry import Entry
from bgc.reference.index import GROUPS, find
from bgc.reference.library_entries import declarations
from bgc.reference.topics import topics
from bgc.resolution.library import library_modules

SOURCE = "grammar/manual/topics.md"


def topics_page(index: str) -> Page:
    """Return the page; `index` is the text of `LANGUAGE.md`, which lists the files of chapters."""
    listed = re.findall(r"^\d+\. \[(.+)\]\(manual/(\S+\.md)\)", index, re.MULTILINE)
    lines = ["# Where to find what", ""]
    lines += [
        "What engineers look for under other names, and what to do where bgc has no such thing."
    ]
    for topic in topics():
        see = ", ".join(_linked(name, dict(listed)) for name in topic.see_also)
        title = ", ".join(topic.names)
        lines += ["", f"## {title[:1].upper()}{title[1:]}", "", topic.text, "", f"See {see}."]
    return Page("topics.md", "Where to find what", SOURCE, lines)


def _linked(name: str, files: dict[str, str]) -> str:
    """Link a module, a part or a chapter; other names are those of `bgc doc`."""
    home = PurePosixPath("../../library")
    if name in library_modules():
        return f"[{name}]({home / name.replace('.', '/')}.bg)"
    for declared in declarations():
        if declared.name == name and holds_parts(declared.module):
            return f"[{name}]({home / declared.module.replace('.', '/')}.bg#{name})"
    found = () if find(name, GROUPS) else find(name, [chapters.GROUP])
    if found:
        title = _chapter_of(found[0]).summary
        return f"[{title}]({files[title]})"
    return f"`bgc doc {name}`"


def _chapter_of(entry: Entry) -> Entry:
    """The chapter of a section."""
    name = entry.see_also[0].removeprefix("manual ") if entry.kind == "section" else entry.name
    return chapters.GROUP.entry(name)
