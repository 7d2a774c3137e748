"""The page of each diagnostic: the docstring of its constructor."""

from __future__ import annotations

import inspect
import pkgutil
from importlib import import_module

from bgc.grammar import catalogue


def find_page(code: str) -> str | None:
    """Find the page of a code, `BG201` or `bg201`; None when no diagnostic has it."""
    return pages().get(code.upper())


def pages() -> dict[str, str]:
    """Return all pages by code, in the order of the codes."""
    found: dict[str, str] = {}
    for module in pkgutil.iter_modules(catalogue.__path__):
        topic = import_module(f"{catalogue.__name__}.{module.name}")
        for _, constructor in inspect.getmembers(topic, inspect.isfunction):
            page = inspect.getdoc(constructor) or ""
            code = page.partition(":")[0]
            if constructor.__module__ == topic.__name__ and code[:2] == "BG" and code[2:].isdigit():
                found[code] = page
    return dict(sorted(found.items()))
