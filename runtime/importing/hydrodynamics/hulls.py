"""`import_hull`: hydrodynamic data of a program as a ship, its data file, and a report."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from bgc.diagnostics.catalogue.imported import wrong_value
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.record_class import dataclass
from bgc.runtime.importing.hydrodynamics.account import Account, Given
from bgc.runtime.importing.hydrodynamics.bemio import ENDINGS as BEMIO_FILES
from bgc.runtime.importing.hydrodynamics.bemio import read_bemio
from bgc.runtime.importing.hydrodynamics.capytaine import read_capytaine
from bgc.runtime.importing.hydrodynamics.checks import check, scales
from bgc.runtime.importing.hydrodynamics.headings import around, covered
from bgc.runtime.importing.hydrodynamics.masses import box_of, rigid_body
from bgc.runtime.importing.hydrodynamics.nemoh import ENDINGS as NEMOH_FILES
from bgc.runtime.importing.hydrodynamics.nemoh import read_nemoh
from bgc.runtime.importing.hydrodynamics.record import Hull, motions, moved, symmetrised
from bgc.runtime.importing.hydrodynamics.ship_data import ship_data
from bgc.runtime.importing.hydrodynamics.ship_text import ship_text
from bgc.runtime.importing.hydrodynamics.wamit import ENDINGS as WAMIT_FILES
from bgc.runtime.importing.hydrodynamics.wamit import read_wamit

Reader = Callable[[Path, Given, Account], Hull]

READERS: dict[str, Reader] = {
    ".nc": read_capytaine,
    **dict.fromkeys(WAMIT_FILES, read_wamit),
    **dict.fromkeys(NEMOH_FILES, read_nemoh),
    **dict.fromkeys(BEMIO_FILES, read_bemio),
}
"""Readers by the ending of a file's name, in lower case."""


@dataclass(frozen=True, slots=True)
class ImportedHull:
    """The `.bg` text, the text of the data file, the report, and the warnings."""

    text: str
    data: str
    report: tuple[str, ...]
    warnings: tuple[Diagnostic, ...]


def import_hull(path: Path, given: Given, data_file: str) -> ImportedHull:
    """Convert hydrodynamic data to a ship whose data file is to have the name `data_file`.

    Raises
    ------
    BgError
        BG137 for a file of another kind, BG138 for missing or wrong contents, and BG058 where the
        package that reads it is missing.
    """
    account = Account()
    hull = READERS[path.suffix.lower()](path, given, account)
    _verify(path, hull)
    if np.isfinite(hull.depth):
        what = f"seas on deep water, while the data are for a depth of {hull.depth:g} m"
        account.assumed(what, "take waves shorter than twice the depth")
    origin = np.array([hull.origin[0], hull.origin[1], 0.0])
    hull = around(moved(hull, origin), account)
    check(hull, account)
    hull = symmetrised(hull)
    body = rigid_body(hull, account)
    box = box_of(hull, body.mass)
    _note_rest(hull, account)
    arcs = covered(hull)
    if arcs:
        ranges = " and ".join(arc.text for arc in arcs)
        help = "compute the other headings; the ship refuses waves from there"
        account.assumed(f"waves that travel towards {ranges} deg only, as the data have", help)
    mass = body.matrix if hull.mass is None or body.estimated else hull.mass
    motion = hull.motion
    if motion is None and not body.estimated:
        assert hull.stiffness is not None
        motion = motions(hull, mass, hull.stiffness)
    report = account.lines()
    guided = motion is not None
    text = ship_text(hull, body, box, arcs, data_file, guided=guided, report=report)
    data = ship_data(hull, mass, motion, box, report)
    return ImportedHull(text, data, tuple(report), tuple(account.warnings))


def _verify(path: Path, hull: Hull) -> None:
    """Refuse values that are no numbers, and data without a hydrostatic stiffness."""
    arrays = (hull.frequency, hull.added_mass, hull.damping, hull.heading, hull.force, hull.origin)
    optional = (hull.mass, hull.stiffness, hull.motion, hull.haskind, hull.drag)
    if not all(np.isfinite(m).all() for m in (*arrays, *(m for m in optional if m is not None))):
        help = "compute the missing entries, or leave out their frequencies"
        raise BgError([wrong_value(None, f"{path}: entries are missing or no numbers", help)])
    if len(hull.frequency) < 2:
        help = "compute at least two frequencies"
        raise BgError([wrong_value(None, f"{path}: there is one frequency only", help)])
    if hull.stiffness is None or not hull.stiffness[2, 2] > 0:
        what = f"{path}: there is no hydrostatic stiffness in heave"
        help = "add the hydrostatics to the data: each program writes them on demand"
        raise BgError([wrong_value(None, what, help)])


def _note_rest(hull: Hull, account: Account) -> None:
    """Tell what has no counterpart in the ship."""
    assert hull.stiffness is not None
    scaled = np.abs(hull.stiffness) / np.outer(scales(hull), scales(hull))
    other = np.ones((6, 6), bool)
    other[2:5, 2:5] = False
    if scaled[other].max() > 1e-3 * scaled.max():
        what = "the ship has no stiffness in surge, sway and yaw: that of the data is left out"
        account.assumed(what, "moor it: `ShipInWeather` has a slot `keeping`")
    if hull.added_mass_infinite is None:
        account.missing("added mass at infinite frequency: not needed without fluid memory")
