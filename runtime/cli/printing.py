"""Tables on a terminal and in a pipe."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterable

import click

from bgc.printing.tables import Table, fitted, table_text

_BETWEEN = 2  # characters between columns
_PIPE_WIDTH = 100  # characters of a line that goes to no terminal
_SHORT = 24  # characters of a cell that is not wrapped


def print_tables(tables: Iterable[Table]) -> None:
    """Print tables in order: with rules and colours on a terminal, else as text.

    A table without rows and note is left out.
    """
    plain = not sys.stdout.isatty() or os.environ.get("TERM") == "dumb"
    first = True
    for table in tables:
        if not (table.rows or table.note):
            continue
        if plain:
            click.echo(("" if first else "\n") + table_text(table), nl=False)
        else:
            _print_rich(table)
        first = False


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
    table = fitted(table, console.width - 1, _BETWEEN)
    console.print(Text(table.title, style="bold"))
    if table.rows:
        shown = RichTable(
            box=box.SIMPLE_HEAD, show_header=bool(table.header), padding=(0, _BETWEEN - 1, 0, 0)
        )
        for place, heading in enumerate(table.header or ("",) * len(table.rows[0])):
            short = max(len(row[place]) for row in table.rows) <= _SHORT
            shown.add_column(heading, overflow="fold", no_wrap=short and bool(table.spare))
        for row in table.rows:
            shown.add_row(*(Text(cell) for cell in row))
        console.print(shown)
    if table.note:
        console.print(Text(f"{table.note}\n"))
