"""Tables and figures as HTML, for notebooks, and objects that show as their tables."""

from __future__ import annotations

from abc import abstractmethod
from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING

from bgc.printing.text_tables import Table, as_text

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


class Tabled:
    """A base of classes with `tables()`: they are its text and its HTML."""

    __slots__ = ()

    @abstractmethod
    def tables(self) -> Sequence[Table]:
        """Return the tables that show the object."""

    def __repr__(self) -> str:
        return as_text(self.tables()).rstrip()

    def _repr_html_(self) -> str:
        return tables_html(self.tables())
