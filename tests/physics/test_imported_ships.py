"""Ships imported from hydrodynamic data, in regular waves, against the programs that made them."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import bgc
from bgc.runtime.importing.hydrodynamics.account import Given
from bgc.runtime.importing.hydrodynamics.hulls import import_hull
from bgc.runtime.importing.hydrodynamics.record import rigid_transfer

HULLS = Path(__file__).parents[1] / "models" / "hulls"
MODES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
NED = np.array([1, -1, -1, 1, -1, -1.0])
G = 9.81


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """Compile the ship of a hull; its cell observes the frame of the deck."""
    folder = tmp_path_factory.mktemp("hulls")

    @cache
    def compiled(name: str, file: str) -> tuple[bgc.Model, dict]:
        found = import_hull(HULLS / file, Given(), f"{name}.json")
        (folder / f"{name}.json").write_text(found.data)
        cell, ship = re.findall(r"model (\w+) {\n  vessel : Platform = (\w+)", found.text)[0]
        scene = f"""
        scene all of {cell} {{
          use vessel = {ship}[1](sea = RegularWave[1](height = 0.0002 m));
          observe vessel.deck.r as r, vessel.deck.A as A;
          keep vessel.sea.heading, vessel.sea.period, vessel.met;
          run 100 s;
        }}
        """
        (folder / f"{name}.bg").write_text(found.text + scene)
        return bgc.compile(folder / f"{name}.bg", scene="all"), json.loads(found.data)

    return compiled


def free_motions(data: dict, w: float) -> np.ndarray:
    """Eigenvalues of the ship with added mass and damping at w: its transients decay as they do."""
    at = int(np.argmin(np.abs(np.array(data["radiation"]["frequency"]) - w)))
    mass, damping = (
        np.reshape(data["radiation"][key][at], (6, 6)) + np.array(data[more])
        for key, more in (("mass", "M_RB"), ("damping", "D"))
    )
    stiffness = np.zeros((6, 6))
    stiffness[2:5, 2:5] = data["G"]
    rates = np.block([[-damping, -stiffness], [np.eye(6), np.zeros((6, 6))]])
    rates[:6] = np.linalg.solve(mass, rates[:6])
    return np.linalg.eigvals(rates)


def amplitudes(time: np.ndarray, rows: np.ndarray, w: float, free: np.ndarray) -> np.ndarray:
    """Complex amplitudes of exp(i w t) from 40 s on, beside what decays freely."""
    late = time >= 40
    t = time[late]
    decay = np.exp(np.outer(t - 40, free))
    columns = np.column_stack([np.cos(w * t), -np.sin(w * t), decay.real, decay.imag])
    fit = np.linalg.lstsq(columns, rows[late], rcond=1e-12)[0]
    return fit[0] + 1j * fit[1]


@pytest.mark.parametrize("name", ["barge", "hemisphere", "cylinder"])
def test_motions_are_those_of_capytaine(models, name):
    """Within 0.5 % of the peak of each mode, in the time domain, at each frequency and heading.

    Capytaine's motions are about the centre of rotation, which for the barge is neither its centre
    nor in the surface, on a wave whose crest is at the origin of the mesh. A mode that hardly moves
    counts in 1e-4 m or rad for each metre.
    """
    pytest.importorskip("h5py")
    model, data = models(name, f"{name}.nc")
    known = json.loads((HULLS / f"{name}_rao.json").read_text())
    expected = np.array(known["re"]) + 1j * np.array(known["im"])
    expected = np.conj(expected)
    headings = np.radians(known["heading_deg"])
    to_point = rigid_transfer(np.array([0, 0, known["point"][2] - data["deck"][2]]))
    found = np.zeros_like(expected)
    for i, w in enumerate(known["frequency"]):
        free = free_motions(data, w)
        for j, heading in enumerate(headings):
            given = {
                "vessel.met": w,
                "vessel.sea.period": 2 * np.pi / w,
                "vessel.sea.heading": heading,
            }
            result = model.simulate(
                200, every=2 * np.pi / w / 8, parameters=given, rtol=1e-7, error=False
            )
            turn = [result[f"A[{k}]"] for k in ("3,2", "1,3", "2,1")]
            rows = np.column_stack([result["r"], *turn])
            # The world's origin is the ship's, whose crest differs from the mesh's.
            along = known["point"][0] * np.cos(heading) + known["point"][1] * np.sin(heading)
            crest = np.exp(-1j * w * w / G * along)
            found[i, j] = to_point @ amplitudes(result.time, rows, w, free) / 0.0001 * crest
    peak = np.maximum(np.abs(expected).max(axis=(0, 1)), 1e-4)
    np.testing.assert_array_less(np.abs(found - expected).max(axis=(0, 1)) / peak, 5e-3)
