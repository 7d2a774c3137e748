"""Diagnostics as text: exactly what the user sees."""

from __future__ import annotations

import re
from textwrap import dedent

import pytest

from bgc.diagnostics.catalogue import with_article
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Label, Severity
from bgc.diagnostics.render import render
from bgc.diagnostics.source import Source, Span

RLC = Source("rlc.bg", "model RLC {\n  param R = 2 ohm\n  coil : I(L);\n}\n")


def at(source: Source, text: str) -> Span:
    """The place of a text in a source."""
    start = source.text.index(text)
    return Span(source, start, start + len(text))


def diagnostic(
    span: Span | None, *labels: Label, note: str = "", help: str = "", severity: str = "error"
) -> Diagnostic:
    return Diagnostic("BG201", Severity(severity), "what is wrong", span, note, labels, help)


def plain(one: Diagnostic) -> str:
    return render([one], colour=False)


def test_place_label_note_and_help() -> None:
    label = Label(at(RLC, "R ="), "declared here")
    text = plain(diagnostic(at(RLC, "I(L)"), label, note="why\nand why", help="the way out"))
    assert text == dedent("""\
        error[BG201]: what is wrong
         --> rlc.bg:3:10
          |
        2 |   param R = 2 ohm
          |         --- declared here
        3 |   coil : I(L);
          |          ^^^^
          = note: why
                  and why
          = help: the way out
        """)


def test_without_a_place() -> None:
    text = plain(diagnostic(None, help="install one", severity="warning"))
    assert text == "warning[BG201]: what is wrong\n  = help: install one\n"


def test_several_are_parted_by_a_blank_line() -> None:
    text = render([diagnostic(None), diagnostic(None)], colour=False)
    assert text == "error[BG201]: what is wrong\n\nerror[BG201]: what is wrong\n"
    assert render([], colour=False) == ""


def test_lines_left_out_are_marked() -> None:
    source = Source("a.bg", "first\n" * 12 + "last")
    text = plain(diagnostic(at(source, "last"), Label(Span(source, 0, 5), "see")))
    assert text.splitlines()[2:] == [
        "   |",
        " 1 | first",
        "   | ----- see",
        "...",
        "13 | last",
        "   | ^^^^",
    ]


def test_label_in_another_file() -> None:
    other = Source("lib.bg", "model A { }")
    text = plain(diagnostic(at(RLC, "coil"), Label(at(other, "A"), "its model")))
    assert text == dedent("""\
        error[BG201]: what is wrong
         --> rlc.bg:3:3
          |
        3 |   coil : I(L);
          |   ^^^^
         --> lib.bg:1:7
          |
        1 | model A { }
          |       - its model
        """)


def test_span_over_several_lines_is_underlined_on_the_first() -> None:
    text = plain(diagnostic(Span(RLC, 10, len(RLC.text) - 1)))
    assert text.splitlines()[3:] == ["1 | model RLC {", "  |           ^"]


@pytest.mark.parametrize(
    ("line", "found", "shown", "underline"),
    [
        ("\tcoil : I;", "coil", "    coil : I;", "    ^^^^"),
        ("// 漢字 coil", "coil", "// 漢字 coil", "        ^^^^"),
        ("// 漢字", "字", "// 漢字", "     ^^"),
        ("// e\u0301 coil", "coil", "// e\u0301 coil", "     ^^^^"),
        ("a\0b", "b", "a\ufffdb", "  ^"),
        ("a\x1b[31mb", "b", "a\ufffd[31mb", "      ^"),
    ],
)
def test_columns_are_those_of_the_terminal(
    line: str, found: str, shown: str, underline: str
) -> None:
    source = Source("a.bg", f"{line}\r\nnext")
    text = plain(diagnostic(at(source, found)))
    assert text.splitlines()[3:] == [f"1 | {shown}", f"  | {underline}"]


def test_end_of_file_and_empty_file() -> None:
    for source in (Source("a.bg", ""), Source("a.bg", "a\n")):
        end = len(source.text)
        assert "^" in plain(diagnostic(Span(source, end, end)))


def test_long_line_is_clipped_around_the_place() -> None:
    source = Source("a.bg", "x" * 5_000_000 + "fault" + "y" * 5_000_000)
    text = plain(diagnostic(at(source, "fault")))
    assert len(text) < 400
    *_, line, underline = text.splitlines()
    assert line[underline.index("^") :].startswith("fault")
    assert underline.count("^") == 5
    assert line.startswith("1 | ...x") and line.endswith("y...")


def test_colour_changes_nothing_but_the_colour() -> None:
    one = diagnostic(at(RLC, "I(L)"), Label(at(RLC, "R"), "declared here"), note="why", help="out")
    coloured = render([one], colour=True)
    assert "\x1b[1;31merror[BG201]\x1b[0m" in coloured
    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured) == plain(one)


def test_an_exception_tells_place_code_and_way_out():
    error = BgError([diagnostic(at(RLC, "I(L)"), help="correct it"), diagnostic(None)])
    assert str(error) == "rlc.bg:3:10: BG201: what is wrong (correct it)\nBG201: what is wrong"


@pytest.mark.parametrize(
    ("kind", "spoken"),
    [
        ("Se", "an Se"),
        ("MSf", "an MSf"),
        ("IC", "an IC"),
        ("R", "an R"),
        ("C", "a C"),
        ("TF", "a TF"),
        ("GY", "a GY"),
        ("J1", "a J1"),
        ("Mux", "a Mux"),
        ("Revolute", "a Revolute"),
        ("Link", "a Link"),
        ("OsvSeakeeping", "an OsvSeakeeping"),
        ("Universal", "a Universal"),
        ("output", "an output"),
        ("unknown", "an unknown"),
        ("state", "a state"),
        ("8 x 3 matrix", "an 8 x 3 matrix"),
        ("11 x 3 matrix", "an 11 x 3 matrix"),
        ("3 x 8 matrix", "a 3 x 8 matrix"),
        ("110 x 3 matrix", "a 110 x 3 matrix"),
    ],
)
def test_the_article_follows_the_sound(kind, spoken):
    assert with_article(kind) == spoken
