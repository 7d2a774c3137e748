"""The page of each diagnostic: the docstring of its constructor."""

from __future__ import annotations

import inspect
import pkgutil
import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from types import ModuleType

from bgc.diagnostics import catalogue

_CODE = re.compile(r"BG\d{3}")
_BEFORE_TITLE = re.compile(r"(?:Diagnostics of|BG[\dx]+(?:-BG\d+)?:)\s+")


def find_page(code: str) -> str | None:
    """Find the page of a code, `BG201`, `bg201` or `201`; None when no diagnostic has it."""
    return pages().get(f"BG{code.upper().removeprefix('BG')}")


@cache
def pages() -> Mapping[str, str]:
    """Return all pages by code, in the order of the codes."""
    return dict(sorted(item for _, found in topics() for item in found.items()))


@cache
def topics() -> tuple[tuple[str, Mapping[str, str]], ...]:
    """Return the topics in the order of their first codes: a title, and its pages by code."""
    found = [(_title(topic), dict(sorted(_pages_of(topic)))) for topic in _modules()]
    with_pages = ((title, some) for title, some in found if some)
    return tuple(sorted(with_pages, key=lambda item: min(item[1])))


def near_pages(text: str) -> dict[str, str]:
    """Return the pages that a text may mean: the codes next to it, or titles that hold it."""
    known = pages()
    wanted = text.casefold()
    if not any(char.isdigit() for char in text):
        return {
            code: page
            for code, page in known.items()
            if wanted in page.partition("\n")[0].casefold()
        }
    # the letters that are taken for digits: 5O1 is 501
    digits = wanted.removeprefix("bg").translate(str.maketrans("oil", "011"))
    if not digits.isdecimal():
        return {}
    close = sorted(known, key=lambda code: abs(int(code[2:]) - int(digits)))[:3]
    return {code: known[code] for code in sorted(close)}


def _modules() -> Iterator[ModuleType]:
    for module in pkgutil.iter_modules(catalogue.__path__):
        yield import_module(f"{catalogue.__name__}.{module.name}")


def _pages_of(topic: ModuleType) -> Iterator[tuple[str, str]]:
    for _, constructor in inspect.getmembers(topic, inspect.isfunction):
        page = inspect.getdoc(constructor) or ""
        code = page.partition(":")[0]
        if constructor.__module__ == topic.__name__ and _CODE.fullmatch(code):
            yield code, page


def _title(topic: ModuleType) -> str:
    first = (topic.__doc__ or "").partition("\n")[0].rstrip(".")
    return _BEFORE_TITLE.sub("", first)
