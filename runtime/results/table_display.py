"""Objects that print as their tables, and show as tables in a notebook."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from bgc.printing.text_tables import Table, as_text


class Tabled:
    """A base of classes with `tables()`: they are its text and its HTML."""

    __slots__ = ()

    @abstractmethod
    def tables(self) -> Sequence[Table]:
        """Return the tables that show the object."""

    def __repr__(self) -> str:
        return as_text(self.tables()).rstrip()

    def _repr_html_(self) -> str:
        # Only a notebook needs it.
        from bgc.runtime.results.html import tables_html

        return tables_html(self.tables())
