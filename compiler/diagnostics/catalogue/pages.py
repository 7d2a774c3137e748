"""The page of each diagnostic: a section of the Markdown file of its topic, beside this module."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path


def find_page(code: str) -> str | None:
    """Find the page of a code, `BG201`, `bg201` or `201`; None when no diagnostic has it."""
    return pages().get(f"BG{code.upper().removeprefix('BG')}")


@cache
def pages() -> Mapping[str, str]:
    """Return all pages by code, in the order of the codes; the first line is `CODE: title`."""
    return dict(sorted(item for _, found in topics() for item in found.items()))


@cache
def topics() -> tuple[tuple[str, Mapping[str, str]], ...]:
    """Return the topics in the order of their first codes: a title, and its pages by code."""
    found = [read_topic(path) for path in Path(__file__).parent.glob("*.md")]
    return tuple(sorted(found, key=lambda topic: min(topic[1])))


def near_codes(text: str) -> tuple[str, ...]:
    """Return the codes next to a text with digits: those next to BG501 for `BG5O1`."""
    # the letters that are taken for digits: 5O1 is 501
    digits = text.casefold().removeprefix("bg").translate(str.maketrans("oil", "011"))
    if not digits.isdecimal() or not any(map(str.isdigit, text)):
        return ()
    return tuple(sorted(sorted(pages(), key=lambda code: abs(int(code[2:]) - int(digits)))[:3]))


def read_topic(path: Path) -> tuple[str, Mapping[str, str]]:
    """Read the file of a topic: its title, and the pages by code in their order."""
    title, *sections = re.split(r"^## ", path.read_text("utf-8"), flags=re.MULTILINE)
    by_code = {page.partition(":")[0]: page.strip() for page in sections}
    return title.removeprefix("# ").strip(), dict(sorted(by_code.items()))
