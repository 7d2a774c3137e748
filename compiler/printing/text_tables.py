"""Tables as data and as plain text, from which commands compose their output."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.record_class import dataclass, replace

_WIDEST = 60  # characters of a column up to which the next one is aligned


@dataclass(frozen=True, slots=True)
class Table:
    """Rows under a title, with an optional header above and an optional note below.

    `spare` are headings of columns that may be dropped where space is short, in this order.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    spare: tuple[str, ...] = ()


def as_text(tables: Iterable[Table]) -> str:
    """Nonempty tables with aligned columns, separated by empty lines."""
    return "\n".join(table_text(table) for table in tables if table.rows or table.note)


def table_text(table: Table) -> str:
    """One table as text, one line per row."""
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
    """The width of each column; zero for the last one, which needs no padding."""
    if not rows:
        return []
    columns = list(zip(*rows, strict=True))
    return [min(max(map(len, column)), _WIDEST) for column in columns[:-1]] + [0]


def fitted(table: Table, width: int, between: int) -> Table:
    """Drop spare columns until a table fits `width` characters, and list them in its note.

    `between` is the number of characters added to each column.
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


def parted(table: Table, widths: Sequence[int], width: int, between: int) -> tuple[Table, ...]:
    """Part the columns of a table among tables that fit `width` characters, one below the other.

    Each begins with the first column, which names the rows. `widths` are characters of the columns,
    `between` those added to each. A column that is too wide by itself has a table of its own. The
    title stands above the first table, the note below the last one.
    """
    groups: list[list[int]] = []
    room = 0
    for place in range(1, len(widths)):
        needed = widths[place] + between
        if not groups or needed > room:
            groups.append([0])
            room = width - widths[0] - between
        groups[-1].append(place)
        room -= needed
    parts = [
        replace(
            table,
            title="",
            header=tuple(table.header[k] for k in group),
            rows=tuple(tuple(row[k] for k in group) for row in table.rows),
            note="",
        )
        for group in groups
    ]
    if not parts:
        return (table,)
    parts[0] = replace(parts[0], title=table.title)
    parts[-1] = replace(parts[-1], note=table.note)
    return tuple(parts)


def elided(rows: Sequence[tuple[str, ...]], most: int) -> tuple[tuple[str, ...], ...]:
    """The rows, at most `most` of them: the first and the last, with a row of dots between."""
    if len(rows) <= most:
        return tuple(rows)
    head = most // 2
    dots = tuple("..." for _ in rows[0])
    return (*rows[:head], dots, *rows[len(rows) - (most - head) :])
