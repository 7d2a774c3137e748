"""Pages of the site with figures: benchmarks from recorded numbers, and the paper's figures."""

from __future__ import annotations

import sys
from pathlib import Path

from modules import file_of, picture_of
from pages import Page

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "bench"))

from curves_page import page, read_points

# Figures of the paper: number, subject, and the part of the library that stands for it here.
_PAPER = (
    ("2", "a rigid body", "mechanics.body.RigidBody"),
    ("4", "a rigid beam", "crane.beam.Beam"),
    ("5", "a spherical joint", "mechanics.joints.Spherical"),
    ("7", "a kinematic typology, two beams that slew", "crane.kinematics.Slew2R"),
    ("8", "a vessel", "marine.vessel.Vessel"),
    ("9", "the two-beam crane", "crane.two_beam.TwoBeamCrane"),
)


def benchmarks(docs: Path, recorded: Path) -> list[Page]:
    """Draw each figure of the recorded points, with the numbers below it."""
    lines = page(read_points(recorded), docs / "benchmarks", "benchmarks/")
    return [Page("benchmarks.md", "Benchmarks", "", lines)]


def paper() -> list[Page]:
    """Show the counterparts of the paper's figures: drawings of the library and plots of a run."""
    lines = [
        "# Figures of the paper",
        "",
        "Sanfilippo, Hildre, Aesoey, Zhang and Pedersen, *Flexible modeling and simulation "
        "architecture for haptic control of maritime cranes and robotic arms* (2013), and the "
        "counterparts of its figures here. Bond graphs are drawn by bgc from the models.",
        "",
    ]
    for number, subject, name in _PAPER:
        module, _, part = name.rpartition(".")
        lines += [f"## Fig. {number}: {subject}", ""]
        lines += [f"[{name}](library/{file_of(module)}#{part})", ""]
        lines += [f'<img alt="Bond graph of {name}" src="{picture_of(name)}">', ""]
    lines += [
        "## Fig. 11 and 12: the operator lifts a load",
        "",
        "Above: the height of the tip follows the operator's hand (Fig. 11). Below: the force in "
        "the hand against the elevation of the tip (Fig. 12).",
        "",
        "```sh",
        "bgc run library/scenes/two_beam_crane.bg --plot crane.png",
        "```",
        "",
        "![Tip height and force](.assets/two_beam_crane.png)",
        "",
    ]
    return [Page("paper.md", "Figures of the paper", "paper.md", lines)]
