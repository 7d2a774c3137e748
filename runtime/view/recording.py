"""Recorded runs: a `Result`, or a file that `bgc run --out` wrote."""

from __future__ import annotations

import csv
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.files import file_missing, unreadable
from bgc.diagnostics.catalogue.view import not_a_result
from bgc.diagnostics.diagnostic import BgError
from bgc.language.scene import Plot
from bgc.record_class import dataclass
from bgc.runtime.results.recorded_shapes import read_shapes
from bgc.runtime.results.result import Result
from bgc.runtime.view.history import Rows, as_rows
from bgc.runtime.view.scene_description import Description, describe_result, meshes_of
from bgc.values.shown_units import Shown

RESULTS = (".npz", ".csv")


@dataclass(frozen=True)
class Recording:
    """A finished run for the page: its description, its rows and the files of its meshes."""

    description: Description
    rows: Rows
    meshes: list[Path]


def recorded(result: Result, name: str, folder: Path) -> Recording:
    """Prepare a result for the page; mesh files are relative to `folder`."""
    description, values = describe_result(result, name)
    meshes = meshes_of(description, folder)
    return Recording(description, as_rows(result.time, values), meshes)


def read_recording(path: Path) -> Recording:
    """Read a recorded run; BG009 for a file that is not one."""
    if not path.is_file():
        raise BgError([file_missing(str(path))])
    try:
        result = _read_csv(path) if path.suffix.lower() == ".csv" else _read_npz(path)
    except PermissionError as problem:
        raise BgError([unreadable(str(path), problem.strerror or str(problem))]) from problem
    except (ValueError, KeyError, TypeError, OSError, zipfile.BadZipFile) as problem:
        raise BgError([not_a_result(str(path), _reason(problem))]) from problem
    if not len(result.time):
        raise BgError([not_a_result(str(path), "it has no rows")])
    return recorded(result, path.name, path.absolute().parent)


def _reason(problem: Exception) -> str:
    if isinstance(problem, KeyError):
        return f"it has no {problem}"
    return str(problem).splitlines()[0] if str(problem) else type(problem).__name__


def _read_npz(path: Path) -> Result:
    with np.load(path, allow_pickle=False) as arrays:
        about: dict[str, Any] = json.loads(str(arrays["about"]))
        time = arrays["time"]
        columns = {name: arrays[name] for name in about["units"] if name != "time"}
    factors = about.get("factors", {})
    shown = {name: Shown(unit, factors.get(name, 1.0)) for name, unit in about["shown"].items()}
    if any(column.shape != time.shape for column in columns.values()) or time.ndim != 1:
        raise ValueError("its columns are not of equal length")
    return Result(
        scene=about["scene"],
        time=time,
        columns=columns,
        units=about["units"],
        shown=shown,
        shapes=read_shapes(path),
        solver=about["solver"],
        counts={},
        status=about["status"],
        message=about["message"],
        panels=tuple(Plot(tuple(names), across) for names, across in about.get("panels", ())),
    )


def _read_csv(path: Path) -> Result:
    with path.open(encoding="utf-8", newline="") as file:
        lines = csv.reader(file)
        header = next(lines, [])
        if header[:1] != ["time"]:
            raise ValueError("its first column is not `time`")
        values = np.array(list(_numbers(lines, len(header))), float).reshape(-1, len(header))
    return Result(
        scene=path.stem,
        time=values[:, 0],
        columns={name: values[:, k] for k, name in enumerate(header) if k},
        units=dict.fromkeys(header[1:], ""),
        solver="",
        counts={},
    )


def _numbers(lines: Iterator[list[str]], width: int) -> Iterator[list[float]]:
    for line in lines:
        if len(line) != width:
            raise ValueError(f"a row has {len(line)} values, not {width}")
        yield [float(text) for text in line]
