"""What commands print, write and return: tables, diagnostics, files, exit statuses."""

import io
import os
import re
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.exceptions import Exit

from bgc.diagnostics.diagnostic import Diagnostic

if TYPE_CHECKING:
    from bgc.printing.text_tables import Table

DONE, AT_FAULT, USAGE, BUG, INTERRUPTED = 0, 1, 2, 70, 130
"""Exit statuses; see `bgc.runtime.cli.main`."""

_NOT_UTF8 = re.compile("[\udc80-\udcff]")  # surrogates for bytes of file names
_QUOTED = re.compile(r"`[^`]*`")
_NO_BREAK = "\0"  # stands for a blank where a line does not end
_BETWEEN = 2  # characters between columns
_PIPE_WIDTH = 100  # characters of a line that goes to no terminal
_SHORT = 24  # characters of a cell that is not broken over lines
_NARROWEST = 20  # characters of a column of sentences


def print_diagnostics(diagnostics: Iterable[Diagnostic]) -> None:
    """Print diagnostics to standard error, in colour on a terminal."""
    diagnostics = tuple(diagnostics)
    if not diagnostics:
        return
    # `--help` and runs without warnings do without it.
    from bgc.diagnostics.render import render

    plain = "NO_COLOR" in os.environ or os.environ.get("TERM") == "dumb"
    if text := render(diagnostics, colour=sys.stderr.isatty() and not plain):
        with suppress(OSError):  # the terminal is closed: what follows may still write files
            click.echo(printable(text), err=True, nl=False)


def printable(text: str) -> str:
    r"""Show the bytes of a file's name that are not UTF-8 as `\xff`."""
    return _NOT_UTF8.sub(lambda found: f"\\x{ord(found[0]) - 0xDC00:02x}", text)


MEASUREMENTS_KEPT = "interrupted; measurements are kept: the same command continues"


def attempt(run: Callable[[], Any], interrupted: str = "interrupted") -> tuple[Any, int]:
    """Call a function that runs models; return its result and the exit status.

    Where a run fails, or Ctrl-C ends it, say why, and return what the error holds as its result.
    Where it holds none, the command ends; `interrupted` says so where the error does not.
    """
    # Loads NumPy.
    from bgc.runtime.running.failures import RunInterrupted, SimulationError

    try:
        return run(), DONE
    except SimulationError as problem:
        print_diagnostics(problem.diagnostics)
        return problem.result, AT_FAULT
    except RunInterrupted as problem:
        print_diagnostics([problem.diagnostic])
        return problem.result, INTERRUPTED
    except KeyboardInterrupt as problem:
        kept = getattr(problem, "kept", False)
        again = "; the same command computes the others" if kept else ""
        click.echo(f"{str(problem) or interrupted}{again}", err=True)
        found = getattr(problem, "result", None)
        if found is None:
            raise Exit(INTERRUPTED) from problem
        return found, INTERRUPTED


def report(
    found: Any,
    tables: "Iterable[Table]",
    out: str | None = None,
    plot: str | None = None,
    *written: str | None,
) -> None:
    """Print the warnings of a result, write and draw it, print its tables, and name the files.

    `written` are files that exist already.
    """
    print_diagnostics(found.warnings)
    save(found, out, plot)
    print_tables(tables)
    print_written(out, plot, *written)


def save(
    found: Any, out: str | None = None, plot: str | None = None, html: str | None = None
) -> None:
    """Write a result as rows (to `out`; - is standard output) and as a page, and draw it."""
    if out == "-":
        found.write_csv(sys.stdout)
    elif out is not None:
        (found.to_npz if Path(out).suffix.lower() == ".npz" else found.to_csv)(out)
    if html is not None:
        found.to_html(html)
    if plot is not None:
        found.plot(plot)


def write_rows(out: str, rows: Iterable[Iterable[object]]) -> None:
    """Write rows as CSV to a file, or to standard output (-)."""
    # `bgc --help` does without it.
    import csv

    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    if out == "-":
        click.echo(text.getvalue(), nl=False)
    else:
        write_file(out, text.getvalue())


def write_file(path: str | Path, content: str | bytes) -> None:
    """Write a whole file, or none where the system refuses (BG055)."""
    # Loads NumPy.
    from bgc.runtime.results.files import written_whole

    with written_whole(path) as aside:
        aside.write_bytes(content.encode() if isinstance(content, str) else content)


def print_text(text: str, err: bool = False) -> None:
    """Print lines of text; the last one is ended where it is not."""
    click.echo(printable(text), err=err, nl=bool(text) and not text.endswith("\n"))


def print_paths(paths: Iterable[str | Path]) -> None:
    """Print a line for each path, in the bytes of the file system."""
    for path in paths:
        click.echo(os.fsencode(path))


def print_tables(tables: "Iterable[Table]") -> None:
    """Print tables in order: with rules and colours on a terminal, else as text.

    A table without rows and note is left out.
    """
    # `bgc --help` does without it.
    from bgc.printing.text_tables import table_text

    plain = not sys.stdout.isatty() or os.environ.get("TERM") == "dumb"
    for number, table in enumerate(each for each in tables if each.rows or each.note):
        if number:
            click.echo()
        if plain:
            click.echo(table_text(table), nl=False)
        else:
            _print_rich(table)


def print_written(*files: str | None) -> None:
    """Name the files that a command has written; those of options that were not given are None.

    The line goes to standard error where an option sends rows to standard output.
    """
    if names := [file for file in files if file and file != "-"]:
        print_text(f"wrote {' and '.join(names)}", err="-" in files)


def print_sentence(text: str) -> None:
    """Print prose: wrapped on a terminal, where no text in backquotes is broken."""
    if not sys.stdout.isatty():
        click.echo(text)
        return
    whole = _QUOTED.sub(lambda code: code[0].replace(" ", _NO_BREAK), text)
    lines = _wrapped(whole, min(text_width(), _PIPE_WIDTH))
    click.echo("\n".join(lines).replace(_NO_BREAK, " "))


def hanging(first: str, text: str, indent: int) -> str:
    """A text after the beginning of its first line; on a terminal, further lines are indented.

    Words, such as addresses and paths, are not broken.
    """
    if not sys.stdout.isatty():
        return first + text
    lines = _wrapped(text, max(text_width() - indent, _NARROWEST))
    return first + f"\n{'':{indent}}".join(lines)


def _wrapped(text: str, width: int) -> list[str]:
    return textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)


def text_width() -> int:
    """Characters of a line: those of the terminal (or of COLUMNS), else 100."""
    return shutil.get_terminal_size((_PIPE_WIDTH, 24)).columns


def _print_rich(table: "Table") -> None:
    # Slow to load, and output to a pipe does without it.
    from rich import box
    from rich.console import Console
    from rich.table import Table as RichTable
    from rich.text import Text

    from bgc.printing.text_tables import fitted, parted, table_text

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


def _unbroken_widths(table: "Table") -> list[int | None]:
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
