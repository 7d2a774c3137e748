"""A crane at rest on stiff joints sags as statics says."""

import numpy as np

GRAVITY = 9.81


def rotation_about_y(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def static_sag(stiffness: float, rotational: float) -> np.ndarray:
    """Displacement of the tip to first order: each joint gives way to the weight beyond it."""
    boom = rotation_about_y(-np.pi / 4) @ [12, 0, 0]
    jib = rotation_about_y(np.pi / 12) @ [9, 0, 0]
    joints = [np.zeros(3), np.array([0, 0, 3.0])]
    joints.append(joints[1] + boom)
    tip = joints[2] + jib
    bodies = [(6e3, np.array([0, 0, 1.5])), (8e3, joints[1] + boom / 2), (4e3, joints[2] + jib / 2)]
    sag = np.zeros(3)
    for k, joint in enumerate(joints):
        force, moment = np.zeros(3), np.zeros(3)
        for mass, centre in bodies[k:]:
            weight = np.array([0, 0, -mass * GRAVITY])
            force += weight
            moment += np.cross(centre - joint, weight)
        sag += force / stiffness + np.cross(moment / rotational, tip - joint)
    return sag


def test_sag_by_translation_and_rotation_of_the_locks(load):
    model = load("crane_sag", "sag")
    result = model.simulate()
    assert np.abs(result["twist"][-1]).max() < 1e-9, "it has to be at rest"
    sag = result["tip"][-1] - result["tip"][0]
    expected = static_sag(1e9, 1e9)
    np.testing.assert_allclose(sag[[0, 2]], expected[[0, 2]], rtol=0.01)
    assert abs(sag[1]) < 1e-12


def test_sag_by_translation_alone(load):
    result = load("crane_sag", "sag").simulate(parameters={"rotational_stiffness": 1e15})
    sag = result["tip"][-1] - result["tip"][0]
    np.testing.assert_allclose(sag[2], -(18e3 + 12e3 + 4e3) * GRAVITY / 1e9, rtol=0.01)
