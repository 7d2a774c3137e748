"""Tables as data, and as plain text: what commands print is made of these."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

_WIDEST = 60  # of a column that others are aligned to


@dataclass(frozen=True, slots=True)
class Table:
    """Rows under a title; `header` may be empty. `note` is said below them."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


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


def elided(rows: Sequence[tuple[str, ...]], most: int) -> tuple[tuple[str, ...], ...]:
    """The rows, of more than `most` the first and the last with `...` between."""
    if len(rows) <= most:
        return tuple(rows)
    head = most // 2
    dots = tuple("..." for _ in rows[0])
    return (*rows[:head], dots, *rows[len(rows) - (most - head) :])
