"""CSV tables of numbers with units in their header: cases, recorded motions, sea states."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.files import unreadable
from bgc.diagnostics.catalogue.studies import bad_case_table
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.parameters import Parameters
from bgc.runtime.running.quantity import read_quantity

_HEADING = re.compile(r"(?P<name>.+?)(?:\s+\[(?P<unit>[^\]]*)\])?")


def read_rows(path: str | Path) -> list[tuple[int, list[str]]]:
    """Read the cells of a CSV file with the numbers of their lines; empty lines are skipped.

    Lines that begin with `#` are comments.

    Raises BgError: BG788 for a file that is not text or has no rows, BG001 where it cannot be read.
    """
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file, skipinitialspace=True)
            rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except OSError as problem:
        raise BgError([unreadable(str(path), problem.strerror or str(problem))]) from problem
    except (UnicodeDecodeError, csv.Error) as problem:
        raise BgError([bad_case_table(str(path), "it is not a text in UTF-8")]) from problem
    found = [(n, row) for n, row in rows if any(row) and not row[0].startswith("#")]
    if len(found) < 2:
        reason = "it has a header and no rows" if found else "it is empty"
        raise BgError([bad_case_table(str(path), reason)])
    return found


def number_of(text: str, path: str | Path, line: int) -> float:
    """Read a finite number; BG788 for another text."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BgError([bad_case_table(str(path), f"`{text}` is not a number", line)])
    return number


def read_columns(path: str | Path) -> dict[tuple[str, str], Array]:
    """Read the columns of a table by their names and units; the unit is empty where none stands.

    Raises BgError: BG788.
    """
    (line, header), *rows = read_rows(path)
    heads: list[tuple[str, str]] = []
    for cell in header:
        match = _HEADING.fullmatch(cell)
        if match is None or any(match["name"] == name for name, _ in heads):
            raise BgError([bad_case_table(str(path), "a column has no name of its own", line)])
        heads.append((match["name"], (match["unit"] or "").strip()))
    table = np.empty((len(rows), len(heads)))
    for k, (number, row) in enumerate(rows):
        if len(row) != len(heads):
            reason = f"it has {counted(len(row), 'cell')} below {counted(len(heads), 'name')}"
            raise BgError([bad_case_table(str(path), reason, number)])
        table[k] = [number_of(cell, path, number) for cell in row]
    return {head: table[:, k] for k, head in enumerate(heads)}


def read_cases(path: str | Path, parameters: Parameters) -> dict[str, Array]:
    """Read a table of cases: a column for each parameter, SI or in the unit of its heading.

    Raises BgError: BG788, and the errors of an unknown parameter or a wrong unit.
    """
    return {
        name: column * factor(unit, name, parameters[name].unit)
        for (name, unit), column in read_columns(path).items()
    }


def factor(unit: str, name: str, si: str) -> float:
    """The factor from a unit to SI; BG063 if it has another dimension."""
    return read_quantity(f"1 {unit}", name, si) if unit else 1.0
