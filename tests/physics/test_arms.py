"""Mass matrix and bias forces of robot arms with rigid joints, as Pinocchio's."""

import numpy as np
import pytest
from probe import probe
from published_arms import EVERY_JOINT, JACO, PANDA, SKEWED, UR5, UR10, pinocchio_model

pin = pytest.importorskip("pinocchio")

GRAVITY = 9.81
STATES = 100


def rates(*widths):
    return tuple(f"{name}[{k}]" for name, n in widths for k in range(1, n + 1))


UR_JOINTS = tuple(
    f"arm.{link}.joint.angle"
    for link in ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
)
FINGERS = ("hand.left.slide.extension", "hand.right.slide.extension")
ARMS = {
    "ur5": (UR5, UR_JOINTS, rates(("rates", 6)), 0),
    "ur10": (UR10, UR_JOINTS, rates(("rates", 6)), 0),
    "panda": (
        PANDA,
        (*(f"arm.link_{k}.joint.angle" for k in range(1, 8)), *FINGERS),
        rates(("rates", 7), ("slides", 2)),
        np.repeat([0.003, 0.3], [7, 2]),  # friction
    ),
    "jaco": (
        JACO,
        tuple(f"arm.link_{k}.joint.angle" for k in range(1, 7)),
        rates(("rates", 6)),
        0,
    ),
    "skewed": (
        SKEWED,
        ("slew.joint.angle", "luff.joint.angle", "telescope.extension"),
        rates(("rates", 3)),
        0,
    ),
}


@pytest.mark.parametrize("arm", ARMS)
def test_mass_matrix_bias_forces_and_tip_are_pinocchios(arm):
    table, joints, names, friction = ARMS[arm]
    arm = probe("arms", arm, *names)
    model = pinocchio_model(table, GRAVITY)
    data = model.createData()
    tip = model.getFrameId("tip")
    rng = np.random.default_rng(len(joints))
    for _ in range(STATES):
        q = rng.uniform(-np.pi, np.pi, len(joints))
        v = rng.normal(size=len(joints))
        state = arm.at(dict(zip(joints, q, strict=True)), v)

        mass = arm.mass_matrix(state)
        exact = pin.crba(model, data, q)
        exact = np.triu(exact) + np.triu(exact, 1).T
        np.testing.assert_allclose(mass, exact, rtol=0, atol=1e-12 * np.abs(exact).max())

        bias = -mass @ arm.accelerations(state)
        forces = pin.nonLinearEffects(model, data, q, v) + friction * v
        np.testing.assert_allclose(bias, forces, rtol=0, atol=1e-12 * np.abs(forces).max())

        pin.framesForwardKinematics(model, data, q)
        found = arm.vector(state, "tip")
        np.testing.assert_allclose(found, data.oMf[tip].translation, rtol=0, atol=1e-12)


def test_every_joint_moves_as_pinocchios_at_any_orientation():
    names = (*rates(("twist", 6), ("spin", 3)), "turn", "slide")
    chain = probe("arms", "every_joint", *names)
    model = pinocchio_model(EVERY_JOINT, GRAVITY)
    data = model.createData()
    tip = model.getFrameId("tip")
    rng = np.random.default_rng(11)
    for _ in range(STATES):
        position, angle, extension = rng.normal(size=3), rng.uniform(-4, 4), rng.normal()
        attitudes = rng.normal(size=(2, 4))
        attitudes /= np.linalg.norm(attitudes, axis=1)[:, None]
        v = rng.normal(size=11)
        declared = {"bar.joint.angle": angle, "slide.extension": extension}
        declared |= {f"float.position[{k}]": x for k, x in enumerate(position, 1)}
        for joint, attitude in zip(("float", "ball"), attitudes, strict=True):
            declared |= {f"{joint}.attitude.h[{k}]": x for k, x in enumerate(attitude, 1)}
        state = chain.at(declared, v)

        h, b = np.roll(attitudes, -1, axis=1)  # scalar last
        q = np.concatenate([position, h, b, [angle, extension]])
        exact = pin.aba(model, data, q, v, np.zeros(11))
        found = chain.accelerations(state)
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-11 * np.abs(exact).max())
        pin.framesForwardKinematics(model, data, q)
        place = data.oMf[tip].translation
        np.testing.assert_allclose(chain.vector(state, "tip"), place, rtol=0, atol=1e-12)


def test_an_arm_in_free_fall_keeps_its_momentum(load):
    """Motors turn it far; momentum by Pinocchio, from poses and velocities."""
    result = load("arms", "falling").simulate()
    assert np.ptp(result["q"], axis=0).min() > 1
    assert np.ptp(result["h"], axis=0).min() > 1, "it has to turn over"

    model = pinocchio_model(UR5, GRAVITY, free=True)
    inertia = np.array([[2, 0.1, -0.2], [0.1, 1.5, 0.3], [-0.2, 0.3, 1]])
    ballast = pin.Inertia(30.0, np.array([0.1, 0.05, -0.2]), inertia)
    model.appendBodyToJoint(1, ballast, pin.SE3.Identity())
    data = model.createData()
    linear, angular = [], []
    names = ("r", "h", "q", "twist", "rates")
    for r, h, q, twist, rates in zip(*(result[name] for name in names), strict=True):
        configuration = np.concatenate([r, h[1:], h[:1], q])
        velocities = np.concatenate([twist, rates])
        momentum = pin.computeCentroidalMomentum(model, data, configuration, velocities)
        linear.append(momentum.linear.copy())
        angular.append(momentum.angular.copy())

    weight = GRAVITY * sum(body.mass for body in model.inertias)
    fall = np.outer(result.time, [0, 0, -weight])
    np.testing.assert_allclose(linear, fall, rtol=0, atol=1e-9 * np.abs(fall).max())
    spin = np.linalg.norm(result["twist"][:, 3:] @ inertia, axis=1).max()
    np.testing.assert_allclose(angular, np.zeros_like(angular), rtol=0, atol=1e-7 * spin)
    supplied = np.abs(result["energy.supplied"]).max()
    assert np.abs(result["energy.residual"]).max() < 1e-9 * supplied
