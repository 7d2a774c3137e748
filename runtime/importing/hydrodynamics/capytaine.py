"""Capytaine: datasets of one floating body in netCDF.

Capytaine's harmonic time dependence is exp(-i w t), so that amplitudes are conjugated. Its axes are
ours; the crest is at the origin of the mesh, and moments are about the centre of rotation of the
degrees of freedom. Source: `capytaine/io/xarray.py` 3.0 and `readCAPYTAINE.m` of WEC-Sim.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.imported import not_importable, wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.words import listed
from bgc.runtime.importing.hydrodynamics.account import Account, Given
from bgc.runtime.importing.hydrodynamics.netcdf import Variable, read_netcdf
from bgc.runtime.importing.hydrodynamics.record import MODES, Complex, Hull, Real

_AXES = ("omega", "freq", "period", "wavelength", "wavenumber")


def read_capytaine(path: Path, _: Given, account: Account) -> Hull:
    """Read a dataset that `capytaine.export_dataset` or `to_netcdf` wrote.

    Raises
    ------
    BgError
        BG137 for a file without the variables of a dataset; BG138 for several bodies, depths or
        speeds, and for degrees of freedom other than six of a rigid body.
    """
    return _Dataset(path, account).hull()


class _Dataset:
    def __init__(self, path: Path, account: Account) -> None:
        self.path = path
        self.account = account
        self.variables = read_netcdf(path)
        needed = ("added_mass", "radiation_damping", "influenced_dof", "radiating_dof")
        lacking = [name for name in needed if name not in self.variables]
        if lacking:
            what = f"{path} has no {listed(lacking)}: not a Capytaine dataset"
            help = "write it with `assemble_dataset(results)` of radiation and diffraction"
            raise BgError([not_importable(what, help=help)])

    def hull(self) -> Hull:
        """Assemble the record."""
        speed = self._scalar("forward_speed", 0.0)
        if speed != 0:
            raise self._wrong(f"the speed ahead is {speed:g} m/s", "data at zero speed are read")
        self.axis, omega = self._frequency()
        finite = np.isfinite(omega) & (omega > 0)
        order = np.argsort(omega[finite])
        added, damping = (
            self._matrices(name, (self.axis, "influenced_dof", "radiating_dof"))
            for name in ("added_mass", "radiation_damping")
        )
        force = self._force()
        known = np.isfinite(force.real.sum(axis=(1, 2)) + added.sum(axis=(1, 2)))
        limits = {w: added[k] for k, w in enumerate(omega) if not finite[k]}
        rows = np.flatnonzero(finite)[order]
        rows = rows[known[rows]]
        if len(rows) == 0:
            help = "solve radiation and diffraction problems at the same frequencies"
            raise self._wrong("no frequency has both added mass and exciting force", help)
        heading = np.asarray(self.variables["wave_direction"].values, float)
        self.account.read(
            f"added mass, damping and exciting forces: {len(rows)} frequencies, "
            f"headings: {heading.size}"
        )
        mass, stiffness = self._optional("inertia_matrix"), self._optional("hydrostatic_stiffness")
        gravity_centre = self._point("center_of_mass")
        density = self._scalar("rho", np.nan)
        displaced = self._scalar("disp_mass", np.nan)
        return Hull(
            name=self.path.stem,
            program="Capytaine",
            density=self._needed("rho", density),
            gravity=self._needed("g", self._scalar("g", np.nan)),
            depth=self._scalar("water_depth", np.inf),
            frequency=omega[rows],
            added_mass=added[rows],
            damping=damping[rows],
            added_mass_zero=limits.get(0.0),
            added_mass_infinite=limits.get(np.inf),
            heading=np.atleast_1d(heading),
            force=force[rows],
            origin=self._origin(gravity_centre, mass),
            stiffness=stiffness,
            mass=mass,
            volume=None if np.isnan(displaced) else displaced / density,
            centre_of_gravity=gravity_centre,
            centre_of_buoyancy=self._point("center_of_buoyancy"),
        )

    def _wrong(self, what: str, help: str) -> BgError:
        return BgError([wrong_value(None, f"{self.path}: {what}", help)])

    def _frequency(self) -> tuple[str, Real]:
        """Return the name of the axis of frequencies, and circular frequencies along it."""
        dimensions = self.variables["added_mass"].dimensions
        axis = next((name for name in _AXES if name in dimensions), "omega")
        for name in _AXES[:3]:
            found = self.variables.get(name)
            if found is not None and found.dimensions in ((axis,), ()):
                values = np.atleast_1d(np.asarray(found.values, float))
                with np.errstate(divide="ignore"):
                    turns = 1 / values if name == "period" else values
                return axis, turns if name == "omega" else 2 * np.pi * turns
        raise self._wrong("no variable holds the frequencies", f"add one of {listed(_AXES[:3])}")

    def _scalar(self, name: str, default: float) -> float:
        found = self.variables.get(name)
        if found is None:
            return default
        values = np.unique(np.asarray(found.values, float))
        if len(values) != 1:
            raise self._wrong(f"`{name}` has several values", f"select one: `ds.sel({name}=..)`")
        return float(values[0])

    def _needed(self, name: str, value: float) -> float:
        if not value > 0:
            raise self._wrong(
                f"`{name}` is missing or not positive", f"add `{name}` to the dataset"
            )
        return value

    def _modes(self, name: str) -> list[int]:
        """Return the places of the six modes along an axis of degrees of freedom."""
        names = [str(t).strip() for t in np.atleast_1d(self.variables[name].values)]
        lower = [text.rpartition("__")[2].lower() for text in names]
        if sorted(lower) != sorted(MODES):
            help = "import one rigid body with `rigid_body_dofs`: " + ", ".join(MODES)
            raise self._wrong(f"`{name}` is {listed(names, 8)}", help)
        return [lower.index(mode) for mode in MODES]

    def _ordered(self, variable: Variable, wanted: tuple[str, ...], name: str) -> Any:
        """Return values with the wanted dimensions alone, modes in our order."""
        values, dimensions = variable.values, list(variable.dimensions)
        for extra in [d for d in dimensions if d not in wanted]:
            axis = dimensions.index(extra)
            if values.shape[axis] != 1:
                raise self._wrong(f"`{name}` has several values of `{extra}`", "select one")
            values = np.take(values, 0, axis=axis)
            dimensions.pop(axis)
        for absent in [d for d in wanted if d not in dimensions]:
            values = values[None]
            dimensions.insert(0, absent)
        values = np.transpose(values, [dimensions.index(d) for d in wanted])
        for axis, dimension in enumerate(wanted):
            if dimension.endswith("_dof"):
                values = np.take(values, self._modes(dimension), axis=axis)
        return values

    def _matrices(self, name: str, wanted: tuple[str, ...]) -> Real:
        return np.asarray(self._ordered(self.variables[name], wanted, name), float)

    def _optional(self, name: str) -> Real | None:
        if name not in self.variables or np.isnan(self.variables[name].values).any():
            self.account.missing(f"`{name}`")
            return None
        self.account.read(f"`{name}`")
        return self._matrices(name, ("influenced_dof", "radiating_dof"))

    def _force(self) -> Complex:
        names = ["excitation_force"]
        if names[0] not in self.variables:
            names = ["diffraction_force", "Froude_Krylov_force"]
        if any(name not in self.variables for name in [*names, "wave_direction"]):
            help = "solve `DiffractionProblem`s as well, and assemble all results"
            raise self._wrong("there are no exciting forces", help)
        return np.conj(sum((self._complex(name) for name in names), 0j))

    def _complex(self, name: str) -> Complex:
        wanted = (self.axis, "wave_direction", "influenced_dof")
        variable = self.variables[name]
        if "complex" in variable.dimensions:
            parts = self._ordered(variable, ("complex", *wanted), name)
            order = [str(text).strip() for text in np.atleast_1d(self._parts())]
            if sorted(order) != ["im", "re"]:
                raise self._wrong(f"the axis `complex` is {listed(order)}", "write `re` and `im`")
            return np.asarray(parts[order.index("re")] + 1j * parts[order.index("im")])
        return np.asarray(self._ordered(variable, wanted, name), complex)

    def _parts(self) -> Any:
        found = self.variables.get("complex")
        return ["re", "im"] if found is None else found.values

    def _point(self, name: str) -> Real | None:
        found = self.variables.get(name)
        if found is None or np.asarray(found.values).size != 3:
            return None
        return np.asarray(found.values, float).ravel()

    def _origin(self, gravity_centre: Real | None, mass: Real | None) -> Real:
        """Return the centre of rotation, given or as the mass matrix has it."""
        given = self._point("rotation_center")
        if given is not None:
            return given
        if mass is not None and gravity_centre is not None:
            x, y, z = -mass[2, 4], -mass[0, 5], mass[0, 4]
            found = gravity_centre - np.array([x, y, z]) / mass[0, 0]
            self.account.read("the centre of rotation, from the mass matrix")
            return np.asarray(found)
        help = "add `rotation_center` to the dataset, or use Capytaine 3"
        if gravity_centre is not None:
            self.account.assumed("moments are taken about the centre of mass", help)
            return gravity_centre
        self.account.assumed("moments are taken about the origin of the mesh", help)
        return np.zeros(3)
