"""The cost of located kinks: instructions a step over those of the same scene without them.

`python tests/bench/kinks.py [SCENE ..]`. Each scene is emitted twice as C, once with `abs`, `min`
and `max` left to error control, compiled by the flags of the runtime's loops but for x86-64-v3,
which callgrind knows, and run from its start by `ros34prw` in steps of 1 ms for 0.5 s. Devices stay
closed and nothing begins at rest: both programs run the same. The goal is 2 % where no kink is
crossed; at sea and with hydraulics, kinks are crossed and valves rest on theirs.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from unittest.mock import patch

import hydraulic

import bgc.library
from bgc.algebra.dag import Op
from bgc.building.build import runtime_directory
from bgc.driver import compile_scene
from bgc.emission import switches
from bgc.emission.amalgamate import public_header
from bgc.emission.emit import amalgamate_lowered
from bgc.options import Options

SCENES = Path(bgc.library.__path__[0]) / "scenes"
FLAGS = ("-O2", "-ftree-vectorize", "-fno-math-errno", "-ffp-contract=fast", "-march=x86-64-v3")
FILES = {
    "two_beam_crane": "two_beam_crane",
    "two_beam": "compare_cranes",
    "telescopic_crane": "telescopic_crane",
    "knuckle_boom": "knuckle_boom",
    "gantry": "gantry",
    "offshore_lift": "offshore_lift",
    "knuckle_boom_at_sea": "knuckle_boom_at_sea",
    "knuckle_boom_hydraulic": "knuckle_boom_hydraulic",
}
METHOD, END = "ros34prw", 0.5
SMOOTH = {op: jump for op, jump in switches._JUMPS.items() if not Op(op).row.kink}


def program(folder: Path, scene: str) -> tuple[Path, int]:
    """A program that runs a scene, and the number of its switches."""
    stages = compile_scene(SCENES / f"{FILES[scene]}.bg", Options(scene=scene), until="lower")
    text = amalgamate_lowered(stages.lowered, stages.source_hash, runtime_directory())
    folder.mkdir()
    (folder / "model.h").write_text(public_header(runtime_directory()), "utf-8")
    (folder / "model.c").write_text(text, "utf-8")
    (folder / "main.c").write_text(hydraulic.MAIN, "utf-8")
    sources = (folder / "main.c", folder / "model.c")
    made = folder / "program"
    subprocess.run(("gcc", "-std=gnu11", *FLAGS, *sources, "-o", made, "-lm"), check=True)
    return made, len(stages.lowered.switches)


def cost(made: Path) -> int:
    """Instructions of the run, without those of its start."""
    counted = [hydraulic.instructions(made, METHOD, until) for until in (END, 0.0)]
    return counted[0] - counted[1]


def main(scenes: list[str]) -> None:
    with tempfile.TemporaryDirectory() as name:
        for scene in scenes or FILES:
            located, all_switches = program(Path(name) / scene, scene)
            with patch.object(switches, "_JUMPS", SMOOTH):
                smooth, others = program(Path(name) / f"{scene}_smooth", scene)
            ratio = cost(located) / cost(smooth)
            print(
                f"{scene:24} {all_switches - others:3} kinks {100 * (ratio - 1):6.1f} %", flush=True
            )


if __name__ == "__main__":
    main(sys.argv[1:])
