"""Any open tree on rigid joints compiles, however its mounts are written; Pinocchio agrees."""

from pathlib import Path

import numpy as np
import pytest
from model_files import model_text
from mounted_arms import NOTHING_ALIGNED, mounted_arm
from probe import Probe
from published_arms import pinocchio_model

from bgc.driver import compile_scene
from bgc.options import Options

pin = pytest.importorskip("pinocchio")

GRAVITY = 9.81
STATES = 10
OWN_JOINT = model_text("mounted_arms_own_joint")
BASES = {"ground": 5, "free": 4, "body": 4, "vessel": 103}  # base: seed
NEARLY_RIGHT = [0, 30, 45, 90, -90, 90.1, -90.1, 0.1]


def assert_compiles(arm, tmp_path: Path, until="causality"):
    file = tmp_path / "tree.bg"
    file.write_text(arm.source)
    compile_scene(file, Options("tree", whole=True), until=until)
    return file


@pytest.mark.parametrize("base", BASES)
def test_accelerations_are_those_of_pinocchio(base, tmp_path):
    arm = mounted_arm(BASES[base], 5, base)
    assert_accelerates(arm, assert_compiles(arm, tmp_path), BASES[base])


@pytest.mark.parametrize("seed", range(4))
def test_mounts_may_be_turned_by_any_angle(seed, tmp_path):
    arm = mounted_arm(seed, 4, angles=NOTHING_ALIGNED)
    assert_accelerates(arm, assert_compiles(arm, tmp_path), seed)


@pytest.mark.parametrize("seed", range(10, 15))
def test_mounts_nearly_at_right_angles_are_no_worse(seed, tmp_path):
    """A tenth of a degree off, elimination divides by numbers of 0.002."""
    arm = mounted_arm(seed, 4, angles=NEARLY_RIGHT)
    assert_accelerates(arm, assert_compiles(arm, tmp_path), seed)


def assert_accelerates(arm, file, seed):
    """Compare with Pinocchio at random states."""
    names = [
        f"v{k}" if n == 1 else f"v{k}[{i}]"
        for k, n in enumerate(arm.freedoms)
        for i in range(1, n + 1)
    ]
    tree = Probe(file, "tree", names)
    model = pinocchio_model(arm.table, GRAVITY)
    data = model.createData()
    rng = np.random.default_rng(seed)
    for _ in range(STATES):
        declared, q = {}, []
        push = np.zeros(len(names))
        for kind, states in zip(arm.kinds, arm.states, strict=True):
            match kind:
                case "turns" | "slides":
                    q.append(declared.setdefault(states[0], rng.normal()))
                    continue
                case "fixed" | "clamped":
                    continue
                case "floats":
                    place = rng.normal(size=3)
                    declared |= {f"{states[0]}[{i}]": x for i, x in enumerate(place, 1)}
                    q.extend(place)
            attitude = rng.normal(size=4)
            attitude /= np.linalg.norm(attitude)
            declared |= {f"{states[-1]}[{i}]": x for i, x in enumerate(attitude, 1)}
            q.extend(np.roll(attitude, -1))  # scalar last
            if kind == "floats":
                rotation = pin.Quaternion(*attitude).toRotationMatrix()
                push[:6] = arm.push(rotation, GRAVITY)
        v = rng.normal(size=len(names))
        exact = pin.aba(model, data, np.array(q), v, push)
        found = tree.accelerations(tree.at(declared, v))
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9 * (1 + np.abs(exact).max()))


@pytest.mark.parametrize("seed", range(24))
def test_every_tree_compiles(seed, tmp_path):
    """A third of them was refused as a closed chain."""
    assert_compiles(mounted_arm(1000 + seed, 1 + seed % 6), tmp_path)


@pytest.mark.parametrize(("seed", "bodies", "base"), [(122, 4, "body"), (156, 2, "ground")])
def test_a_quarter_turn_in_eleven_digits_is_not_divided_by(seed, bodies, base, tmp_path):
    """Its cosine, 5e-12, as a pivot gave a reduced mass that was singular up to rounding."""
    assert_compiles(mounted_arm(seed, bodies, base), tmp_path, until="equations")


def test_a_joint_without_elements_moves_as_the_librarys(tmp_path):
    """Its rate is found by the transformer that spreads it to a twist."""
    found = []
    for number, joint in enumerate(["Hinge", "Revolute(axis = x, lock = Rigid[5])"]):
        file = tmp_path / f"tree{number}.bg"
        file.write_text(OWN_JOINT.replace("a : Hinge; b : Hinge; c : Hinge;", joints_of(joint)))
        tree = Probe(file, "tree", ["v0", "v1", "v2"])
        state = tree.at({"a.angle": 0.3, "b.angle": -0.8, "c.angle": 2}, np.array([0.5, -1, 2]))
        found.append((tree.mass_matrix(state), tree.accelerations(state)))
    for own, library in zip(*found, strict=True):
        assert np.abs(library).max() > 0.1
        np.testing.assert_allclose(own, library, rtol=0, atol=1e-12 * np.abs(library).max())


def joints_of(kind: str) -> str:
    return " ".join(f"{name} : {kind};" for name in "abc")
