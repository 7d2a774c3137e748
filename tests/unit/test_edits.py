"""The edits that diagnostics offer: each removes its diagnostic (see also test_wrong_models)."""

import pytest

import bgc
from bgc.diagnostics.catalogue.names import import_place
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source
from bgc.grammar.parse import parse

MISTAKES = {
    "BG102": ("model A { param k = 1 }", "model A { param k = 1; }"),
    "BG103": ("model A { c : C(1; }", "model A { c : C(1); }"),
    "BG104": ("model A { } }", "model A { } "),
    "BG108": ("model A { let a = 1 && 2; }", "model A { let a = 1 and 2; }"),
    "BG109": ("model A { state x = 0; x' = 1; }", "model A { state x = 0; der(x) = 1; }"),
    "BG115": ("model A { if 1 = 2 { } }", "model A { if 1 == 2 { } }"),
    "BG127": ("model A { let a = 9 N*sin(1); }", "model A { let a = 9 N * sin(1); }"),
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


PARTS = "hub : J1; mass : I(1 kg); spring : C(1); part : Part;"
PART = "model Part { port a in; port b out; hub : J1; a -> hub -> b; }"


@pytest.mark.parametrize(
    ("bond", "right"),
    [
        ("spring -> hub", "hub -> spring"),
        ("hub->part.b", "part.b->hub"),
        ("part.a -> hub", "hub -> part.a"),
        ("spring -> mass", None),  # one of both ends is wrong either way
        ("spring -> hub -> mass", None),  # the second bond would change too
        ("spring -> hub, mass", None),
    ],
)
def test_an_arrow_is_reversed_where_that_is_right(bond, right, tmp_path):
    path = tmp_path / "a.bg"
    path.write_text(f"{PART} model A {{ {PARTS} {bond}; }} scene s of A {{ run 1 s; }}")
    with pytest.raises(BgError) as caught:
        bgc.compile(path)
    found = [d for d in caught.value.diagnostics if d.code in ("BG404", "BG405")]
    edits = [edit for diagnostic in found for edit in diagnostic.edits]
    assert found and [(edit.span.text, edit.text) for edit in edits] == (
        [(bond, right)] if right else []
    )


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
