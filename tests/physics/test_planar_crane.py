"""A crane that moves in its own plane is compiled as a planar one, and moves as the whole one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bgc
import bgc.library

SCENES = Path(bgc.library.__path__[0]) / "scenes" / "planar_crane.bg"

# Of 70 states: in the plane a body has 3 momenta, a hinge's lock 2 translations, a grip's lock 3
# directions; in the plane is no slew; the pose has 2 coordinates and 2 quaternion components.
COMPLIANT = {
    "vessel": 3 + 2 + 2 + 2,  # momenta, restoring, position, quaternion
    "crane.pedestal": 3,  # two translations, and the rotation that its lock holds
    "crane.post": 3,
    "crane.shoulder": 2 + 1,
    "crane.boom": 3,
    "crane.elbow": 2 + 1,
    "crane.jib": 3,
    "payload": 3 + 3,
    "handle": 2 + 2,
}


def test_the_planar_states_are_left() -> None:
    model = bgc.compile(SCENES, "planar")
    names = [state.name for state in model.states]
    found = {part: sum(n.startswith(f"{part}.") for n in names) for part in COMPLIANT}
    assert found == COMPLIANT
    assert len(names) == sum(COMPLIANT.values()) == 37
    assert len(bgc.compile(SCENES, "planar", whole=True).states) == 70


@pytest.mark.parametrize("scene", ["planar", "planar_rigid"])
def test_the_tip_moves_as_in_the_whole_model(scene: str) -> None:
    sliced, whole = (bgc.compile(SCENES, scene, whole=w) for w in (False, True))
    assert len(sliced.states) < 0.6 * len(whole.states)
    ours, theirs = sliced.simulate(6), whole.simulate(6)
    assert np.ptp(theirs["tip"][:, 2]) > 0.8, "it has to move"
    np.testing.assert_allclose(ours["tip"], theirs["tip"], atol=1e-12)
    for account in ("stored", "supplied", "dissipated"):
        name = f"energy.{account}"
        scale = np.abs(theirs[name]).max()
        np.testing.assert_allclose(ours[name], theirs[name], atol=1e-10 * scale)


def test_head_seas_leave_the_plane_alone() -> None:
    """The vessel heaves and pitches; a swell that rolls it needs all states."""
    head, quartering = "[0.5, 0, 0.01]", "[0.5, 0.02, 0.01]"
    uses = {"vessel": f"OsvInSwell(amplitude = {head})"}
    sliced, whole = (bgc.compile(SCENES, "planar", uses=uses, whole=w) for w in (False, True))
    assert len(sliced.states) == 28 and len(whole.states) == 54
    ours, theirs = sliced.simulate(4), whole.simulate(4)
    assert np.ptp(theirs["tip"][:, 0]) > 0.02, "the vessel has to pitch"
    np.testing.assert_allclose(ours["tip"], theirs["tip"], atol=1e-12)
    aside = {"vessel": f"OsvInSwell(amplitude = {quartering})"}
    assert len(bgc.compile(SCENES, "planar", uses=aside).states) > 50


def test_a_hand_to_the_side_needs_all_states(tmp_path: Path) -> None:
    text = SCENES.read_text().replace(
        "hand.position.x, 0, hand.position.z", "0, hand.position.y, 0"
    )
    trace = (SCENES.parent.parent / "traces" / "up_down_up.csv").as_posix()
    file = tmp_path / "aside.bg"
    file.write_text(text.replace("../traces/up_down_up.csv", trace))
    assert len(bgc.compile(file, "planar").states) > 65
