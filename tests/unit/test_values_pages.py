"""The example on each page of BG3xx gives that very diagnostic."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from bgc.diagnostics import catalogue
from bgc.diagnostics.catalogue.pages import read_topic
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.elaborate import elaborate
from bgc.resolution.resolve import load_text

FOLDER = Path(catalogue.__file__).parent
PAGES = {
    code: page
    for topic in ("values.md", "shapes.md")
    for code, page in read_topic(FOLDER / topic)[1].items()
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
