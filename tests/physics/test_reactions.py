"""Loads of rigid joints: rates of merged momenta, against Newton's law and MuJoCo."""

import mujoco
import numpy as np

GRAVITY = 9.81


def test_a_pendulum_hangs_on_its_pivot(load):
    """Newton's law of the bar's centre, in the axes of the ground."""
    result = load("reactions", "pendulum").simulate()
    angle, rate = result["angle"], result["rate"]
    mass, arm = 10.0, 1.0
    about_pivot = mass * (2**2 + 0.1**2) / 12 + mass * arm**2
    turning = mass * GRAVITY * arm * np.cos(angle) / about_pivot
    along = np.stack([np.cos(angle), 0 * angle, -np.sin(angle)], axis=1)
    across = np.stack([-np.sin(angle), 0 * angle, -np.cos(angle)], axis=1)
    acceleration = arm * (turning[:, None] * across - rate[:, None] ** 2 * along)
    force = mass * (acceleration + np.array([0, 0, GRAVITY]))
    assert np.ptp(force[:, 2]) > 100, "the bar has to swing"
    np.testing.assert_allclose(result["reaction"][:, :3], force, atol=1e-6)
    np.testing.assert_allclose(result["reaction"][:, 3:], 0, atol=1e-6)


def basis(axis):
    """Two axes across a unit vector, as the library's `basis` chooses them."""
    x, y, z = axis
    s = -1.0 if z < 0 else 1.0
    k = -1 / (s + z)
    return np.array([[1 + s * k * x * x, s * k * x * y, -s * x], [k * x * y, s + k * y * y, -y]])


JOINTS = {"slew": (0.0, 0, 1), "luff": (0.0, -1, 0), "twist": (1.0, 0, 0)}


def bar(mass, length, side, axis):
    """MuJoCo's inertial element of a uniform bar."""
    along, across = mass * side**2 / 6, mass * (length**2 + side**2) / 12
    principal = np.where(np.abs(axis) > 0, along, across)
    centre = np.array(axis) * length / 2
    numbers = [" ".join(map(repr, map(float, v))) for v in (centre, principal)]
    return f'<inertial pos="{numbers[0]}" mass="{mass}" diaginertia="{numbers[1]}"/>'


def arm_by_mujoco():
    body = ""
    for joint, at, shape in (
        ("twist", "2 0 0", bar(4, 1, 0.1, (0, 1, 0))),
        ("luff", "0 0 1", bar(10, 2, 0.1, (1, 0, 0))),
        ("slew", "0 0 0", bar(20, 1, 0.2, (0, 0, 1))),
    ):
        axis = " ".join(map(str, JOINTS[joint]))
        body = f'<body name="{joint}" pos="{at}"><joint axis="{axis}"/>{shape}{body}</body>'
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 -{GRAVITY}"/><worldbody>{body}</worldbody></mujoco>'
    )


def test_reactions_of_an_arm_are_those_of_mujoco(load):
    """Force and torque that each joint passes to its child, in the axes of its parent."""
    result = load("reactions", "arm").simulate()
    model = arm_by_mujoco()
    data = mujoco.MjData(model)
    for k in range(len(result.time)):
        data.qpos[:] = [result[name][k] for name in JOINTS]
        data.qvel[:] = [result[f"{name}_rate"][k] for name in JOINTS]
        data.qfrc_applied[0] = 300
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        for number, (name, axis) in enumerate(JOINTS.items(), start=1):
            parent = data.xmat[number - 1].reshape(3, 3)
            torque, force = np.split(data.cfrc_int[number], 2)
            lever = data.subtree_com[1] - data.xpos[number]
            torque = torque + np.cross(lever, force)
            held = result[f"at_{name}"][k]
            np.testing.assert_allclose(held[:3], parent.T @ force, atol=1e-6)
            np.testing.assert_allclose(held[3:], basis(axis) @ parent.T @ torque, atol=1e-6)
    assert np.abs(result["energy.residual"]).max() < 1e-6
