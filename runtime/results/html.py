"""Tables and figures as HTML, for notebooks."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING

from bgc.printing.text_tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_ROWS = 60
_DPI = 80


def table_html(table: Table) -> str:
    """Return a table with its title and note; rows beyond `MOST_ROWS` are counted."""
    head = "".join(f"<th style='text-align:left'>{escape(h)}</th>" for h in table.header)
    shown = table.rows[:MOST_ROWS]
    rows = "".join(
        "<tr>" + "".join(f"<td style='text-align:left'>{escape(c)}</td>" for c in row) + "</tr>"
        for row in shown
    )
    more = len(table.rows) - len(shown)
    note = "; ".join(filter(None, (f"{more} rows more" if more > 0 else "", table.note)))
    title = f"<b>{escape(table.title)}</b>" if table.title else ""
    tail = f"<small>{escape(note)}</small>" if note else ""
    return f"{title}<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>{tail}"


def tables_html(tables: Iterable[Table]) -> str:
    """Return the tables that have rows or notes, one below the other."""
    return "".join(table_html(table) for table in tables if table.rows or table.note)


def figure_html(figure: Figure) -> str:
    """Return a figure as an image within the page."""
    out = BytesIO()
    figure.savefig(out, format="png", dpi=_DPI)
    text = b64encode(out.getvalue()).decode("ascii")
    return f"<img alt='plot' src='data:image/png;base64,{text}'>"
