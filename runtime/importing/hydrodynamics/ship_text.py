"""The `.bg` text of an imported ship: the ship as parts, and a scene with a regular wave."""

from __future__ import annotations

import numpy as np

from bgc.diagnostics.source import Source
from bgc.grammar.format import format_source
from bgc.runtime.importing.hydrodynamics.headings import Arc
from bgc.runtime.importing.hydrodynamics.masses import Box, RigidBody
from bgc.runtime.importing.hydrodynamics.record import Hull
from bgc.runtime.importing.identifiers import Names
from bgc.runtime.importing.layout import bracketed
from bgc.runtime.importing.rotation_text import number

_SLACK = 0.02  # rad by which a heading may leave those of the data
_BOW = 5 / 6 * np.pi  # rad: waves from ahead of the beam, where every mode moves


def ship_text(
    hull: Hull,
    body: RigidBody,
    box: Box,
    arcs: tuple[Arc, ...],
    file: str,
    *,
    guided: bool,
    report: list[str],
) -> str:
    """Write the models of a ship and a scene; `file` is the name of its data file."""
    names = Names(("mechanics.", "marine."))
    name = names.type(hull.name)
    data = names.value(f"{hull.name}_data", "ship")
    limits = _headings(arcs)
    text = [
        "import marine.ship_in_sea;",
        "",
        f"/// Data of {_line(hull.name)}, imported from files of {hull.program}.",
        "///",
        *(f"/// - {_line(line)}" for line in report),
        f'const {data} = data("{file}");',
        "",
        "/// The ship in six degrees of freedom in a sea, with added mass and damping at `met`.",
        *_ship(name, data, body, limits),
        "",
    ]
    if guided:
        moved = names.type(f"{hull.name}_guided")
        text += [
            "/// The same ship moved by a sea as its motion responses say, whatever it carries.",
            f"model {moved}[n = 100] is ShipGuided[n](ship = {data}) {{",
            *limits,
            "}",
            "",
        ]
    cell = names.type(f"{hull.name}_in_waves")
    return format_source(
        Source(
            f"{hull.name}.bg",
            "\n".join([*text, *_scene(hull, name, cell, box, arcs, names)]) + "\n",
        )
    )


def _ship(name: str, data: str, body: RigidBody, limits: list[str]) -> list[str]:
    if not body.estimated:
        return [f"model {name}[n = 100] is ShipInSea[n](ship = {data}) {{", *limits, "}"]
    centre, radii = ([f"{number(_short(x))} m" for x in v] for v in (body.centre, body.radii))
    return [
        "/// Mass properties that the data lack are estimates: give your own.",
        f"model {name}[n = 100] is ShipInSea[n](",
        f"ship = {data},",
        "M_RB = ned*inertia_about_origin(mass, centre, mass*diag([radii[1]^2, radii[2]^2, "
        "radii[3]^2]))*ned",
        ") {",
        "/// Mass; that of the displaced water, as the other data are for its draught.",
        f"param mass : kg = {number(_short(body.mass))} kg in 1e-3 kg .. 1e12 kg;",
        "/// Centre of gravity from the origin, in the library's axes. It enters the inertia",
        "/// alone: the stiffness in roll and pitch is that of the data.",
        bracketed("param centre[3] : m = ", centre),
        "/// Radii of gyration about the centre of gravity, in roll, pitch and yaw.",
        bracketed("param radii[3] : m = ", radii),
        *limits,
        "}",
    ]


def _headings(arcs: tuple[Arc, ...]) -> list[str]:
    """Write the condition that waves come from where the data have forces."""
    if not arcs:
        return []
    parts = []
    for arc in arcs:
        first, width = number(_short(arc.first - _SLACK)), number(_short(arc.width + 2 * _SLACK))
        parts.append(f"within_turn(sea.direction[i] - angles0[3] - {first}) <= {width}")
    return [
        f"// The data have waves that travel towards {' and '.join(arc.text for arc in arcs)} deg.",
        "for i in 1..n {",
        f'assert {" or ".join(parts)}, "the data of this ship have no waves of this direction";',
        "}",
    ]


def _scene(
    hull: Hull, name: str, cell: str, box: Box, arcs: tuple[Arc, ...], names: Names
) -> list[str]:
    wanted = np.sqrt(2 * np.pi * hull.gravity / (1.5 * box.length))  # waves of 1.5 lengths
    low, high = hull.frequency[0], hull.frequency[-1]
    frequency = min(max(wanted, low), high)
    period = float(f"{2 * np.pi / frequency:.2g}")
    if not low <= 2 * np.pi / period <= high:
        period = float(2 * np.pi / frequency)
    height = float(f"{min(2.0, 2 * np.pi * hull.gravity / frequency**2 / 40):.1g}")
    heading = _BOW
    if arcs and not any((_BOW - arc.first) % (2 * np.pi) <= arc.width for arc in arcs):
        ends = [arc.first + share * arc.width for arc in arcs for share in (0, 1)]
        heading = min(ends, key=lambda end: abs((end - _BOW + np.pi) % (2 * np.pi) - np.pi))
    sea = f"RegularWave[1](height = {number(height)} m, period = {number(period)} s, "
    sea += f"heading = {np.degrees(heading % (2 * np.pi)):.4g} deg)"
    met, end = number(_short(2 * np.pi / period)), number(float(f"{12 * period:.3g}"))
    every = number(float(f"{period / 50:.1g}"))
    return [
        "/// The ship alone in a sea.",
        f"model {cell} {{",
        f"vessel : Platform = {name}[1];",
        "none : Se[6](e = zeros(6));",
        "vessel -> none;",
        "/// Roll; positive where the starboard side goes down.",
        "output roll : rad = roll_of(vessel.deck.A);",
        "/// Pitch; positive where the bow goes down.",
        "output pitch : rad = pitch_of(vessel.deck.A);",
        "}",
        "",
        "/// A regular wave from ahead of the beam; it grows from calm water.",
        f"scene {names.value(f'{hull.name}_in_a_wave', 'ship')} of {cell} {{",
        f"use vessel = {name}[1](sea = {sea}, met = {met} rad/s);",
        "observe vessel.deck.r as deck, roll in deg, pitch in deg;",
        "plot deck;",
        "plot roll, pitch;",
        f"run {end} s every {every} s;",
        "}",
    ]


def _short(value: float) -> float:
    return float(f"{value:.6g}") + 0.0


def _line(text: str) -> str:
    return " ".join(text.split())
