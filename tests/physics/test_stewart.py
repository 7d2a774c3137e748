"""A Stewart platform of rigid joints, five closed chains, against Pinocchio."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

pin = pytest.importorskip("pinocchio")

ANGLES = np.radians([10, 110, 130, 230, 250, 350])
UPPER = np.radians([50, 70, 170, 190, 290, 310])
SHORT = 1e-5  # s


def place(radius, angle):
    return np.array([radius * np.cos(angle), radius * np.sin(angle), 0.0])


def bar(mass, length, side):
    across, along = mass * (length**2 + side**2) / 12, mass * side**2 / 6
    centre = np.array([0, 0, length / 2])
    return pin.Inertia(mass, centre, np.diag([across, across, along]))


def at(offset):
    return pin.SE3(np.eye(3), np.asarray(offset, float))


def reference(state):
    """Accelerations of the slides from rest, of six legs whose heads meet a platform."""
    model = pin.Model()
    q, heads, slides, forces = [], [], [], []
    centre = -place(0.6, UPPER[0])
    body = pin.Inertia(100, np.zeros(3), np.diag([10.0, 10.0, 18.0]))
    for i in range(6):
        foot = model.addJoint(0, pin.JointModelRX(), at(place(1.0, ANGLES[i])), f"u{i}")
        fork = model.addJoint(foot, pin.JointModelRY(), at(np.zeros(3)), f"w{i}")
        model.appendBodyToJoint(fork, bar(10, 0.8, 0.08), at(np.zeros(3)))
        slide = model.addJoint(fork, pin.JointModelPZ(), at([0, 0, 0.8]), f"s{i}")
        model.appendBodyToJoint(slide, bar(6, 0.6, 0.06), at(np.zeros(3)))
        name = f"leg[{i + 1}]"
        q += [state[f"{name}.u1.angle"], state[f"{name}.u2.angle"]]
        q += [state[f"{name}.slide.extension"]]
        slides.append(slide)
        forces.append(350 + 10 * (i + 1))
        heads.append(slide)
        if i == 0:  # children follow their parents, depth first
            ball = model.addJoint(slide, pin.JointModelSpherical(), at([0, 0, 0.6]), "ball")
            model.appendBodyToJoint(ball, body, at(centre))
    q1 = [state[f"leg[1].ball.attitude.h[{k}]"] for k in (2, 3, 4, 1)]
    configuration = np.zeros(model.nq)
    velocity_of = []
    for i, slide in enumerate(slides):
        configuration[model.joints[slide].idx_q] = q[3 * i + 2]
        configuration[model.joints[slide - 1].idx_q] = q[3 * i + 1]
        configuration[model.joints[slide - 2].idx_q] = q[3 * i]
        velocity_of.append(model.joints[slide].idx_v)
    start = model.joints[ball].idx_q
    configuration[start : start + 4] = q1
    torque = np.zeros(model.nv)
    torque[velocity_of] = forces
    pairs = []
    for i in range(1, 6):
        ends = ((heads[i], at([0, 0, 0.6])), (ball, at(centre + place(0.6, UPPER[i]))))
        kind = pin.FrameType.OP_FRAME
        pairs.append(
            [
                model.addFrame(pin.Frame(f"end{i}{k}", joint, 0, place_, kind))
                for k, (joint, place_) in enumerate(ends)
            ]
        )
    data = model.createData()
    pin.computeJointJacobians(model, data, configuration)
    pin.updateFramePlacements(model, data)
    rows = []
    for one, two in pairs:
        gap = data.oMf[one].translation - data.oMf[two].translation
        np.testing.assert_allclose(gap, 0, atol=1e-9)
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        first, second = (pin.getFrameJacobian(model, data, f, aligned)[:3] for f in (one, two))
        rows.append(first - second)

    # At rest the constraints hold accelerations to J a = 0.
    j = np.vstack(rows)
    mass = pin.crba(model, data, configuration)
    mass = np.triu(mass) + np.triu(mass, 1).T
    weight = pin.computeGeneralizedGravity(model, data, configuration)
    matrix = np.block([[mass, j.T], [j, np.zeros((len(j), len(j)))]])
    right = np.concatenate([torque - weight, np.zeros(len(j))])
    return np.linalg.solve(matrix, right)[: model.nv][velocity_of]


def test_a_platform_on_six_rigid_legs_rises_as_pinocchio_says(load):
    model = load("stewart", "rise")
    names = [variable.name for variable in model.states]
    state = dict(zip(names, model.initial_state(), strict=True))
    exact = reference(state)
    result = model.simulate(duration=SHORT, every=SHORT, rtol=1e-10)
    rates = np.array([result[f"v{i}"][-1] for i in range(1, 7)]) / SHORT
    np.testing.assert_allclose(rates, exact, rtol=1e-4)

    result = model.simulate()
    assert max(np.abs(result[name]).max() for name in ("gap2", "gap6")) < 1e-12
    assert np.abs(result["energy.residual"]).max() < 1e-2
    assert np.ptp(result["centre"][:, 2]) > 0.1


def sprung_rates(state):
    """The rates of six legs and a free platform with springs between them, and their start."""
    model = pin.Model()
    q0, slides = [], []
    for i in range(6):
        foot = model.addJoint(0, pin.JointModelRX(), at(place(1.0, ANGLES[i])), f"u{i}")
        fork = model.addJoint(foot, pin.JointModelRY(), at(np.zeros(3)), f"w{i}")
        model.appendBodyToJoint(fork, bar(10, 0.8, 0.08), at(np.zeros(3)))
        slides.append(model.addJoint(fork, pin.JointModelPZ(), at([0, 0, 0.8]), f"s{i}"))
        model.appendBodyToJoint(slides[i], bar(6, 0.6, 0.06), at(np.zeros(3)))
        coordinates = ("u1.angle", "u2.angle", "slide.extension")
        q0 += [state[f"leg[{i + 1}].{name}"] for name in coordinates]
    platform = model.addJoint(0, pin.JointModelFreeFlyer(), at(np.zeros(3)), "platform")
    body = pin.Inertia(100, np.zeros(3), np.diag([10.0, 10.0, 18.0]))
    model.appendBodyToJoint(platform, body, at(np.zeros(3)))
    data = model.createData()
    forces = 350 + 10 * np.arange(1.0, 7.0)
    damping = 2 * 0.1 * np.sqrt(1e6 * 100)

    # The pose at the start: corner 1 of the platform at the head of leg 1.
    q0 = np.array([*q0, 0, 0, 0, 0, 0, 0, 1])
    pin.forwardKinematics(model, data, q0)
    head = data.oMi[slides[0]] * at([0, 0, 0.6])
    w, *xyz = (state[f"leg[1].ball.attitude.h[{k}]"] for k in (1, 2, 3, 4))
    turned = head.rotation @ pin.Quaternion(w, *xyz).toRotationMatrix()
    q0[18:21] = head.translation - turned @ place(0.6, UPPER[0])
    q0[21:] = pin.Quaternion(turned).coeffs()

    def rates(_, y):
        q, v = y[: model.nq], y[model.nq :]
        pin.forwardKinematics(model, data, q, v)
        outer = [pin.Force.Zero() for _ in range(model.njoints)]
        on_platform = pin.Force.Zero()
        for i, slide in enumerate(slides):
            corner = place(0.6, UPPER[i])
            to_leg = data.oMi[slide].inverse() * data.oMi[platform]
            point = to_leg * corner  # of the platform, in the axes of the leg
            speed = to_leg.rotation @ (data.v[platform].linear
                                       + np.cross(data.v[platform].angular, corner))  # fmt: skip
            own = data.v[slide].linear + np.cross(data.v[slide].angular, point)
            pull = 1e6 * (point - [0, 0, 0.6]) + damping * (speed - own)
            outer[slide] = pin.Force(pull, np.cross(point, pull))
            on_platform -= to_leg.actInv(pin.Force(pull, np.cross(point, pull)))
        outer[platform] = on_platform
        torque = np.zeros(model.nv)
        torque[2:18:3] = forces - 200 * v[2:18:3]
        force = pin.StdVec_Force()
        force.extend(outer)
        speed = np.zeros(model.nq)  # of coordinates: with the rate of the quaternion
        speed[:18] = v[:18]
        w = q[24]
        turn, xyz = v[21:24], q[21:24]
        speed[18:21] = pin.Quaternion(q[21:25]).toRotationMatrix() @ v[18:21]
        speed[21:24] = 0.5 * (w * turn + np.cross(xyz, turn))
        speed[24] = -0.5 * xyz @ turn
        return np.concatenate([speed, pin.aba(model, data, q, v, torque, force)])

    return rates, np.concatenate([q0, np.zeros(model.nv)])


def test_a_platform_with_a_spring_in_each_leg_moves_as_pinocchio_says(load):
    model = load("stewart", "sprung")
    names = [variable.name for variable in model.states]
    state = dict(zip(names, model.initial_state(), strict=True))
    rates, start = sprung_rates(state)
    exact = solve_ivp(rates, (0, 0.05), start, method="DOP853", rtol=1e-8, atol=1e-10).y[:, -1]
    result = model.simulate(duration=0.05, every=0.05, rtol=1e-9)
    velocities = [result[f"v{i}"][-1] for i in range(1, 7)]
    np.testing.assert_allclose(velocities, exact[25 + 2 : 25 + 18 : 3], rtol=1e-6)
    np.testing.assert_allclose(result["centre"][-1], exact[18:21], rtol=1e-7, atol=1e-8)
