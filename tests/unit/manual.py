"""The manual as the tests read it: the index `LANGUAGE.md` and the chapters that it lists."""

import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
INDEX = ROOT / "grammar" / "LANGUAGE.md"
FOLDER = ROOT / "grammar" / "manual"
_LISTED = re.compile(r"^\d+\. \[.+\]\((manual/\S+\.md)\)", re.MULTILINE)


@cache
def chapter_files() -> tuple[Path, ...]:
    """The files of the chapters, in the order of the index."""
    return tuple(INDEX.parent / name for name in _LISTED.findall(INDEX.read_text("utf-8")))


def chapter_named(name: str) -> str:
    """The text of one chapter, by the name of its file: `do/many-runs`."""
    return (FOLDER / f"{name}.md").read_text("utf-8")


@cache
def whole_manual() -> str:
    """All chapters as one text."""
    return "\n".join(path.read_text("utf-8") for path in chapter_files())
