"""Files and settings: how they are read and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from parsed import show, wrong
from refusals import refusal

from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source
from bgc.grammar import source_files
from bgc.grammar.parse import parse, parse_setting, read_source

# --- the command line -------------------------------------------------------------------


def test_setting() -> None:
    setting = parse_setting(Source("--set", "crane.boom[2].mass=3 t"))
    assert show(setting.target) == "crane.boom[2].mass"
    assert show(setting.value) == "3_t"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "BG101"),
        ("a.b", "BG101"),
        ("a=", "BG101"),
        ("a=3t", "BG106"),
        ("a==3", "BG108"),
        ("a=3;", "BG101"),
        ("in=3", "BG112"),
        ("a=[]", "BG126"),
        ("a=" + "(" * 1000, "BG118"),
        ("a=" + "1" * 200_000, "BG120"),
    ],
)
def test_wrong_setting(text: str, code: str) -> None:
    diagnostic = refusal(lambda: parse_setting(Source("--set", text)))
    assert diagnostic.code == code, diagnostic.message


@pytest.mark.parametrize(
    ("given", "read"),
    [
        ("40 1/m", "40_m^-1"),
        ("-4.5e2 1/s^2", "(-450_s^-2)"),
        ("40 1/m^-1*s", "40_m*s"),
        ("40 1/s/m^2", "40_s^-1/m^2"),
    ],
)
def test_a_unit_of_a_setting_may_begin_with_one(given: str, read: str) -> None:
    assert show(parse_setting(Source("--set", f"k = {given}")).value) == read


@pytest.mark.parametrize("text", ["40 1/", "40 1/(m*s)", "40 1/m/2", "p 1/m"])
def test_what_is_not_such_a_unit_is_refused(text: str) -> None:
    with pytest.raises(BgError):
        parse_setting(Source("--set", f"k = {text}"))


def test_a_file_is_answered_with_the_spelling_of_such_a_unit() -> None:
    _, (problem,) = parse(Source("m.bg", "model M { let y = 40 1/m^2*kg; }"))
    assert (problem.code, "`40 m^-2*kg`" in problem.help) == ("BG114", True)


# --- files ------------------------------------------------------------------------------


def code_of(path: Path) -> str:
    diagnostic = refusal(read_source, path)
    return f"{diagnostic.code}: {diagnostic.message}"


def test_file_is_read_with_or_without_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "a.bg"
    for mark in (b"", b"\xef\xbb\xbf"):
        path.write_bytes(mark + "// ø\r\n".encode())
        assert read_source(path).text == "// ø\r\n"


def test_unreadable_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert code_of(tmp_path / "no.bg").startswith("BG001")
    assert code_of(Path("a\0b")).startswith("BG001")
    assert code_of(tmp_path).startswith("BG002")
    path = tmp_path / "a.bg"
    path.mkdir()
    assert code_of(path / "x" / "y.bg").startswith("BG001")
    latin = tmp_path / "latin.bg"
    latin.write_bytes("// blåse".encode("latin-1"))
    assert code_of(latin) == f"BG004: `{latin}` is not UTF-8: byte 0xe5 at offset 5"
    archive = tmp_path / "m.fmu"
    archive.write_bytes(b"PK\x03\x04\xff")
    assert code_of(archive) == f"BG004: `{archive}` is an archive, not a text"
    monkeypatch.setattr(source_files, "MAX_BYTES", 7)
    assert code_of(latin).startswith("BG005")
    assert code_of(latin / "below.bg").startswith("BG003")


def test_save_of_bondgraphtools_is_recognised() -> None:
    text = "version: 0.1\nroot: RLC\nmodels:\n  RLC:\n    components:\n      R1:\n"
    assert wrong(text) == [("BG006", "version: 0.1")]
