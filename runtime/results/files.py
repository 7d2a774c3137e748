"""Files written whole or not at all."""

from __future__ import annotations

import csv
import os
import tempfile
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np

from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.public import public_class

_ENDING = 20  # characters of the longest ending of a file's name


@contextmanager
def written_whole(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path to write to; move the file to `path` if no error occurs.

    An earlier file of that name stays untouched until then. A path that is not an ordinary file
    (`/dev/stdout`, a named pipe) is written directly. Raises BgError BG055 where the operating
    system refuses.
    """
    goal = Path(path)
    try:
        if goal.exists() and not goal.is_file():
            yield goal
            return
        goal = goal.resolve()  # through a link, which stays
        # Matplotlib needs the ending; a name that has 255 bytes leaves none for more.
        ending = goal.suffix if len(goal.suffix) < _ENDING else ""
        handle, name = tempfile.mkstemp(prefix=".bgc-", suffix=ending, dir=goal.parent)
        aside = Path(name)
        os.close(handle)
        try:
            yield aside
            aside.chmod(goal.stat().st_mode if goal.exists() else 0o666 & ~_umask())
            aside.replace(goal)
        finally:
            aside.unlink(missing_ok=True)
    except OSError as problem:
        raise BgError([cannot_write(str(path), problem.strerror or str(problem))]) from problem


def write_rows(path: str | Path, header: Sequence[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a CSV file whole or not at all, numbers in full precision; None is an empty cell."""
    with written_whole(path) as aside, aside.open("w", encoding="utf-8", newline="") as file:
        append_rows(file, header, rows)


def append_rows(file: TextIO, header: Sequence[str], rows: Iterable[Iterable[object]]) -> None:
    """Write the header and the rows of a table, as `write_rows` does, to an open file."""
    csv.writer(file, lineterminator="\n").writerows((header, *rows))


@public_class
class WrittenAsCsv:
    """A base of results that are written as CSV, to a file or to an open stream."""

    __slots__ = ()

    @abstractmethod
    def write_csv(self, file: TextIO) -> None:
        """Write as `to_csv` does, to an open file."""

    def to_csv(self, path: str | Path) -> None:
        """Write a file of what `write_csv` writes, whole or not at all.

        Of many runs those that an interruption left undone are omitted; the others keep their
        numbers.
        """
        with written_whole(path) as aside, aside.open("w", encoding="utf-8", newline="") as file:
            self.write_csv(file)


def write_files(folder: Path, files: Mapping[str, bytes]) -> list[Path]:
    """Write files to a folder, which is made where it is missing; return their paths.

    Each is written whole or not at all. Raises BgError BG055 where the operating system refuses.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        reason = problem.strerror or str(problem)
        raise BgError([cannot_write(str(folder), reason)]) from problem
    for name, content in files.items():
        with written_whole(folder / name) as aside:
            aside.write_bytes(content)
    return [folder / name for name in files]


def write_arrays(path: str | Path, arrays: Mapping[str, np.ndarray[Any, Any]]) -> None:
    """Write a NumPy archive, compressed, with any names.

    `np.savez` has an argument `file` of its own, so that no array could have that name.
    """
    with written_whole(path) as aside, ZipFile(aside, "w", ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.asanyarray(array), allow_pickle=False)


def _umask() -> int:
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
