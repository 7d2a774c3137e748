"""Tables that commands print."""

from __future__ import annotations

from bgc.printing.text_tables import Table, fitted, table_text

TABLE = Table(
    "t", ("name", "steps", "time"), (("long one", "12,345", "1 ms"),), "a note", ("time",)
)


def test_spare_columns_are_left_out_where_there_is_no_room() -> None:
    assert fitted(TABLE, 24, 2) is TABLE  # 8 + 6 + 4, and 2 beside each
    narrow = fitted(TABLE, 23, 2)
    assert narrow.header == ("name", "steps")
    assert narrow.rows == (("long one", "12,345"),)
    assert narrow.note == "a note\nno room for time"


def test_columns_that_are_not_spare_stay_however_narrow_it_is() -> None:
    assert fitted(TABLE, 3, 2).header == ("name", "steps")
    assert fitted(Table("t", ("a",), (("wide",),)), 1, 2).header == ("a",)
    assert fitted(Table("t", ("a", "b"), (), spare=("b",)), 1, 2).header == ("a", "b")


def test_plain_text_has_every_column() -> None:
    assert table_text(TABLE) == "t\n  name      steps   time\n  long one  12,345  1 ms\n  a note\n"
