"""Pages of the site, made of the Markdown files of the repository."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import PurePosixPath

_FENCE = re.compile(r"^(\s*)```(.*)$")
_HEADING = re.compile(r"^(#{1,6}) (.+?)\s*$")
_CODE_OR_LINK = re.compile(r"`+[^`]+`+|\]\(([^)\s]+)\)")
_NAMED = re.compile(r"^(\w+) (\S+\.\w+)")  # the language and the file of a block


@dataclass(slots=True)
class Page:
    """A page of the site: its path, title, the file that it comes from, and the lines of its text.

    A page that comes from no file has links for the site already.
    """

    path: str
    title: str
    source: str
    lines: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Links:
    """The places of the site by those of the repository.

    `pages` has the page of each Markdown file, and of each heading of it as `file.md#anchor`.
    `file` is called with the path of any other file that a page links to, and returns its path in
    the site.
    """

    pages: dict[str, str]
    file: Callable[[str], str]


def diagnostic_place(code: str) -> str:
    """Return the place of a diagnostic in the site: fifty numbers are a page."""
    return f"diagnostics/bg{int(code[2:]) // 50 * 50:03}.md#{code.lower()}"


def one_page(path: str, title: str, source: str, text: str) -> list[Page]:
    """Return a file as one page."""
    return [Page(path, title, source, text.splitlines())]


def anchors_of(pages: list[Page]) -> Iterator[tuple[str, str]]:
    """Return `file.md#anchor` and the place in the site of each heading."""
    for page in pages:
        anchors = _Anchors()
        for line, is_code in _with_code(page.lines):
            if is_code or not (heading := _HEADING.match(line)):
                continue
            title, _, own = heading[2].partition(" {#")
            anchor = own.rstrip("}") or anchors.next(title)
            yield f"{page.source}#{anchor}", f"{page.path}#{anchor}"


def written(page: Page, links: Links) -> str:
    """Return the text of a page with the links and blocks of the site."""
    lines = []
    inside = False
    anchors = _Anchors()
    for line, is_code in _with_code(page.lines):
        fence = _FENCE.match(line)
        if fence:
            inside = not inside
            line = fence[1] + "```" + (_information(fence[2]) if inside else "")
        elif not is_code:
            line = _CODE_OR_LINK.sub(lambda found: _with_target(found, page, links), line)
            heading = _HEADING.match(line)
            if heading and "{#" not in line:
                line = f"{line} {{#{anchors.next(heading[2])}}}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def _with_code(lines: list[str]) -> Iterator[tuple[str, bool]]:
    """Yield each line, and whether it belongs to a block of code."""
    inside = False
    for line in lines:
        is_fence = _FENCE.match(line) is not None
        yield line, inside or is_fence
        inside ^= is_fence


def _information(text: str) -> str:
    """Translate what stands after the fence of a block: the language and the file's name."""
    language = text.strip().partition(" ")[0]
    named = _NAMED.match(text.strip())
    return f'{language} title="{named[2]}"' if named else language


def _with_target(found: re.Match[str], page: Page, links: Links) -> str:
    return f"]({_target(found[1], page, links)})" if found[1] else found[0]


def _target(link: str, page: Page, links: Links) -> str:
    if not page.source or re.match(r"[a-z]+:", link):
        return link
    name, _, anchor = link.partition("#")
    beside = PurePosixPath(page.source).parent
    place = os.path.normpath(beside / name) if name else page.source
    found = links.pages.get(f"{place}#{anchor}" if anchor else place)
    if found is None:
        if anchor or place.endswith(".md"):
            raise LookupError(f"{page.source}: nothing in the site is {link}")
        found = links.file(place)
    target, _, anchor = found.partition("#")
    relative = os.path.relpath(target, PurePosixPath(page.path).parent)
    return f"{relative}#{anchor}" if anchor else relative


class _Anchors:
    """The anchors that GitHub gives to the headings of a file."""

    def __init__(self) -> None:
        self._seen: dict[str, int] = {}

    def next(self, title: str) -> str:
        anchor = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        count = self._seen.get(anchor, 0)
        self._seen[anchor] = count + 1
        return f"{anchor}-{count}" if count else anchor
