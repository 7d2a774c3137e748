"""WAMIT: the numeric output files of one body, found by the stem of any one of them.

WAMIT's time dependence is exp(+i w t) and its axes are ours; the crest is at the origin of the
global axes, moments and motions are about the body's origin (XBODY). Coefficients are made without
dimensions by density, gravity and the length scale L:

    added mass rho L^k, damping rho w L^k        k = 3, 4 or 5
    exciting force rho g L^m                     m = 2 or 3
    motion 1/L^n                                 n = 0 or 1
    hydrostatic stiffness rho g L^k              k = 2, 3 or 4

Source: WAMIT User Manual 7, chapters 3, 4 and 6; `wamit.cpp` of BEMRosetta; `readWAMIT.m` of
WEC-Sim.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bgc.diagnostics.catalogue.imported import not_importable, wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.importing.hydrodynamics.account import Account, Given
from bgc.runtime.importing.hydrodynamics.number_rows import Line, rows_below_header
from bgc.runtime.importing.hydrodynamics.record import Complex, Hull, Real
from bgc.runtime.importing.hydrodynamics.wamit_setup import Setup, read_setup

ENDINGS = (".1", ".2", ".3", ".4", ".hst", ".mmx", ".out", ".gdf", ".pot")
Places = NDArray[np.intp]
Waves = tuple[Real, Real, Complex]  # first column, headings (deg), values by both and the mode
_POWER = np.add.outer([0, 0, 0, 1, 1, 1], [0, 0, 0, 1, 1, 1])
_ARM = np.array([0, 0, 0, 1, 1, 1])
_SAME = 2e-4  # relative difference within which two frequencies are one
_HELP = "ask WAMIT for it: IOPTN in the .frc file"


def read_wamit(path: Path, given: Given, account: Account) -> Hull:
    """Read the set of files with the stem of `path`.

    Raises
    ------
    BgError
        BG137 where `.1`, or `.2` and `.3`, or `.hst` are missing; BG138 for wrong rows, for several
        bodies, and for files that do not belong together.
    """
    beside = {
        file.suffix.lower(): file
        for file in sorted(path.parent.iterdir())
        if file.stem == path.stem and file.suffix.lower() in (*ENDINGS, ".cfg")
    }
    for ending, contents in ((".1", "added mass and damping"), (".hst", "hydrostatic stiffness")):
        if ending not in beside:
            what = f"{path.with_suffix(ending)} is missing: {contents}"
            raise BgError([not_importable(what, help=_HELP)])
    if not beside.keys() & {".2", ".3"}:
        what = f"{path.with_suffix('.3')} is missing, and .2 as well: exciting forces"
        raise BgError([not_importable(what, help=_HELP)])
    return _Set(path.stem, beside, given, account).hull()


class _Set:
    def __init__(self, stem: str, files: dict[str, Path], given: Given, account: Account) -> None:
        self.stem = stem
        self.files = files
        self.account = account
        self.setup: Setup = read_setup(files, given, account)
        self.length = self.setup.length
        self.weight = self.setup.density * self.setup.gravity

    def hull(self) -> Hull:
        """Assemble the record."""
        setup, length = self.setup, self.length
        stiffness = self._matrix(".hst") * self.weight * length ** (2.0 + _POWER)
        if not stiffness[2, 2] > 0:
            what = f"{self.files['.hst']} has no stiffness in heave"
            raise BgError([wrong_value(None, what, _HELP)])
        column, added, damping, limits = self._radiation()
        waves: dict[str, Waves] = {
            end: self._waves(end) for end in (".2", ".3", ".4") if end in self.files
        }
        forces = waves.get(".3") or waves[".2"]
        omega = self._frequencies(column, forces, float(stiffness[2, 2]))
        rows, places = self._common(column, forces[0])
        rows, places = rows[np.argsort(omega[rows])], places[np.argsort(omega[rows])]
        frequency = omega[rows]
        mass = setup.density * length ** (3.0 + _POWER)
        force = {
            end: m[places] * self.weight * length ** (2.0 + _ARM)
            for end, m in self._aligned(waves, forces).items()
            if end != ".4"
        }
        motion = self._aligned(waves, forces).get(".4")
        self.account.read(
            f"{', '.join(sorted(file.name for file in self.files.values()))}: "
            f"{len(frequency)} frequencies, headings: {len(forces[1])}"
        )
        zero, infinite = self._limits(limits, added[rows])
        return Hull(
            name=self.stem,
            program="WAMIT",
            density=setup.density,
            gravity=setup.gravity,
            depth=setup.depth,
            frequency=frequency,
            added_mass=added[rows] * mass,
            damping=damping[rows] * mass * frequency[:, None, None],
            added_mass_zero=None if zero is None else zero * mass,
            added_mass_infinite=None if infinite is None else infinite * mass,
            heading=np.radians(forces[1]) - setup.turn,
            force=force[".3" if ".3" in force else ".2"],
            haskind=force[".2"] if ".3" in force and ".2" in force else None,
            motion=None if motion is None else motion[places] / length**_ARM,
            origin=setup.origin,
            stiffness=stiffness,
            mass=setup.mass,
            drag=setup.drag,
            volume=setup.volume,
            centre_of_gravity=setup.centre_of_gravity,
            centre_of_buoyancy=setup.centre_of_buoyancy,
        )

    def _mode(self, line: Line, column: int) -> int:
        """Return the mode of a row, from 0; refuse more than one body."""
        mode = line.numbers[column]
        if mode not in range(1, 7):
            what = f"{mode:g} is no mode of a single rigid body: 1 to 6 are read"
            help = "run WAMIT with one body (NBODY = 1), and without generalised modes"
            raise BgError([wrong_value(line.span, what, help)])
        return int(mode) - 1

    def _matrix(self, end: str) -> Real:
        found = np.zeros((6, 6))
        for line in rows_below_header(self.files[end], (3,)):
            found[self._mode(line, 0), self._mode(line, 1)] = line.numbers[2]
        return found

    def _radiation(self) -> tuple[Real, Real, Real, dict[float, Real]]:
        """Return the first column, added mass, damping, and added mass of the limiting rows."""
        rows: dict[float, tuple[Real, Real]] = {}
        limits: dict[float, Real] = {}
        for line in rows_below_header(self.files[".1"], (4, 5)):
            first, i, j = line.numbers[0], self._mode(line, 1), self._mode(line, 2)
            if first <= 0:
                limits.setdefault(min(first, 0.0), np.zeros((6, 6)))[i, j] = line.numbers[3]
            elif len(line.numbers) == 5:
                pair = rows.setdefault(first, (np.zeros((6, 6)), np.zeros((6, 6))))
                pair[0][i, j], pair[1][i, j] = line.numbers[3:]
            else:
                what = "a row of a finite frequency has no damping"
                raise BgError([wrong_value(line.span, what, "write the file again")])
        if not rows:
            what = f"{self.files['.1']} has no finite frequencies"
            raise BgError([wrong_value(None, what, "ask WAMIT for periods above zero")])
        added, damping = (np.array([pair[k] for pair in rows.values()]) for k in (0, 1))
        return np.array(list(rows)), added, damping, limits

    def _waves(self, end: str) -> Waves:
        """Return the first column, headings (deg), and complex rows by both and the mode."""
        rows: dict[tuple[float, float], Complex] = {}
        for line in rows_below_header(self.files[end], (7,)):
            first, heading, _, _, _, re, im = line.numbers
            row = rows.setdefault((first, heading), np.zeros(6, complex))
            row[self._mode(line, 2)] = complex(re, im)
        column, headings = (list(dict.fromkeys(key[k] for key in rows)) for k in (0, 1))
        lacking = [(w, b) for w in column for b in headings if (w, b) not in rows]
        if lacking:
            what = "{} has no row for {:g} at {:g} deg".format(self.files[end], *lacking[0])
            raise BgError([wrong_value(None, what, "write the file again")])
        values = np.array([[rows[w, b] for b in headings] for w in column])
        return np.array(column), np.array(headings), values

    def _aligned(self, waves: dict[str, Waves], forces: Waves) -> dict[str, Complex]:
        """Return the rows of all files, which have to have the periods and headings of one."""
        for end, (column, headings, _) in waves.items():
            if not (np.array_equal(column, forces[0]) and np.array_equal(headings, forces[1])):
                what = f"{self.files[end]} has other periods or headings than the exciting forces"
                raise BgError([wrong_value(None, what, "take files of one run")])
        return {end: values for end, (_, _, values) in waves.items()}

    def _common(self, column: Real, other: Real) -> tuple[Places, Places]:
        """Return the places of frequencies that both columns have."""
        near = np.abs(column[:, None] / other - 1) < _SAME
        rows, places = np.nonzero(near)
        if len(rows) == 0:
            what = f"{self.stem}: exciting forces and added mass have no frequency in common"
            raise BgError([wrong_value(None, what, "take files of one run")])
        if len(rows) < max(len(column), len(other)):
            self.account.missing("exciting forces or added mass at some frequencies, left out")
        return rows, places

    def _frequencies(self, column: Real, forces: Waves, stiffness: float) -> Real:
        """Return circular frequencies for the first column, whose meaning is IPEROUT."""
        meaning, gravity = self.setup.first_column, self.setup.gravity
        if meaning is None:
            # A long wave lifts the hull as still water does; a short one hardly lifts it.
            heave = np.abs(forces[2][:, :, 2]).mean(axis=1) * self.weight * self.length**2
            ends = np.argmin(forces[0]), np.argmax(forces[0])
            off = [abs(heave[end] / stiffness - 1) for end in ends]
            meaning = 2 if off[0] < off[1] else 1
            name = {1: "periods in s", 2: "circular frequencies in rad/s"}[meaning]
            self.account.read(f"the first column as {name}, as the heave force has it")
        match meaning:
            case 1:
                return np.asarray(2 * np.pi / column)
            case 2:
                return column
            case 3:
                return np.asarray(np.sqrt(column * gravity / self.length))
            case _:
                depth = self.setup.depth
                k = column / self.length
                return np.asarray(np.sqrt(gravity * k * np.tanh(np.minimum(k * depth, 50.0))))

    def _limits(self, limits: dict[float, Real], added: Real) -> tuple[Real | None, Real | None]:
        """Tell the rows of zero and infinite frequency apart by the added mass beside them."""
        below = next((m for first, m in limits.items() if first < 0), None)
        at_zero = limits.get(0.0)
        if below is None or at_zero is None:
            return below, at_zero  # a negative period is infinite, a period of zero is zero
        straight = np.abs(below - added[0]).sum() + np.abs(at_zero - added[-1]).sum()
        crossed = np.abs(at_zero - added[0]).sum() + np.abs(below - added[-1]).sum()
        return (below, at_zero) if straight <= crossed else (at_zero, below)
