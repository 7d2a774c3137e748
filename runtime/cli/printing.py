"""Tables on a terminal and in a pipe."""

from __future__ import annotations

import os
import re
import shutil
import sys
import textwrap
from collections.abc import Iterable

import click

from bgc.printing.tables import Table, fitted, parted, table_text
from bgc.runtime.cli.app import printable

_QUOTED = re.compile(r"`[^`]*`")
_NO_BREAK = "\0"  # stands for a blank where a line does not end
_BETWEEN = 2  # characters between columns
_PIPE_WIDTH = 100  # characters of a line that goes to no terminal
_SHORT = 24  # characters of a cell that is not broken over lines
_NARROWEST = 20  # characters of a column of sentences


def print_tables(tables: Iterable[Table]) -> None:
    """Print tables in order: with rules and colours on a terminal, else as text.

    A table without rows and note is left out.
    """
    plain = not sys.stdout.isatty() or os.environ.get("TERM") == "dumb"
    first = True
    for table in tables:
        if not (table.rows or table.note):
            continue
        if not first:
            click.echo()
        if plain:
            click.echo(table_text(table), nl=False)
        else:
            _print_rich(table)
        first = False


def print_written(*files: str | None) -> None:
    """Name the files that a command has written; those of options that were not given are None.

    The line goes to standard error where an option sends rows to standard output.
    """
    names = [file for file in files if file and file != "-"]
    if names:
        click.echo(printable(f"wrote {' and '.join(names)}"), err="-" in files)


def print_sentence(text: str) -> None:
    """Print prose: wrapped on a terminal, where no text in backquotes is broken."""
    if not sys.stdout.isatty():
        click.echo(text)
        return
    whole = _QUOTED.sub(lambda code: code[0].replace(" ", _NO_BREAK), text)
    lines = textwrap.wrap(
        whole, min(text_width(), _PIPE_WIDTH), break_long_words=False, break_on_hyphens=False
    )
    click.echo("\n".join(lines).replace(_NO_BREAK, " "))


def hanging(first: str, text: str, indent: int) -> str:
    """A text after the beginning of its first line; on a terminal, further lines are indented.

    Words, such as addresses and paths, are not broken.
    """
    if not sys.stdout.isatty():
        return first + text
    lines = textwrap.wrap(
        text,
        max(text_width() - indent, _NARROWEST),
        break_long_words=False,
        break_on_hyphens=False,
    )
    return first + f"\n{'':{indent}}".join(lines)


def text_width() -> int:
    """Characters of a line: those of the terminal (or of COLUMNS), else 100."""
    return shutil.get_terminal_size((_PIPE_WIDTH, 24)).columns


def _print_rich(table: Table) -> None:
    # Slow to load, and output to a pipe does without it.
    from rich import box
    from rich.console import Console
    from rich.table import Table as RichTable
    from rich.text import Text

    console = Console(no_color="NO_COLOR" in os.environ, highlight=False)
    room = console.width + 1
    table = fitted(table, room, _BETWEEN)
    needed = [width or _NARROWEST for width in _unbroken_widths(table)]
    wide = sum(needed) + _BETWEEN * len(needed) > room
    parts = parted(table, needed, room, _BETWEEN) if wide and table.header else (table,)
    for number, part in enumerate(parts):
        if number:
            click.echo()
        widths = _unbroken_widths(part)
        if sum(width or _NARROWEST for width in widths) + _BETWEEN * len(widths) > room:
            click.echo(table_text(part), nl=False)  # a cut cell would be a wrong number
            continue
        if part.title:
            console.print(Text(part.title, style="bold"))
        if part.rows:
            shown = RichTable(
                box=box.SIMPLE_HEAD,
                show_header=bool(part.header),
                show_edge=False,
                padding=(0, _BETWEEN - 1, 0, 0),
            )
            for place, width in enumerate(widths):
                heading = Text(part.header[place] if part.header else "")  # no markup: `x [mm]`
                shown.add_column(heading, overflow="fold", no_wrap=bool(width), min_width=width)
            for row in part.rows:
                shown.add_row(*(Text(cell) for cell in row))
            console.print(shown)
        for line in part.note.splitlines():  # code is not broken, so that it can be copied
            console.print(Text(line), soft_wrap="`" in line)


def _unbroken_widths(table: Table) -> list[int | None]:
    """The width of each column whose cells are not broken: numbers, names; None for sentences."""
    if not table.rows:
        return []
    found: list[int | None] = []
    for place in range(len(table.rows[0])):
        cells = [row[place] for row in (*table.rows, *((table.header,) if table.header else ()))]
        width = max(map(len, cells))
        one_word = all(" " not in cell for cell in cells)
        found.append(width if width <= _SHORT or one_word else None)
    return found
