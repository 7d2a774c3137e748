"""Nemoh 2 and 3: the folder of one body, found from any one of its files.

Nemoh's time dependence is exp(-i w t), so that phases change their sign; its axes are ours. The
crest is at XEFF, YEFF of Nemoh.cal, moments are about the point of the rotations there. KH.dat is
about the vertical through the centre of gravity, and includes the weight. Source: Nemoh's programs
Mesh and hydrosCal; `nemoh.cpp` of BEMRosetta; `readNEMOH.m` of WEC-Sim. Capytaine writes these
files, too: with names of modes in place of zones, angles in radians, and KH.dat about the centre
of rotation.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from bgc.diagnostics.catalogue.imported import not_importable, wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass, field
from bgc.runtime.importing.hydrodynamics.account import Account, Given
from bgc.runtime.importing.hydrodynamics.number_rows import (
    Line,
    leading_numbers,
    read_lines,
)
from bgc.runtime.importing.hydrodynamics.record import Complex, Hull, Real, rigid_transfer

ENDINGS = (".cal", ".tec", ".dat")
_ANGLE = re.compile(r"(?:beta|angle)\s*=\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)", re.IGNORECASE)
_EQUALS = re.compile(r"=\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)")


@dataclass(frozen=True, slots=True)
class _Control:
    """The contents of Nemoh.cal; depth is infinite for 0 there."""

    density: float
    gravity: float
    depth: float
    crest: tuple[float, float]
    point: Real


@dataclass(slots=True)
class _Zone:
    """A header, and the rows of numbers below it."""

    title: Line
    rows: list[tuple[float, ...]] = field(default_factory=list)


def read_nemoh(path: Path, given: Given, account: Account) -> Hull:
    """Read the folder of Nemoh.cal, which holds `path` or a folder with it.

    Raises
    ------
    BgError
        BG137 where Nemoh.cal or a file of results is missing; BG138 for wrong contents and for
        several bodies.
    """
    folder = next((f for f in path.absolute().parents[:2] if _find(f, "nemoh.cal")), None)
    if folder is None:
        what = f"there is no Nemoh.cal beside {path} or one folder above"
        raise BgError([not_importable(what, help="name a file of a folder of Nemoh")])
    return _Folder(folder, given, account).hull()


def _find(folder: Path, name: str) -> Path | None:
    """Return a file in a folder or one below: by its name, or else in any letters."""
    inner = sorted(f for f in folder.iterdir() if f.is_dir())
    files = [file for place in (folder, *inner) for file in sorted(place.iterdir())]
    near = [file for file in files if file.name.lower() == name.lower() and file.is_file()]
    return next((file for file in near if file.name == name), near[0] if near else None)


class _Folder:
    def __init__(self, folder: Path, given: Given, account: Account) -> None:
        self.folder = folder
        self.account = account
        self.found: list[str] = []
        self.control = _control(self._lines("Nemoh.cal"))
        self.density = given.density or self.control.density

    def hull(self) -> Hull:
        """Assemble the record."""
        omega, added, damping = self._radiation()
        heading, force = self._force(omega)
        order = np.argsort(omega)
        stiffness, gravity_centre, buoyancy, volume = self._hydrostatics()
        mass, drag = self._matrix("Inertia.dat"), self._matrix("Badd.dat")
        mooring = self._matrix("Km.dat")
        if mooring is not None and mooring.any():
            self.account.missing("stiffness of Km.dat, left out: moor the ship")
        if mass is None or not mass.any():
            self.account.missing("mass matrix (Mechanics/Inertia.dat of Nemoh 3)")
            mass = None
        self.account.read(
            f"{', '.join(self.found)}: {len(omega)} frequencies, headings: {len(heading)}"
        )
        return Hull(
            name=self.folder.name or "hull",
            program="Nemoh",
            density=self.density,
            gravity=self.control.gravity,
            depth=self.control.depth,
            crest=self.control.crest,
            frequency=omega[order],
            added_mass=added[order],
            damping=damping[order],
            heading=heading,
            force=force[order],
            origin=self.control.point,
            stiffness=stiffness,
            mass=mass,
            drag=drag if drag is not None and drag.any() else None,
            volume=volume,
            centre_of_gravity=gravity_centre,
            centre_of_buoyancy=buoyancy,
        )

    def _lines(self, name: str, needed: bool = True) -> list[Line]:
        file = _find(self.folder, name)
        if file is None:
            if needed:
                what = f"{self.folder / name} is missing, also in the folders below"
                raise BgError([not_importable(what, help="run Nemoh, and its mesh program")])
            return []
        self.found.append(file.name)
        return read_lines(file)

    def _zones(self, name: str) -> tuple[list[_Zone], str]:
        """Return the zones of a file of results, and the unit of its first column."""
        zones: list[_Zone] = []
        unit, last = "rad/s", None
        for line in self._lines(name):
            if found := re.search(r'VARIABLES="\w+ \((rad/s|Hz|s)\)', line.text):
                unit = found[1]
            if not line.numbers:
                last = line
                continue
            if last is not None:
                zones.append(_Zone(last))
                last = None
            if len(line.numbers) != 13 or not zones:
                what = f"a row of {len(line.numbers)} numbers where 13 are due: one body, six modes"
                help = "run Nemoh with one body and its six rigid modes"
                raise BgError([wrong_value(line.span, what, help)])
            zones[-1].rows.append(line.numbers)
        return zones, unit

    def _radiation(self) -> tuple[Real, Real, Real]:
        zones, unit = self._zones("RadiationCoefficients.tec")
        if len(zones) != 6 or len({len(zone.rows) for zone in zones}) != 1:
            what = (
                f"RadiationCoefficients.tec has {len(zones)} zones of equal length, and 6 are due"
            )
            raise BgError([wrong_value(None, what, "run Nemoh with one body and six rigid modes")])
        table = np.array([zone.rows for zone in zones])  # motion, frequency, column
        added, damping = (table[:, :, k::2].transpose(1, 2, 0) for k in (1, 2))
        return _omega(table[0, :, 0], unit), added, damping

    def _force(self, omega: Real) -> tuple[Real, Complex]:
        zones, unit = self._zones("ExcitationForce.tec")
        headings, tables = [], []
        for zone in zones:
            found = _ANGLE.search(zone.title.text)
            if found is None:
                what = "this zone has no heading"
                raise BgError([wrong_value(zone.title.span, what, "write `beta = ..`")])
            radians = zone.title.text.lstrip().startswith("angle")
            headings.append(float(found[1]) if radians else np.radians(float(found[1])))
            table = np.array(zone.rows)
            if table.shape[0] != len(omega) or not np.allclose(
                _omega(table[:, 0], unit), omega, rtol=1e-4
            ):
                what = "this zone has other frequencies than RadiationCoefficients.tec"
                raise BgError([wrong_value(zone.title.span, what, "take files of one run")])
            tables.append(table[:, 1::2] * np.exp(-1j * table[:, 2::2]))
        if not tables:
            what = "ExcitationForce.tec has no zones"
            raise BgError([wrong_value(None, what, "run Nemoh with wave directions")])
        return np.array(headings), np.stack(tables, axis=1, dtype=complex)

    def _matrix(self, name: str) -> Real | None:
        rows = [line for line in self._lines(name, needed=False) if line.text.strip()]
        if not rows:
            return None
        if len(rows) != 6 or any(len(line.numbers) != 6 for line in rows):
            what = f"{name} is no matrix of 6 x 6 numbers"
            raise BgError([wrong_value(rows[0].span, what, "write the file again")])
        return np.array([line.numbers for line in rows])

    def _hydrostatics(self) -> tuple[Real | None, Real | None, Real | None, float | None]:
        """Return stiffness about the point of the motions, centres, and volume."""
        lines = self._lines("Hydrostatics.dat", needed=False)
        pairs = [[float(x) for x in _EQUALS.findall(line.text)] for line in lines]
        centres = gravity_centre = None
        volume = None
        if len(pairs) >= 4 and all(len(pair) == 2 for pair in pairs[:3]) and pairs[3]:
            centres, gravity_centre = (np.array([pair[k] for pair in pairs[:3]]) for k in (0, 1))
            volume = pairs[3][0]
        else:
            self.account.missing("centres and volume (Hydrostatics.dat)")
        stiffness = self._matrix("KH.dat")
        about = self.control.point
        by_capytaine = len(lines) > 1 and lines[1].text.lstrip().startswith("XF")
        if gravity_centre is not None and not by_capytaine:
            about = gravity_centre
        if stiffness is None:
            stiffness, about = self._matrix("Kh.dat"), self.control.point
        if stiffness is not None:
            t = rigid_transfer(about - self.control.point)
            stiffness = t.T @ stiffness @ t
        return stiffness, gravity_centre, centres, volume


def _omega(column: Real, unit: str) -> Real:
    if unit == "Hz":
        return 2 * np.pi * column
    return column if unit == "rad/s" else np.asarray(2 * np.pi / column)


def _control(lines: list[Line]) -> _Control:
    """Read the environment and the six motions of one body; other lines do not matter here."""
    try:
        density, gravity, depth = (leading_numbers(line.text)[0] for line in lines[1:4])
        crest = leading_numbers(lines[4].text)
        bodies = leading_numbers(lines[6].text)[0]
        modes = leading_numbers(lines[10].text)[0]
        rows = [leading_numbers(line.text) for line in lines[11:17]]
        kinds = [row[0] for row in rows]
        points = {row[4:7] for row in rows if row[0] == 2}
        axes = [row[1:4] for row in rows]
        x_y = (crest[0], crest[1])
    except (IndexError, ValueError):
        what = "this is not Nemoh.cal: numbers are missing"
        span = lines[0].span if lines else None
        raise BgError([wrong_value(span, what, "write it as Nemoh's manual says")]) from None
    if bodies != 1:
        what = f"the folder has {bodies:g} bodies"
        raise BgError([wrong_value(lines[6].span, what, "run Nemoh with one body")])
    unit_axes = [tuple(row) for row in np.eye(3)] * 2
    if modes != 6 or kinds != [1, 1, 1, 2, 2, 2] or axes != unit_axes or len(points) != 1:
        what = "the motions are not surge, sway, heave, and three rotations about one point"
        help = "run Nemoh with the six rigid modes in this order"
        raise BgError([wrong_value(lines[10].span, what, help)])
    return _Control(density, gravity, depth or np.inf, x_y, np.array(points.pop()))
