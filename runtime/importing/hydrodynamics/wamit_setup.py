"""The contents of WAMIT's files beside the coefficients: scales, the body's place, and its mass."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from bgc.diagnostics.catalogue.imported import wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.importing.hydrodynamics.account import Account, Given
from bgc.runtime.importing.hydrodynamics.number_rows import Line, leading_numbers, read_lines
from bgc.runtime.importing.hydrodynamics.record import Real

_SEAWATER = 1025.0  # kg/m^3
_HELP_DENSITY = "give it with `--density`"
_HELP_LENGTH = "give it with `--length-scale`, or add the .gdf, .mmx or .out file"
_NUMBER = r"([+-]?[\d.]+(?:[eEdD][+-]?\d+)?)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """Scales, place and mass of a body.

    `origin` is XBODY in axes that are turned with the body by `turn` (rad) about the global z axis;
    `first_column` is IPEROUT of the numeric files, None where no file tells it.
    """

    density: float
    gravity: float
    length: float
    depth: float
    origin: Real
    turn: float
    first_column: int | None
    mass: Real | None = None
    drag: Real | None = None
    volume: float | None = None
    centre_of_gravity: Real | None = None
    centre_of_buoyancy: Real | None = None


def read_setup(files: dict[str, Path], given: Given, account: Account) -> Setup:
    """Read `.out`, `.mmx`, `.gdf`, `.pot` and `.cfg`, as far as they are there."""
    kinds = (".out", ".mmx", ".pot", ".cfg")
    texts: dict[str, list[Line]] = {end: read_lines(files[end]) for end in kinds if end in files}
    printed = [line for end in (".out", ".mmx") for line in texts.get(end, [])]
    density = given.density or _after(printed, r"Water density:\s*")
    if density is None:
        density = _SEAWATER
        account.assumed(f"a density of the water of {density:g} kg/m^3", _HELP_DENSITY)
    gravity, length = _after(printed, r"Gravity:\s*"), _after(printed, r"Length scale:\s*")
    mesh = _mesh(files, texts)
    if mesh is not None:
        length, gravity = length or mesh[0], gravity or mesh[1]
    length = given.length_scale or length
    if length is None:
        length = 1.0
        account.assumed("a length scale of 1 m", _HELP_LENGTH)
    if gravity is None:
        gravity = 9.81
        account.assumed("a gravity of 9.81 m/s^2", "add the .gdf, .mmx or .out file")
    place, depth = _place(texts, account)
    turn = float(np.radians(place[3]))
    c, s = np.cos(turn), np.sin(turn)
    origin = np.array([c * place[0] + s * place[1], c * place[1] - s * place[0], place[2]])
    gravity_centre = _point(printed, "Gravity")
    buoyancy = _point(printed, "Buoyancy")
    volumes = next((line.text for line in printed if "Volumes (VOLX" in line.text), "")
    mass, drag = _mass(texts.get(".mmx", []), density, account)
    return Setup(
        density=density,
        gravity=gravity,
        length=length,
        depth=depth,
        origin=origin,
        turn=turn,
        first_column=_first_column(texts.get(".cfg")),
        mass=mass,
        drag=drag,
        volume=float(np.median(leading_numbers(volumes.partition(":")[2]))) if volumes else None,
        centre_of_gravity=None if gravity_centre is None else origin + gravity_centre,
        centre_of_buoyancy=None if buoyancy is None else origin + buoyancy,
    )


def _after(lines: list[Line], pattern: str) -> float | None:
    for line in lines:
        if found := re.search(pattern + _NUMBER, line.text):
            return float(found[1].lower().replace("d", "e"))
    return None


def _point(lines: list[Line], kind: str) -> Real | None:
    for line in lines:
        if found := re.search(rf"Center of {kind}\s*:?\s*\([^)]*\):?(.*)", line.text):
            numbers = leading_numbers(found[1])
            return np.array(numbers[:3]) if len(numbers) >= 3 else None
    return None


def _mesh(files: dict[str, Path], texts: dict[str, list[Line]]) -> tuple[float, float] | None:
    """Return ULEN and GRAV of the geometry, by the name in `.pot` where it has another one."""
    file = files.get(".gdf")
    if file is None and ".pot" in texts:
        named = [line.text.split()[0] for line in texts[".pot"] if ".gdf" in line.text.lower()]
        folder = files[".pot"].parent
        file = next((folder / n for n in named if (folder / n).is_file()), None)
    if file is None:
        return None
    with file.open(encoding="latin-1") as stream:  # panels need not be read
        stream.readline()
        numbers = leading_numbers(stream.readline())
    if len(numbers) < 2 or min(numbers) <= 0:
        what = f"{file}: the second line has no length scale and gravity"
        raise BgError([wrong_value(None, what, "correct it: `ULEN GRAV`")])
    return numbers[0], numbers[1]


def _place(texts: dict[str, list[Line]], account: Account) -> tuple[Real, float]:
    """Return XBODY(1..4) (m, deg), and the depth."""
    named = r"([XYZ]|PHI)BODY\s*=\s*" + _NUMBER
    bodies = [dict(re.findall(named, line.text)) for line in texts.get(".out", [])]
    bodies = [body for body in bodies if body]
    if bodies:
        _one_body(len(bodies))
        printed = next((x.text for x in texts[".out"] if "Water depth:" in x.text), "infinite")
        depth = re.search(r"Water depth:\s*" + _NUMBER, printed)
        place = np.array([float(bodies[0].get(key, 0)) for key in ("X", "Y", "Z", "PHI")])
        return place, float(depth[1]) if depth else np.inf
    if ".pot" in texts:
        return _potential_control(texts[".pot"])
    help = "add the .pot or .out file"
    account.assumed("moments about the origin in the surface, on deep water", help)
    return np.zeros(4), np.inf


def _potential_control(lines: list[Line]) -> tuple[Real, float]:
    """Read XBODY and HBOT of a `.pot` file: the line below the name of the geometry."""
    depth = leading_numbers(lines[1].text) if len(lines) > 1 else ()
    for above, line in pairwise(lines):
        numbers = leading_numbers(line.text)
        if ".gdf" in above.text.lower() and len(numbers) >= 4 and above is not lines[0]:
            return np.array(numbers[:4]), depth[0] if depth and depth[0] > 0 else np.inf
    what = "there is no XBODY below the name of a geometry"
    span = lines[0].span if lines else None
    raise BgError([wrong_value(span, what, "correct the .pot file, or remove it")])


def _one_body(count: int) -> None:
    if count != 1:
        what = f"the files hold {count} bodies"
        raise BgError([wrong_value(None, what, "run WAMIT with one body (NBODY = 1)")])


def _first_column(lines: list[Line] | None) -> int | None:
    """Return IPEROUT of a `.cfg` file, 1 where it stands nowhere."""
    if lines is None:
        return None
    found = [re.match(r"\s*IPER(?:OUT|IO)\s*=\s*([1-4])", line.text) for line in lines]
    return next((int(match[1]) for match in found if match), 1)


def _mass(lines: list[Line], density: float, account: Account) -> tuple[Real | None, Real | None]:
    """Return mass and external damping of an `.mmx` file: by density, or with dimensions."""
    if not lines:
        account.missing("mass properties (.mmx)")
        return None, None
    normalised = any("Normalized mass" in line.text for line in lines)
    _one_body(sum("puts for body N" in line.text for line in lines) or 1)
    columns = np.zeros((3, 6, 6))
    for line in lines:
        if len(line.numbers) in (3, 5) and max(line.numbers[:2]) <= 6:
            i, j = int(line.numbers[0]) - 1, int(line.numbers[1]) - 1
            values = line.numbers[2:]
            columns[: len(values), i, j] = values
    mass, drag, stiffness = columns
    if stiffness.any():
        account.missing("external stiffness of .mmx, left out: moor the ship")
    if np.diagonal(mass)[3:].min() <= 0:
        account.missing("moments of inertia: those of .mmx are zero")
    return mass * (density if normalised else 1.0), drag if drag.any() else None
