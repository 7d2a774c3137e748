"""Zarr groups that are written while a run goes on."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.columns import optional_package
from bgc.runtime.results.row_files import MOST_ROWS, RowArray, RowFile

_MARK = "bgc_rows"  # the attribute by which a group is known as one of these
_RESERVE = ".reserve"  # a file that gives its room to the end of a run on a full disk
_RESERVED = 16_384  # bytes for each array


class ZarrRows(RowFile):
    """A group (version 3) with an array for each column along `time`, which xarray opens.

    `time` grows last: rows of other arrays beyond it are not complete.
    """

    def __init__(self, path: Path, arrays: Sequence[RowArray], about: Mapping[str, Any]) -> None:
        """Make the group; one that an earlier run wrote is replaced.

        Raises BgError: BG058 without Zarr, BG055 where the path holds something else.
        """
        zarr = optional_package("zarr", "a `.zarr` store", "cluster")
        if path.exists():
            _remove_earlier(zarr, path)
        self._path = path
        self._group = zarr.create_group(str(path), attributes=_attributes(about))
        self._arrays = {
            array.name: (array, self._made(array))
            for array in (*arrays, RowArray("time", "s", (), ()))
        }
        reserve = path / _RESERVE
        reserve.write_bytes(bytes(_RESERVED * len(self._arrays)))

    def append(self, times: Array, rows: Array) -> None:
        """Extend all arrays; where one cannot be extended, all are cut to the rows before."""
        before, after = self.rows, self.rows + len(times)
        try:
            for name, (array, stored) in self._arrays.items():
                stored.resize((after, *array.shape))
                stored[before:after] = times if name == "time" else array.of(rows)
        except OSError:
            (self._path / _RESERVE).unlink(missing_ok=True)
            for array, stored in self._arrays.values():
                stored.resize((before, *array.shape))
            raise
        self.rows = after

    def end(self, about: Mapping[str, Any]) -> None:
        """Write the status of the run."""
        (self._path / _RESERVE).unlink(missing_ok=True)
        self._group.attrs.update(_attributes(about))

    def _made(self, array: RowArray) -> Any:
        made = self._group.create_array(
            array.name.replace("/", "|"),
            shape=(0, *array.shape),
            chunks=(MOST_ROWS, *array.shape),
            dtype="float64",
            fill_value=float("nan"),
            dimension_names=("time", *(f"{array.name}:{k}" for k in range(len(array.shape)))),
        )
        made.attrs.update({"units": array.unit, "long_name": array.name})
        return made


def _attributes(about: Mapping[str, Any]) -> dict[str, Any]:
    kept = ("scene", "solver", "status", "message", "shown", "factors", "panels")
    return {_MARK: 1, **{name: about[name] for name in kept}}


def _remove_earlier(zarr: Any, path: Path) -> None:
    """Remove the rows of an earlier run; BG055 where a folder holds anything else."""
    with suppress(OSError, ValueError, KeyError):
        if zarr.open_group(str(path), mode="r").attrs.get(_MARK) is not None:
            shutil.rmtree(path)
            return
    raise BgError([cannot_write(str(path), "it exists and does not hold the rows of a run")])
