"""Rows of measured ratios, beside what they have to reach, and the machine they are from."""

from __future__ import annotations

import csv
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from rich.console import Console
from rich.table import Table

from bgc.building.toolchain import find_toolchain


@dataclass(frozen=True, slots=True)
class Row:
    """One figure. `ratio` is None where the peer is missing, and `note` says why.

    `must` and `aim` are bounds from below, or from above where `below` is set.
    """

    against: str
    on: str
    ratio: float | None
    must: float | None = None
    aim: float | None = None
    below: bool = False
    note: str = ""

    @property
    def verdict(self) -> str:
        if self.ratio is None:
            return "not measured"
        if self._reaches(self.aim) and self.aim is not None:
            return "aim"
        if self.must is None:
            return "" if self.aim is None else "below aim"
        return "must" if self._reaches(self.must) else "MISSED"

    def _reaches(self, bound: float | None) -> bool:
        assert self.ratio is not None
        if bound is None:
            return False
        return self.ratio <= bound if self.below else self.ratio >= bound


def pin() -> None:
    """Keeps this process on one processor, where the system lets it."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def show(title: str, rows: Sequence[Row], out: Path | None = None) -> None:
    """Prints the rows, and writes them to a CSV file if asked."""
    console = Console(width=150)
    table = Table(title=title, title_justify="left", title_style="bold")
    for column in ("against", "on"):
        table.add_column(column)
    for column in ("must", "aim", "measured"):
        table.add_column(column, justify="right")
    for column in ("reaches", "note"):
        table.add_column(column)
    for row in rows:
        sign = "<= " if row.below else ""
        table.add_row(
            row.against,
            row.on,
            _bound(sign, row.must),
            _bound(sign, row.aim),
            "-" if row.ratio is None else f"{row.ratio:.3g} x",
            row.verdict,
            row.note,
        )
    console.print(table)
    if out is not None:
        fresh = not out.exists()
        with out.open("a", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            if fresh:
                writer.writerow(("against", "on", "must", "aim", "measured", "reaches", "note"))
            for row in rows:
                values = (row.must, row.aim, row.ratio)
                writer.writerow((row.against, row.on, *values, row.verdict, row.note))


def _bound(sign: str, value: float | None) -> str:
    return "" if value is None else f"{sign}{value:.3g} x"


def machine(*packages: str) -> str:
    """The processor, the compiler and the versions of some packages."""
    model = platform.processor()
    info = Path("/proc/cpuinfo")
    if info.exists():
        lines = info.read_text("ascii", "replace").splitlines()
        model = next((x.split(":")[1].strip() for x in lines if x.startswith("model name")), model)
    parts = [model, f"{os.cpu_count()} processors", find_toolchain().version]
    for package in packages:
        try:
            parts.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            parts.append(f"{package} missing")
    return ", ".join(parts)
