"""Variables of a netCDF file: classic ones by SciPy, netCDF-4 (HDF5) by h5py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.imported import not_importable
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.results.columns import optional_package

HDF5 = b"\x89HDF\r\n\x1a\n"
_CLASSIC = b"CDF"
_DAMAGED = (OSError, ValueError, KeyError, TypeError, IndexError, RuntimeError, MemoryError)


@dataclass(frozen=True, slots=True)
class Variable:
    """An array with the names of its dimensions; texts are arrays of `str`."""

    dimensions: tuple[str, ...]
    values: Any


def read_netcdf(path: Path) -> dict[str, Variable]:
    """Read all variables of a file.

    Raises
    ------
    BgError
        BG137 for a file that is not netCDF, BG058 where h5py is missing.
    """
    with path.open("rb") as stream:
        head = stream.read(8)
    try:
        if head.startswith(_CLASSIC):
            return _classic(path)
        if head == HDF5:
            return _netcdf4(path)
    except _DAMAGED as problem:
        what = f"{path} is a damaged netCDF file: {str(problem)[:200]}"
        raise BgError([not_importable(what, help="write it again")]) from problem
    what = f"{path} is not a netCDF file"
    raise BgError([not_importable(what, help="name a file that `export_dataset` wrote")])


def _classic(path: Path) -> dict[str, Variable]:
    # Only Capytaine's classic files need it.
    from scipy.io import netcdf_file

    found = {}
    with netcdf_file(path, mmap=False) as file:
        for name, variable in file.variables.items():
            values, dimensions = np.array(variable.data), tuple(variable.dimensions)
            if values.dtype.kind == "S" and dimensions:  # the last dimension counts characters
                rows = values.reshape(-1, values.shape[-1])
                texts = [b"".join(row).rstrip(b"\0 ").decode("utf-8", "replace") for row in rows]
                values = np.array(texts, dtype=object).reshape(values.shape[:-1])
                dimensions = dimensions[:-1]
            elif values.dtype.kind in "iuf":
                values = values.astype(float)
            found[name] = Variable(dimensions, values)
    return found


def _netcdf4(path: Path) -> dict[str, Variable]:
    h5py = optional_package("h5py", "reading netCDF-4", "hydro")
    found = {}
    with h5py.File(path, "r") as file:
        for name, item in file.items():
            if not isinstance(item, h5py.Dataset):
                continue
            dimensions = tuple(_dimension(file, item, axis, name) for axis in range(item.ndim))
            values = item[()]
            if item.dtype.kind in "OS":
                texts = [
                    text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)
                    for text in np.atleast_1d(values).ravel()
                ]
                values = np.array(texts, dtype=object).reshape(item.shape)
            elif item.dtype.kind in "iuf":
                values = np.asarray(values, dtype=float)
            elif item.dtype.names == ("r", "i"):
                values = values["r"] + 1j * values["i"]
            found[name] = Variable(dimensions, values)
    return found


def _dimension(file: Any, item: Any, axis: int, name: str) -> str:
    """Return the name of an axis; a scale without a list is its own dimension."""
    listed = item.attrs.get("DIMENSION_LIST")
    if listed is None:
        return name
    return str(file[listed[axis][0]].name).lstrip("/")
