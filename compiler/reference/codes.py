"""Diagnostics as entries of the reference: their pages."""

from __future__ import annotations

from functools import cache

from bgc.diagnostics.catalogue.pages import find_page, pages, topics
from bgc.printing.text_tables import Table
from bgc.reference.entry import Block, Entry, Group, paragraphs


def _entry(code: str) -> Entry:
    page = find_page(code)
    assert page is not None, code
    title, _, body = page.partition("\n")
    name, _, summary = title.partition(": ")
    return Entry("diagnostic", name, summary, paragraphs(body))


def _others(text: str) -> tuple[Entry, ...]:
    """Find `bg301` and `301` too."""
    return (_entry(text),) if find_page(text) is not None else ()


def _title(page: str) -> str:
    return page.partition("\n")[0].partition(": ")[2]


def _by_topic() -> tuple[Block, ...]:
    return tuple(
        Table(title, (), tuple((code, _title(page)) for code, page in found.items()))
        for title, found in topics()
    )


@cache
def _summaries() -> dict[str, str]:
    return {code: _title(page) for code, page in pages().items()}


GROUP = Group(
    "diagnostics",
    "errors and warnings by topic",
    _summaries,
    _entry,
    aliases=("codes", "diagnostic", "errors", "warnings"),
    listing=_by_topic,
    other=_others,
)
"""All diagnostics."""
