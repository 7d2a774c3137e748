"""Tables as data, and as plain text: what commands print is made of these."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

_WIDEST = 60  # of a column that others are aligned to


@dataclass(frozen=True, slots=True)
class Table:
    """Rows under a title; `header` may be empty. `note` is said below them.

    `spare` are headings of columns that may be left out where there is no room, the first first.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    spare: tuple[str, ...] = ()


def as_text(tables: Iterable[Table]) -> str:
    """Tables one below the other, columns aligned, an empty line between; none that are empty."""
    return "\n".join(table_text(table) for table in tables if table.rows or table.note)


def table_text(table: Table) -> str:
    """One table as lines."""
    rows = [*([table.header] if table.header and table.rows else []), *table.rows]
    widths = _widths(rows)
    lines = [table.title]
    for row in rows:
        cells = (f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True))
        lines.append(f"  {'  '.join(cells)}".rstrip())
    if table.note:
        lines += [f"  {line}" for line in table.note.splitlines()]
    return "".join(f"{line}\n" for line in lines)


def _widths(rows: Sequence[Sequence[str]]) -> list[int]:
    """The width of each column, the last one as it is."""
    if not rows:
        return []
    columns = list(zip(*rows, strict=True))
    return [min(max(map(len, column)), _WIDEST) for column in columns[:-1]] + [0]


def fitted(table: Table, width: int, between: int) -> Table:
    """A table of at most so many characters, so many of them beside each column, if it can be.

    Spare columns are left out as long as it is wider; a note says which.
    """
    left_out: list[str] = []
    while table.rows and len(left_out) < len(table.spare):
        columns = list(zip(table.header, *table.rows, strict=True))
        if sum(max(map(len, column)) + between for column in columns) <= width:
            break
        left_out.append(table.spare[len(left_out)])
        place = table.header.index(left_out[-1])
        header, *rows = ((*row[:place], *row[place + 1 :]) for row in (table.header, *table.rows))
        table = replace(table, header=header, rows=tuple(rows))
    if not left_out:
        return table
    note = f"no room for {', '.join(reversed(left_out))}"
    return replace(table, note=f"{table.note}\n{note}".lstrip())


def elided(rows: Sequence[tuple[str, ...]], most: int) -> tuple[tuple[str, ...], ...]:
    """The rows, of more than `most` the first and the last with `...` between."""
    if len(rows) <= most:
        return tuple(rows)
    head = most // 2
    dots = tuple("..." for _ in rows[0])
    return (*rows[:head], dots, *rows[len(rows) - (most - head) :])
