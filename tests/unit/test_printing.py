"""Tables and sentences on terminals of several widths: nothing is cut, no code is broken."""

from __future__ import annotations

import re

import pytest

from bgc.printing.text_tables import Table
from bgc.runtime.cli import printing

METHODS = Table(
    "configurations",
    ("", "method", "setting", "error/required", "cpu/s", "worst step", "residual", "LU"),
    (
        ("=>", "rodas4p2", "500 us, keep 2", "9.0e+02", "3.64 ms", "1.07 us ?", "1e-13", "12,041"),
        ("*", "ros34prw", "rtol 0.0001", "6.8e-02", "6.12 ms", "1.95 us", "3e-09", "1,204"),
    ),
    "`solver rodas4p2(rtol = 0.0001, atol = 1e-9, settle = 1 kHz, keep = 5, step = 1 ms);`",
    spare=("LU", "residual"),
)
SEAS = Table(
    "operability",
    ("", *(f"{k} s" for k in range(5, 22))),
    tuple((f"{h} m", *(f"*{h}.{k:02} a" for k in range(5, 22))) for h in (9, 1)),
    "* above its limit",
)
NAMES = Table(
    "slots",
    ("slot", "type", "states"),
    (("crane.shoulder.first.joint.lock", "Rigid[5]", "31"), ("vessel", "OsvInSwell", "53")),
)
SENTENCES = Table("left out", (), (("`a.b.c`: " + "nothing depends on it, " * 5,),))


@pytest.fixture
def terminal(monkeypatch, capsys):
    def show(width: int, table: Table) -> str:
        monkeypatch.setenv("COLUMNS", str(width))
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
        printing.print_tables([table])
        return capsys.readouterr().out

    return show


@pytest.mark.parametrize("width", [40, 60, 79, 80, 100, 200])
@pytest.mark.parametrize("table", [METHODS, NAMES, SEAS], ids=lambda table: table.title)
def test_no_cell_is_cut_and_no_name_broken(terminal, width: int, table: Table) -> None:
    shown = terminal(width, table)
    kept = [k for k, name in enumerate(table.header) if name not in table.spare]
    for row in table.rows:
        for k in kept:
            assert row[k] in shown
    assert table.note in shown  # code in the note is one line


def test_wide_tables_are_parted_by_columns_each_with_the_names_of_its_rows(terminal) -> None:
    shown = re.sub(r"\x1b\[\d*m", "", terminal(80, SEAS))
    assert max(map(len, shown.splitlines())) <= 80
    assert shown.count("9 m ") == shown.count("\n1 m ") == shown.count("─\n") == 3


def test_headings_are_no_markup(terminal) -> None:
    heading = "peak(stretch) [mm]"
    assert heading in terminal(80, Table("statistics", ("", heading), (("mean", "1.23"),)))


def test_findings_are_indented_on_a_terminal_and_one_line_in_a_pipe(monkeypatch) -> None:
    text = "install the kit, https://www.example.org/software/kit, and set KIT to its folder"
    assert printing.hanging("ok  kit  ", text, 9) == f"ok  kit  {text}"
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "50")
    first, *others = printing.hanging("ok  kit  ", text, 9).splitlines()
    assert first == "ok  kit  install the kit,"
    assert all(line.startswith(" " * 9) for line in others)
    assert " ".join(" ".join((first, *others)).split()) == " ".join(f"ok kit {text}".split())


def test_sentences_are_folded_at_blanks(terminal) -> None:
    lines = terminal(40, SENTENCES).splitlines()
    assert max(map(len, lines)) <= 40
    assert " ".join(" ".join(lines).split()).count("nothing depends on it,") == 5


def test_code_in_a_sentence_is_not_broken(monkeypatch, capsys) -> None:
    monkeypatch.setenv("COLUMNS", "50")
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    code = "`solver rodas4p2(rtol = 0.0001);`"
    printing.print_sentence(f"The cheapest configuration of all is {code} here and there.")
    shown = capsys.readouterr().out
    assert code in shown
    assert max(map(len, shown.splitlines())) <= 50
