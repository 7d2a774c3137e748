"""The data file of a ship: JSON in SI units and NED body axes about an origin in the surface."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from bgc.runtime.importing.hydrodynamics.masses import Box
from bgc.runtime.importing.hydrodynamics.record import MODES, Complex, Hull, Real
from bgc.runtime.importing.rotation_text import number

NED = np.array([1, -1, -1, 1, -1, -1.0])
_DIGITS = 8


def ship_data(hull: Hull, mass: Real, motion: Complex | None, box: Box, report: list[str]) -> str:
    """Write the data of a hull about its origin, in the schema of `marine.ship_in_sea`.

    Parameters
    ----------
    hull
        Symmetric data about a point in the surface, where the crest is as well; ascending headings.
    mass
        (6, 6) mass matrix about the same point.
    motion
        Motions on a wave, (n, m, 6); None leaves them out.
    box
        Dimensions for pictures and wind.
    report
        Lines of the account of the import.
    """
    ned = np.outer(NED, NED)
    assert hull.stiffness is not None
    upright = slice(2, 5)
    x, y, _ = hull.origin
    heading = (-hull.heading) % (2 * np.pi)
    order = np.argsort(heading)
    turned = heading[order]
    before = turned[-1:] - 2 * np.pi if turned[0] > 0 else np.empty(0)
    columns = np.concatenate([order[-1:], order, order[:1]])[1 - len(before) :]
    response: dict[str, Any] = {
        "about": "Motion and force on a wave of 1 m: see the module marine.response.",
        "point [m]": [0, 0, 0],
        "frequency": hull.frequency,
        "heading": np.concatenate([before, turned, turned[:1] + 2 * np.pi]),
    }
    if motion is not None:
        response["motion"] = _table(motion[:, columns])
    response["force"] = _table(hull.force[:, columns])
    radiation = {
        "about": "Added mass and damping at each frequency (rad/s), the matrix by rows.",
        "frequency": hull.frequency,
        "mass": (ned * hull.added_mass).reshape(-1, 36),
        "damping": (ned * hull.damping).reshape(-1, 36),
    }
    about = "NED body axes (x forward, y starboard, z down) about the origin, which is the point "
    data = {
        "about": f"{about}({x:g}, {y:g}, 0) m of the program's axes, in the surface; SI.",
        "source": f"{hull.name}, data of {hull.program}",
        "import": "; ".join(report),
        "length [m]": box.length,
        "breadth [m]": box.breadth,
        "draught [m]": box.draught,
        "about_deck": "Not in the data: half a draught above the origin.",
        "deck": [0, 0, box.draught / 2],
        "M_RB": ned * mass,
        "G": (ned * hull.stiffness)[upright, upright],
        "about_D": "Damping of other causes than waves.",
        "D": np.zeros((6, 6)) if hull.drag is None else ned * hull.drag,
        "radiation": radiation,
        "response": response,
    }
    return _text(data) + "\n"


def _table(values: Complex) -> dict[str, dict[str, Real]]:
    turned = values * NED
    return {
        mode: {"re": turned[:, :, k].real, "im": turned[:, :, k].imag}
        for k, mode in enumerate(MODES)
    }


def _text(value: Any, indent: str = "") -> str:
    """Write JSON with a line for each entry and for each row of a matrix."""
    if isinstance(value, dict):
        inner = f",\n{indent} ".join(
            f"{json.dumps(key)}: {_text(item, indent + ' ')}" for key, item in value.items()
        )
        return f"{{\n{indent} {inner}\n{indent}}}"
    if isinstance(value, np.ndarray):
        if value.ndim > 1:
            rows = f",\n{indent} ".join(_text(row) for row in value)
            return f"[\n{indent} {rows}\n{indent}]"
        return _text(value.tolist())
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, float):
        return number(float(f"{value:.{_DIGITS}g}"))
    return json.dumps(value, ensure_ascii=False)
