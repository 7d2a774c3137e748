"""The example on each page of BG3xx gives that very diagnostic."""

from __future__ import annotations

import inspect
import re

import pytest

from bgc.diagnostics.catalogue import shapes, values
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.elaborate import elaborate
from bgc.resolution.resolve import load_text

PAGES = {
    page[:5]: page
    for topic in (values, shapes)
    for _, constructor in inspect.getmembers(topic, inspect.isfunction)
    if (page := inspect.getdoc(constructor) or "").startswith("BG")
}
EXAMPLE = re.compile(r"^Example: `(.+?)`$", re.MULTILINE | re.DOTALL)
FUNCTION = re.compile(r"function [^;]*;")


@pytest.mark.parametrize("code", [code for code, page in PAGES.items() if EXAMPLE.search(page)])
def test_example_gives_its_code(code: str) -> None:
    match = EXAMPLE.search(PAGES[code])
    assert match is not None
    functions = "".join(FUNCTION.findall(match[1]))
    text = f"{functions} model Example {{ {FUNCTION.sub('', match[1])} }}"
    with pytest.raises(BgError) as caught:
        elaborate(load_text(text, "example.bg"))
    assert code in {diagnostic.code for diagnostic in caught.value.diagnostics}


def test_every_page_has_its_paragraphs() -> None:
    for code, page in PAGES.items():
        paragraphs = page.split("\n\n")
        starts = [paragraph.partition(":")[0] for paragraph in paragraphs]
        assert starts == [code, "What", "Why", "Example", "Way out"]
