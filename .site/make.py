"""Build the site: `python .site/make.py OUT` (needs `pip install ".[site]"`).

The four parts of the manual with the tutorials, the gallery, the pages of library, Python and
diagnostics, and the measurements become one site of static files, which asks no other host for
anything. Each scene of the gallery
is run for its picture; with the extra `zig`, `--live` adds a page with the live model.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import TypeAlias

from answers import topics_page
from check_links import broken_links
from figures import benchmarks, paper
from modules import library_pages
from needs import SITE, stop_if_missing
from notebook import notebook_page
from pages import Links, Page, anchors_of, diagnostic_place, one_page, written
from python_api import python_pages

from bgc.diagnostics.catalogue.pages import pages as all_codes
from bgc.diagnostics.catalogue.pages import topics
from bgc.reference.library_entries import declarations

ROOT = Path(__file__).resolve().parents[1]
SCENES = ROOT / "library" / "scenes"
_INDEX = "grammar/LANGUAGE.md"
_LABEL = re.compile(r"^(What|Why|Example|Way out):", re.MULTILINE)
_HIDDEN = re.compile(r"<!--.*?-->\n?", re.DOTALL)


def main() -> int:
    """Build the site and check its links; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--live", action="store_true", help="live pages in the gallery")
    parser.add_argument("--scenes", nargs="*", help="scenes of the gallery; by default all")
    given = parser.parse_args()
    packages = [("zensical", SITE), ("IPython", SITE)]
    packages += [("ziglang", 'pip install ".[zig]"')] if given.live else []
    stop_if_missing(*packages, programs=("bgc", "dot"))
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        pages = write_pages(work / "docs", given.scenes, live=given.live)
        (work / "zensical.toml").write_text(configuration(pages), "utf-8")
        shutil.copyfile(Path(__file__).with_name("site.css"), work / "docs/site.css")
        command = [sys.executable, "-m", "zensical", "build", "--strict"]
        subprocess.run(command, cwd=work, check=True)
        shutil.rmtree(given.out, ignore_errors=True)
        shutil.copytree(work / "site", given.out)
    problems = broken_links(given.out)
    print("\n".join(problems) or f"{sum(1 for _ in every_page(pages))} pages in {given.out}")
    return 1 if problems else 0


# --- the pages ------------------------------------------------------------------------------

Part: TypeAlias = dict[str, list[Page]]
"""A part of the site: its pages under "", and further pages below a title of their own."""


def every_page(parts: dict[str, Part]) -> Iterator[Page]:
    """Yield the pages of all parts, in their order."""
    return (page for part in parts.values() for pages in part.values() for page in pages)


def write_pages(
    docs: Path, scenes: Sequence[str] | None = None, live: bool = False
) -> dict[str, Part]:
    """Write all pages and the files they show; return the parts of the site by their titles.

    `scenes` are those of the gallery, by default all files of `library/scenes`.
    """
    every_scene = sorted(path.stem for path in SCENES.glob("*.bg"))
    manual = _manual()
    gallery = _gallery(docs, every_scene if scenes is None else scenes, live)
    parts: dict[str, Part] = {
        "Home": {"": _home()},
        "Learn": {"": _started()} | manual["Learn"] | {"Tutorials": _tutorials()},
        "Do": {"": [topics_page(_read(_INDEX))]} | manual["Do"] | {"Scenes": gallery},
        "Reference": manual["Reference"]
        | {"Messages": _diagnostics(), "Library": library_pages(docs), "Python": python_pages()},
        "Evidence": manual["Evidence"]
        | {"Figures": [*benchmarks(docs, ROOT / "tests" / "bench" / "curves.csv"), *paper()]},
        "Developing": {"": _developing()},
    }
    index = one_page("manual/index.md", "The manual", _INDEX, _read(_INDEX))
    every = [*every_page(parts), *index]
    places = {page.source: page.path for page in reversed(every) if page.source}

    def copy(file: str) -> str:
        place = f"files/{file.lstrip('.')}"  # Zensical leaves out what begins with a dot
        (docs / place).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / file, docs / place)
        return place

    links = Links(places | dict(anchors_of(every)), copy)
    for page in every:
        path = docs / page.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(written(page, links), "utf-8")
    return parts


def _read(source: str) -> str:
    return _HIDDEN.sub("", (ROOT / source).read_text("utf-8")).lstrip()


def _home() -> list[Page]:
    return one_page("index.md", "bgc", ".site/home.md", _read(".site/home.md"))


def _started() -> list[Page]:
    return one_page("started.md", "Install and first run", "README.md", _read("README.md"))


def _tutorials() -> list[Page]:
    index = _read("library/examples/README.md")
    names = re.findall(r"\]\((\w+)\.md\)", index)
    pages = one_page("tutorials/index.md", "Overview", "library/examples/README.md", index)
    for name in names:
        source = f"library/examples/{name}.md"
        text = _read(source)
        title = text.partition("\n")[0].removeprefix("# ")
        pages += one_page(f"tutorials/{name}.md", title, source, text)
    source = "library/examples/series_circuit.ipynb"
    return [*pages, notebook_page("tutorials/notebook.md", source, ROOT / source)]


