"""The table of the outside checks' defects: every row is there, and every test that it names."""

from __future__ import annotations

import re
from pathlib import Path

TESTS = Path(__file__).parents[1]
ROWS = {"A": 16, "B": 8, "C": 9, "D": 16}


def test_every_defect_has_a_row_and_its_test_exists() -> None:
    text = (TESTS / "campaigns" / "DEFECTS.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| ([A-D]\d+) \|.*\|([^|]*)\|$", text, re.MULTILINE))
    assert set(rows) == {f"{part}{k + 1}" for part, count in ROWS.items() for k in range(count)}
    for name, cell in rows.items():
        found = re.fullmatch(r" `(\S+\.py): (test_\w+)` ", cell)
        assert found is not None, name
        source = (TESTS / found[1]).read_text(encoding="utf-8")
        assert f"\ndef {found[2]}(" in source, name
