"""Every small part of the library between neighbours that its ports ask for.

Whatever a part is bonded to, it has to compile without warnings, run, give finite results and keep
its energy account. The campaign `library` runs the same scenes of all parts, one
by one, with parameters at and beyond the ends of their ranges.
"""

from __future__ import annotations

import numpy as np
import pytest
from library_parts import declared, parts, together

import bgc

# Parts with frames, ships, arms and cranes cost seconds each, and have tests of their own.
GROUPS = {
    "circuits and heat": ("electrical", "thermal"),
    "signals": ("control",),
    "rods, shafts and ropes": (
        "mechanics.translation mechanics.rotation mechanics.friction mechanics.coupling"
        " mechanics.actuators mechanics.lock mechanics.two_point rope.winch rope.hydraulic_winch"
    ).split(),
    "oil": (
        "hydraulics.cylinders hydraulics.lines hydraulics.machines hydraulics.restrictions"
        " hydraulics.valves hydraulics.volumes"
    ).split(),
}
FRAMES = {"TwoPoint"}
# Values at which a law once switched back and forth endlessly (BG715).
AT_A_LIMIT = {"rods, shafts and ropes": {"in_HydraulicWinch.part.integral_time": 1e-3}}


def members(group: str) -> list[str]:
    """The parts of the modules, or folders of modules, of a group."""
    chosen = []
    for name in parts():
        module = declared()[name].module
        if {module, module.split(".")[0]} & set(GROUPS[group]) and name not in FRAMES:
            chosen.append(name)
    return chosen


@pytest.mark.parametrize("group", GROUPS)
def test_parts_run_between_any_neighbours_and_keep_their_accounts(group, tmp_path):
    names = members(group)
    assert len(names) > 8
    file = tmp_path / "together.bg"
    file.write_text(together(names))
    model = bgc.compile(file)
    assert not model.warnings
    result = model.simulate()
    for column in result:
        assert np.isfinite(result[column]).all(), column
    residual = np.abs(result["energy.residual"]).max()
    assert residual <= 1e-6 * result.counts["exchanged"]
    for parameter, value in AT_A_LIMIT.get(group, {}).items():
        assert model.simulate(parameters={parameter: value}).status == "done"