def _manual() -> dict[str, Part]:
    """Return the chapters of the manual by its parts and their headings."""
    _, *pieces = re.split(r"^## (.+)$", _read(_INDEX), flags=re.MULTILINE)
    found: dict[str, Part] = {}
    for title, text in zip(pieces[::2], pieces[1::2], strict=True):
        first, *groups = re.split(r"^### (.+)$", text, flags=re.MULTILINE)
        found[title] = {"Chapters": _chapters(first)} if _chapters(first) else {}
        for group, listed in zip(groups[::2], groups[1::2], strict=True):
            found[title][group] = _chapters(listed)
    return found


def _chapters(listed: str) -> list[Page]:
    found = re.findall(r"^\d+\. \[(.+)\]\((manual/\S+\.md)\)", listed, re.MULTILINE)
    return [
        page
        for title, file in found
        for page in one_page(file, title, f"grammar/{file}", _read(f"grammar/{file}"))
    ]


def _diagnostics() -> list[Page]:
    """List the codes by topic, and show their pages: fifty numbers on a page of the site."""
    lines = ["# Diagnostics", "", "`bgc doc BG301` prints the page of a code in a terminal.", ""]
    sites: dict[str, Page] = {}
    for title, found in topics():
        lines += [f"## {title[:1].upper()}{title[1:]}", ""]
        for code, page in found.items():
            name = page.partition("\n")[0].partition(": ")[2]
            lines.append(f"- [{code}]({diagnostic_place(code)}): {name}")
        lines.append("")
    for code, page in all_codes().items():
        path = diagnostic_place(code).partition("#")[0]
        site = sites.setdefault(
            path, Page(path, f"From {code}", "", [f"# Diagnostics from {code}"])
        )
        name, _, rest = page.partition("\n")
        site.lines += ["", f"## {name} {{#{code.lower()}}}", ""]
        site.lines.append(_LABEL.sub(r"\n**\1:**", rest.strip()))
    return [Page("diagnostics.md", "Diagnostics", "", lines), *sites.values()]


def _developing() -> list[Page]:
    return [
        page
        for path, title, source in (
            ("developing/compiler.md", "The compiler", "compiler/README.md"),
            ("developing/tests.md", "The tests", "tests/README.md"),
            ("developing/changes.md", "Changes", ".packaging/CHANGELOG.md"),
        )
        for page in one_page(path, title, source, _read(source))
    ]


# --- the gallery ----------------------------------------------------------------------------


def _gallery(docs: Path, scenes: Sequence[str], live: bool) -> list[Page]:
    """Show scenes of `library/scenes` with the curves that they observe."""
    lines = ["# Gallery", "", "Scenes of the library, each run as it stands.", ""]
    (docs / "gallery").mkdir(parents=True, exist_ok=True)
    for name in scenes:
        path = SCENES / f"{name}.bg"
        found = [d for d in declarations() if d.module == f"scenes.{name}" and d.kind == "scene"]
        lines += [f"## {name.replace('_', ' ').capitalize()}", "", found[0].doc, ""]
        lines += [f"![Curves of {name}](gallery/{name}.png)", ""]
        _bgc("run", path, "--quiet", "--plot", docs / "gallery" / f"{name}.png")
        if live:
            _bgc("build", path, "--target", "html", "-o", docs / "gallery" / name)
            (page,) = (docs / "gallery" / name).iterdir()
            lines += [f"[Open the live model](gallery/{name}/{page.name})", ""]
        lines += ["```sh", f"bgc view library/scenes/{name}.bg", "```", ""]
    return [Page("gallery.md", "Gallery", "", lines)]


def _bgc(*arguments: object) -> None:
    subprocess.run(["bgc", *map(str, arguments)], check=True)


# --- the configuration ----------------------------------------------------------------------


def configuration(parts: dict[str, Part]) -> str:
    """Return the settings of Zensical: the navigation, no fonts and no icons of other hosts."""
    parts = {title: part for title, part in parts.items() if title != "Home"}
    sections = (_section(title, _inside(part)) for title, part in parts.items())
    entries = ",\n  ".join(['{ "Home" = "index.md" }', *sections])
    template = Path(__file__).with_name("zensical.toml").read_text("utf-8")
    return template.replace("nav = []", f"nav = [\n  {entries}\n]")


def _inside(part: Part) -> Iterator[str]:
    for title, pages in part.items():
        if title:
            yield _section(title, _listed(pages))
        else:
            yield from _listed(pages)


def _section(title: str, entries: Iterable[str]) -> str:
    return f'{{ "{title}" = [{", ".join(entries)}] }}'


def _listed(pages: list[Page]) -> Iterator[str]:
    """List pages; those of modules with a folder, `crane.beam`, stand below the folder's name."""
    for folder, some in groupby(pages, _folder):
        titles = {page.path: page.title.removeprefix(f"{folder}.") for page in some}
        items = [f'{{ "{title}" = "{path}" }}' for path, title in titles.items()]
        yield _section(folder, items) if folder else ", ".join(items)


def _folder(page: Page) -> str:
    is_module = re.fullmatch(r"\w+(\.\w+)+", page.title)
    return page.title.rpartition(".")[0] if is_module else ""


if __name__ == "__main__":
    sys.exit(main())
