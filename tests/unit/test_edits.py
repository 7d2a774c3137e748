"""The edits that diagnostics offer: each removes its diagnostic (see also test_wrong_models)."""

import pytest

from bgc.diagnostics.catalogue.names import import_place
from bgc.diagnostics.source import Source
from bgc.grammar.parse import parse

MISTAKES = {
    "BG102": ("model A { param k = 1 }", "model A { param k = 1; }"),
    "BG103": ("model A { c : C(1; }", "model A { c : C(1); }"),
    "BG104": ("model A { } }", "model A { } "),
    "BG108": ("model A { let a = 1 && 2; }", "model A { let a = 1 and 2; }"),
    "BG109": ("model A { state x = 0; x' = 1; }", "model A { state x = 0; der(x) = 1; }"),
    "BG115": ("model A { if 1 = 2 { } }", "model A { if 1 == 2 { } }"),
    "BG117": ("model A { parm k = 1; }", "model A { param k = 1; }"),
}


@pytest.mark.parametrize("code", MISTAKES)
def test_an_edit_corrects_a_syntax_error(code):
    wrong, right = MISTAKES[code]
    _, (diagnostic, *_) = parse(Source("a.bg", wrong))
    assert diagnostic.code == code
    edit = diagnostic.edits[0]
    assert wrong[: edit.span.start] + edit.text + wrong[edit.span.end :] == right
    assert not parse(Source("a.bg", right))[1]


@pytest.mark.parametrize(
    ("text", "at"),
    [
        ("model A { }", 0),
        ("import a.b;\nmodel A { }", 0),
        ("// the licence\n\nimport a.b;\n", 16),
        ("// the licence\n\n/// doc\nmodel A { }", 16),
    ],
)
def test_a_further_import_stands_before_the_first_and_below_the_licence(text, at):
    assert import_place(Source("a.bg", text)).start == at
