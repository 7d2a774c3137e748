"""BEMIO: the `.h5` files that WEC-Sim reads, of one body.

The time dependence is exp(+i w t) and the axes are ours; the crest is at the origin of the global
axes, moments are about the centre of gravity, or `c0` where a file has it. Without `scaled`,
stiffness and forces are divided by density times gravity, added mass by density, and damping by
density times frequency. Source: `writeBEMIOH5.m` and `normalizeBEM.m` of WEC-Sim; `bemioh5.cpp` of
BEMRosetta.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.imported import not_importable, wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.importing.hydrodynamics.account import Account, Given
from bgc.runtime.importing.hydrodynamics.netcdf import HDF5
from bgc.runtime.importing.hydrodynamics.record import Hull, Real
from bgc.runtime.results.columns import optional_package

ENDINGS = (".h5",)


def read_bemio(path: Path, given: Given, account: Account) -> Hull:
    """Read a file of one body.

    Raises
    ------
    BgError
        BG137 for a file that is not HDF5 or lacks a part of BEMIO's; BG138 for several bodies and
        arrays of another shape; BG058 without h5py.
    """
    with path.open("rb") as stream:
        is_hdf5 = stream.read(8) == HDF5
    if not is_hdf5:
        raise BgError([not_importable(f"{path} is not an HDF5 file", help="write it again")])
    h5py = optional_package("h5py", "reading BEMIO", "hydro")
    try:
        with h5py.File(path, "r") as file:
            if "body2" in file:
                what = f"{path} holds several bodies"
                raise BgError([wrong_value(None, what, "run the program with one body")])
            found: dict[str, Any] = {}
            file.visititems(lambda name, item: _keep(found, name, item, h5py.Dataset))
    except (OSError, ValueError, KeyError) as problem:
        what = f"{path} is a damaged HDF5 file: {str(problem)[:200]}"
        raise BgError([not_importable(what, help="write it again")]) from problem
    return _File(path, found).hull(given, account)


def _keep(found: dict[str, Any], name: str, item: Any, kind: Any) -> None:
    if isinstance(item, kind):
        found[name] = item[()]


class _File:
    def __init__(self, path: Path, found: dict[str, Any]) -> None:
        self.path = path
        self.found = found

    def hull(self, given: Given, account: Account) -> Hull:
        """Assemble the record."""
        density = self._number("simulation_parameters/rho")
        gravity = self._number("simulation_parameters/g")
        frequency = self._array("simulation_parameters/w", (-1,))
        heading = self._array("simulation_parameters/wave_dir", (-1,))
        n, m = len(frequency), len(heading)
        waves = "body1/hydro_coeffs/excitation"
        force = self._array(f"{waves}/re", (6, m, n)) + 1j * self._array(f"{waves}/im", (6, m, n))
        added = self._array("body1/hydro_coeffs/added_mass/all", (6, 6, n))
        damping = self._array("body1/hydro_coeffs/radiation_damping/all", (6, 6, n))
        infinite = self._optional("body1/hydro_coeffs/added_mass/inf_freq", (6, 6))
        stiffness = self._array("body1/hydro_coeffs/linear_restoring_stiffness", (6, 6))
        scaled = self.found.get("simulation_parameters/scaled", 0)
        if not np.any(np.asarray(scaled, float)):
            force, stiffness = (x * density * gravity for x in (force, stiffness))
            added, damping = added * density, damping * density * frequency
            infinite = None if infinite is None else infinite * density
        gravity_centre = self._optional("body1/properties/cg", (3,))
        about = self._optional("body1/properties/c0", (3,))
        if about is None:
            about = gravity_centre
        if about is None:
            account.assumed("moments about the origin in the surface", "add properties/cg")
            about = np.zeros(3)
        order = np.argsort(frequency)
        account.read(f"{self.path.name}: {n} frequencies, headings: {m}")
        account.missing("mass matrix: the format has none")
        return Hull(
            name=self.path.stem,
            program="BEMIO",
            density=given.density or density,
            gravity=gravity,
            depth=self._depth(),
            frequency=frequency[order],
            added_mass=np.moveaxis(added, 2, 0)[order],
            damping=np.moveaxis(damping, 2, 0)[order],
            added_mass_infinite=infinite,
            heading=np.radians(heading),
            force=force.transpose(2, 1, 0)[order],
            origin=about,
            stiffness=stiffness,
            volume=self._volume(),
            centre_of_gravity=gravity_centre,
            centre_of_buoyancy=self._optional("body1/properties/cb", (3,)),
        )

    def _array(self, name: str, shape: tuple[int, ...]) -> Real:
        if name not in self.found:
            what = f"{self.path} has no `{name}`: not a file of BEMIO"
            raise BgError([not_importable(what, help="write it with `writeBEMIOH5`")])
        values = np.squeeze(np.asarray(self.found[name], float))
        if shape == (-1,):
            return np.atleast_1d(values).ravel()
        if values.size != np.prod(shape):
            what = f"{self.path}: `{name}` has the shape {values.shape}, and {shape} is due"
            raise BgError([wrong_value(None, what, "run the program with one body, six modes")])
        return values.reshape(shape)

    def _optional(self, name: str, shape: tuple[int, ...]) -> Real | None:
        return self._array(name, shape) if name in self.found else None

    def _number(self, name: str) -> float:
        value = float(self._array(name, (-1,))[0])
        if not value > 0:
            raise BgError([wrong_value(None, f"{self.path}: `{name}` is {value:g}", "correct it")])
        return value

    def _volume(self) -> float | None:
        found = self._optional("body1/properties/disp_vol", (-1,))
        return None if found is None or not found[0] > 0 else float(found[0])

    def _depth(self) -> float:
        found = self.found.get("simulation_parameters/water_depth", b"infinite")
        if isinstance(found, bytes | str):
            return np.inf
        return float(np.ravel(np.asarray(found, float))[0])
