"""Check the links of a built site: each leads to a file of the site, and to an anchor of it."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

_LOADED = {
    ("script", "src"),
    ("link", "href"),
    ("img", "src"),
    ("iframe", "src"),
    ("source", "src"),
}


class _Reader(HTMLParser):
    """Collects anchors, links, and the files that a page loads."""

    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[tuple[str, str, str]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("id", "name") and value:
                self.anchors.add(value)
            if name in ("href", "src") and value is not None:
                self.links.append((tag, name, value))


def broken_links(site: Path) -> list[str]:
    """Return a line for each link that leads nowhere, and each file that another host serves."""
    pages = {path: _read(path) for path in site.rglob("*.html")}
    problems = []
    for path, page in pages.items():
        if "404" in path.name:  # its links are absolute
            continue
        for tag, name, link in page.links:
            where = f"{path.relative_to(site)}: {link}"
            parts = urlsplit(link)
            if parts.scheme in ("data", "mailto", "blob"):
                continue
            if parts.scheme or parts.netloc:
                if (tag, name) in _LOADED and "canonical" not in link:
                    problems.append(f"{where}: from another host")
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path.resolve()
            target = target / "index.html" if target.is_dir() else target
            if not target.is_file():
                problems.append(f"{where}: no such file")
            elif parts.fragment and target.suffix == ".html":
                anchors = pages[_same(target, pages)].anchors
                if unquote(parts.fragment) not in anchors | {"", "__skip"}:
                    problems.append(f"{where}: no such heading")
    return sorted(set(problems))


def _same(target: Path, pages: dict[Path, _Reader]) -> Path:
    return next(path for path in pages if path.resolve() == target)


def _read(path: Path) -> _Reader:
    reader = _Reader()
    reader.feed(path.read_text("utf-8"))
    return reader


if __name__ == "__main__":
    found = broken_links(Path(sys.argv[1]))
    print("\n".join(found) or "all links lead somewhere")
    sys.exit(1 if found else 0)
