"""Entries of the reference as text for a terminal or a pipe."""

from __future__ import annotations

import io
import os
import re
import shutil
import sys
from collections.abc import Sequence

import click
from rich.console import Console
from rich.padding import Padding
from rich.table import Table as RichTable
from rich.text import Text as RichText

from bgc.diagnostics.render import escaped
from bgc.printing.text_tables import Table
from bgc.reference.entry import Code, Entry, Heading, Text

_PROSE = 96  # characters of a line of prose at most, however wide the terminal
_PIPE = 80  # characters of a line in a pipe
_QUOTED = re.compile(r"`([^`]+)`")


def print_entries(entries: Sequence[Entry]) -> None:
    """Print entries to standard output, in colour on a terminal."""
    console = _console()
    for place, entry in enumerate(entries):
        if place:
            console.print()
        _print_entry(console, entry)
    _write(console)


# --- entries --------------------------------------------------------------------------------


def _print_entry(console: Console, entry: Entry) -> None:
    head = _styled(entry.name, "bold")
    head.append(f"  ({entry.kind})" if entry.kind != "list" else "", style="dim")
    console.print(head)
    if entry.summary and not _opens_with(entry):
        _print_prose(console, f"{entry.summary[:1].upper()}{entry.summary[1:]}.")
    for block in entry.body:
        console.print()
        match block:
            case Text():
                _print_prose(console, block.text)
            case Code():
                _print_indented(console, _styled(block.text, "green"))
            case Heading():
                console.print(_styled(block.text, "bold"))
            case Table():
                if block.title:
                    console.print(_styled(block.title, "bold"))
                if block.rows:
                    _print_table(console, block)
                if block.note:
                    _print_indented(console, _prose(block.note, console))
    if entry.see_also:
        console.print()
        _print_prose(console, f"See also: {', '.join(entry.see_also)}")


def _opens_with(entry: Entry) -> bool:
    """Return whether the body says the summary again."""
    return any(
        isinstance(block, Text) and block.text.startswith(entry.summary) for block in entry.body
    )


def _print_prose(console: Console, text: str) -> None:
    console.print(_prose(text, console), width=min(console.width, _PROSE))


def _print_indented(console: Console, text: RichText) -> None:
    console.print(Padding(text, (0, 0, 0, 2)), width=console.width)


def _print_table(console: Console, table: Table) -> None:
    """Print a table; where it is too wide, the last cell of each row on lines of its own."""
    rows = [*([table.header] if table.header else []), *table.rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    others = sum(min(width, _WIDEST) + _BETWEEN for width in widths[:-1])
    below = len(widths) > 2 and _INDENT + others + min(widths[-1], _LEAST) > console.width
    shown = RichTable(
        box=None,
        header_style="dim",
        show_header=bool(table.header),
        pad_edge=False,
        padding=(0, _BETWEEN, 0, 0),
    )
    for k in range(len(widths) - below):
        heading = table.header[k] if table.header else ""
        is_name = k == 0 and not table.header
        whole = widths[k] <= (_LONGEST_NAME if is_name else _SHORT) and k < 2
        shown.add_column(heading, overflow="fold", no_wrap=whole)
    if not below:
        for row in table.rows:
            shown.add_row(*(_prose(cell, console) for cell in row))
        console.print(Padding(shown, (0, 0, 0, _INDENT)))
        return
    for row in rows:
        line = "  ".join(
            f"{cell:<{min(width, _SHORT)}}" for cell, width in zip(row[:-1], widths, strict=False)
        )
        _print_indented(console, _prose(line.rstrip(), console))
        if row[-1] and row is not table.header:
            console.print(Padding(_prose(row[-1], console), (0, 0, 0, 3 * _INDENT)))


_INDENT, _BETWEEN = 2, 2  # characters beside a table and between its columns
_LONGEST_NAME = 52  # characters of a name that is not broken
_WIDEST, _LEAST, _SHORT = 40, 24, 26  # characters: of a cell, of the last one, of one on one line


# --- text -----------------------------------------------------------------------------------


def _console() -> Console:
    """A console that writes into a buffer, with the width and colours of standard output."""
    from rich.console import Console

    terminal = sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
    width = shutil.get_terminal_size((_PIPE, 24)).columns
    return Console(
        file=io.StringIO(),
        force_terminal=terminal,
        no_color="NO_COLOR" in os.environ,
        width=width if terminal or "COLUMNS" in os.environ else _PIPE,
        highlight=False,
        legacy_windows=False,
    )


def _write(console: Console) -> None:
    """Write what the console holds, without blanks at the ends of lines."""
    text = console.file.getvalue()  # type: ignore[attr-defined]
    click.echo("\n".join(line.rstrip() for line in text.splitlines()))


def _styled(text: str, style: str) -> RichText:
    return RichText(_safe(text), style=style)


def _safe(text: str) -> str:
    """Comments of a stranger's file, without what a terminal would obey."""
    return "\n".join(escaped(line.expandtabs(4)) for line in text.split("\n"))


def _prose(text: str, console: Console) -> RichText:
    """Text with its code in colour; in a pipe in backticks."""
    text = _safe(text)
    if not console.is_terminal:
        return RichText(text)
    shown = RichText()
    for place, piece in enumerate(_QUOTED.split(text)):
        shown.append(piece, style="cyan" if place % 2 else "")
    return shown
