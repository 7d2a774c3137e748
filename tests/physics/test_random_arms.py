"""Random trees of bodies on rigid joints accelerate as Pinocchio's."""

import numpy as np
import pytest
from probe import Probe
from published_arms import pinocchio_model
from random_arms import random_arm

pin = pytest.importorskip("pinocchio")

GRAVITY = 9.81
STATES = 10
BODIES = 4
SEEDS = range(4)
OBLIQUE = [0, 4, 13]


@pytest.mark.parametrize("seed", SEEDS)
def test_accelerations_are_those_of_pinocchio(seed, tmp_path):
    check(random_arm(seed, BODIES), seed, tmp_path)


@pytest.mark.parametrize("seed", OBLIQUE)
def test_mounts_nearly_at_right_angles_are_no_worse(seed, tmp_path):
    """A tenth of a degree off, elimination divides by numbers of 0.002."""
    check(random_arm(seed, BODIES, angles=[0, 30, 45, 90, -90, 90.1, -90.1, 0.1]), seed, tmp_path)


def check(arm, seed, tmp_path):
    """Compare at random states."""
    file = tmp_path / "tree.bg"
    file.write_text(arm.source)
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
        for k, kind in enumerate(arm.kinds):
            place, attitude = rng.normal(size=3), rng.normal(size=4)
            attitude /= np.linalg.norm(attitude)
            match kind:
                case "turns" | "slides":
                    name = "angle" if kind == "turns" else "extension"
                    declared[f"joint{k}.{name}"] = place[0]
                    q.append(place[0])
                    continue
                case "fixed":
                    continue
                case "floats":
                    declared |= {f"joint{k}.position[{i}]": x for i, x in enumerate(place, 1)}
                    q.extend(place)
            declared |= {f"joint{k}.attitude.h[{i}]": x for i, x in enumerate(attitude, 1)}
            q.extend(np.roll(attitude, -1))  # scalar last
        v = rng.normal(size=len(names))
        exact = pin.aba(model, data, np.array(q), v, np.zeros(len(names)))
        found = tree.accelerations(tree.at(declared, v))
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-10 * np.abs(exact).max())
