"""The library's scenes with every joint rigid: what they tend to as their joints grow stiff."""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import bgc
from bgc import library
from bgc.driver import check_source, compile_scene
from bgc.ir.graph import Storage
from bgc.options import Options

SCENES = Path(library.__file__).parent / "scenes"
CRANES = SCENES / "two_beam_crane.bg"
NAMES = re.compile(r"^scene (\w+)", re.MULTILINE)


def compliant_locks(file: Path, scene: str) -> dict[str, int]:
    """The locks of a scene's joints that are springs, and how many directions each holds."""
    graph = compile_scene(file, Options(scene, whole=True), until="elaborate").graph
    springs = (e for e in graph.elements if isinstance(e, Storage) and e.kind == "C")
    return {
        e.name.removesuffix(".spring"): len(e.ports)
        for e in springs
        if e.name.endswith(".lock.spring")
    }


def with_lines(file: Path, scene: str, lines: str, folder: Path) -> Path:
    """A copy of a library file with more lines in one of its scenes."""
    text = file.read_text().replace('"../traces', f'"{file.parents[1] / "traces"}')
    text = re.sub(rf"^scene {scene} (?:of|is) .*\{{$", rf"\g<0>\n{lines}", text, flags=re.MULTILINE)
    assert lines in text
    copy = folder / f"{scene}.bg"
    copy.write_text(text)
    return copy


def rigid(locks: Mapping[str, int]) -> str:
    return "".join(f"  use {lock} = Rigid[{n}];\n" for lock, n in locks.items())


@pytest.mark.parametrize(
    ("file", "scene"),
    [
        pytest.param(file, scene, id=scene)
        for file in sorted(SCENES.glob("*.bg"))
        for scene in NAMES.findall(file.read_text())
    ],
)
def test_every_scene_has_equations_with_rigid_joints(file, scene, tmp_path):
    locks = compliant_locks(file, scene)
    if not locks:
        return  # rigid as it is, and compiled by the test of derivatives
    copy = with_lines(file, scene, rigid(locks), tmp_path)
    assert not check_source(copy, scene)
    assert not compliant_locks(copy, scene)


@pytest.mark.parametrize("scene", ["two_beam_crane", "telescopic"])
def test_stiff_joints_give_the_path_and_the_force_of_rigid_ones(scene, tmp_path):
    locks = compliant_locks(CRANES, scene)
    assert len(locks) == 4
    path = "  observe crane.tip.r as path;\n"
    runs = {"solver": "rodas5p", "rtol": 1e-8, "every": 0.1, "start": "given"}
    copy = with_lines(CRANES, scene, rigid(locks) + path, tmp_path)
    exact = bgc.compile(copy, scene=scene).simulate(10, **runs)
    assert np.ptp(exact["path"], axis=0).max() > 2, "it has to move"

    compliant = bgc.compile(with_lines(CRANES, scene, path, tmp_path), scene=scene)
    deviations = []
    for stiffness in (1e10, 1e11):
        stiff = {f"{lock}.stiffness": stiffness for lock in locks}
        result = compliant.simulate(10, **runs, parameters=stiff)
        deviations.append(np.linalg.norm(result["path"] - exact["path"], axis=1).max())
    assert deviations[0] < 1e-4
    np.testing.assert_allclose(deviations[0] / deviations[1], 10, rtol=0.01)
    # After the springs, which start unloaded, have taken the load.
    settled = result.time > 0.5
    np.testing.assert_allclose(result["force_z"][settled], exact["force_z"][settled], atol=1e-3)
