"""Documents from templates: what is escaped, and what a page of a trade holds."""

from pathlib import Path
from xml.etree import ElementTree

import jinja2
import pytest

import bgc.runtime.documents
from bgc.runtime.documents.templates import render_template

NASTY = '<script>alert("&")</script>'
TRADE = {
    "title": NASTY,
    "answer": f"`solver {NASTY};` is best",
    "warnings": [NASTY],
    "picture": "<svg></svg>",
    "configurations": {
        "header": ("", NASTY),
        "names": 1,
        "rows": [
            {"kind": "best", "cells": [{"text": NASTY, "worth": None}, {"text": "1", "worth": "1"}]}
        ],
    },
    "legend": [NASTY],
    "variants": {
        "title": "V",
        "note": NASTY,
        "header": ("a", "b"),
        "names": ("a",),
        "rows": [(NASTY, "1")],
    },
    "errors": {"header": [NASTY], "rows": [(NASTY, [NASTY])]},
    "unfinished": [(NASTY, NASTY, NASTY, NASTY)],
    "unfinished_count": 1,
    "facts": [NASTY],
    "levels": NASTY,
    "made": "today",
}


def test_everything_on_the_page_of_a_trade_is_escaped_but_its_picture():
    text = render_template("trade.html.j2", **TRADE)
    assert NASTY not in text and "<svg></svg>" in text
    assert text.count("&lt;script&gt;") == 18
    assert "<code>solver &lt;script&gt;" in text
    assert '<td class="name">&lt;script' in text and '<td data-value="1">1</td>' in text


def test_parts_of_the_page_that_have_nothing_are_left_out():
    empty = {
        **TRADE,
        "picture": "",
        "unfinished": [],
        "variants": {**TRADE["variants"], "rows": []},
    }
    text = render_template("trade.html.j2", **empty)
    assert "<svg" not in text and "Not measured" not in text and "<h2>V</h2>" not in text
    assert text.count("<table") == text.count("</table>") == 2


def test_text_that_is_no_page_is_not_escaped():
    text = render_template("plain.bg.j2", model="A<B", scene="a", file="a.bg")
    assert "model A<B {" in text


def test_a_value_that_is_not_given_is_an_error():
    with pytest.raises(jinja2.UndefinedError):
        render_template("plain.bg.j2", model="A")


def test_every_template_is_used():
    folder = Path(bgc.runtime.documents.__file__).parent
    sources = "".join(
        path.read_text()
        for path in folder.parent.rglob("*.py")
        if path.parent.name in {"documents", "trade", "reduce", "fmi", "cli", "web"}
    )
    sources += "".join(path.read_text() for path in folder.glob("*.j2"))
    for template in folder.glob("*.j2"):
        kind = template.name.partition(".")[0]
        assert template.name in sources or f'"{kind}": ' in sources


def test_characters_that_xml_cannot_have_are_replaced():
    """A parameter's `///` text may have them; an importer then refuses the model description."""
    text = render_template(
        "osp_model.xml.j2", groups=[{"name": "a\x01\uffff<é🏗", "members": ["\x0b"]}]
    )
    (group,) = ElementTree.fromstring(text)[0]
    assert group.get("name") == "a\ufffd\ufffd<é🏗" and group[0].get("ref") == "\ufffd"
