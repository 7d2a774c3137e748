"""Imported robots move as Pinocchio (URDF) and MuJoCo (MJCF) say, at random states.

Each robot has all kinds of joints and bodies. The accelerations come from the compiled graph, those
of the reference from its own reading of the same file.
"""

import math
import re
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from robot_probe import RobotProbe

import bgc
from bgc.grammar.source_files import read_source
from bgc.runtime.importing.identifiers import Names
from bgc.runtime.importing.importing import Choices, import_text
from bgc.runtime.importing.inertia import carried_by_joints
from bgc.runtime.importing.mjcf import read_mjcf
from bgc.runtime.importing.notes import Notes
from bgc.runtime.importing.plan import plan_of
from bgc.runtime.importing.robot import Kind

ROBOTS = Path(__file__).parents[1] / "models" / "robots"
STATES = 40
OFF = ("CONTACT", "LIMIT", "FRICTIONLOSS", "EQUALITY", "ACTUATION")


def imported(file: Path, folder: Path, count: int, observed: str, extra: str = "") -> RobotProbe:
    """The robot with efforts `u` on its drives."""
    text = import_text(file, folder, Choices()).text
    model = text.split("  robot  : ")[1].split("(")[0]
    ground = text.split("  ground : ")[1].split(";")[0]
    path = folder / f"{file.stem}.bg"
    path.write_text(
        text
        + f"""
model Probed {{
  param u[{count}] = zeros({count});
  ground : {ground};
  robot : {model};
  none : Se[6](e = zeros(6));
  motors : Se[{count}](e = -u);
  ground -> robot -> none;
  robot.drives -> motors;
}}
scene probed of Probed {{ {extra} observe {observed}; }}
"""
    )
    return RobotProbe(path, "probed")


def quaternions(rng, count):
    h = rng.normal(size=(count, 4))
    return h / np.linalg.norm(h, axis=1)[:, None]


def components(name, values):
    return {f"{name}[{k}]": values[:, k - 1] for k in range(1, values.shape[1] + 1)}


def test_urdf_moves_as_in_pinocchio(tmp_path):
    pin = pytest.importorskip("pinocchio")
    file = ROBOTS / "every_joint.urdf"
    driven = ("slew", "luff", "telescope", "swing", "left")
    rates = "robot.afloat.free.f as v0, robot.skid.slide.f as v1, robot.skid.free.f as v2"
    probe = imported(file, tmp_path, len(driven), f"{rates}, motors.f as v3")

    rng = np.random.default_rng(4)
    place, h = rng.normal(size=(STATES, 3)), quaternions(rng, STATES)
    skid, turn = rng.normal(size=(STATES, 2)), rng.normal(size=STATES)
    q = rng.uniform([-3, 0.3, -0.1, -3, -0.9], [3, 1.3, 0.5, 3, 0.9], (STATES, 5))
    follower = -1.5 * q[:, 4] + 0.25
    v, u = rng.normal(size=(STATES, 14)), rng.normal(size=(STATES, 5))
    declared = components("robot.afloat.position", place)
    declared |= components("robot.afloat.attitude.h", h) | components("robot.skid.position", skid)
    declared |= {"robot.skid.angle": turn, "robot.right.angle": follower}
    for k, name in enumerate(driven):
        kind = "extension" if name in ("telescope", "left") else "angle"
        declared[f"robot.{name}.{kind}"] = q[:, k]
    stops = {"luff": q[:, 1], "telescope": q[:, 2], "left": q[:, 4], "right": follower}
    declared |= {f"robot.{name}_stop.contact.q": x for name, x in stops.items()}
    found = probe.accelerate(probe.at(declared, v), u)

    model = pin.buildModelFromUrdf(str(file))
    model.armature[model.idx_vs[model.getJointId("telescope")]] = 100**2 * 1e-4
    data = model.createData()
    for state in range(STATES):
        to_pinocchio, extra = np.zeros((model.nv, 14)), np.zeros(model.nv)
        configuration = pin.neutral(model)
        turned = pin.Quaternion(*h[state]).toRotationMatrix()
        cos, sin = math.cos(turn[state]), math.sin(turn[state])
        at, by = model.idx_qs[1:], model.idx_vs[1:]
        for joint, (a, b) in enumerate(zip(at, by, strict=True), 1):
            name = model.names[joint]
            if name == "afloat":  # Pinocchio's rates are in the axes of the child
                configuration[a : a + 7] = [*place[state], *h[state, 1:], h[state, 0]]
                to_pinocchio[b : b + 3, :3], to_pinocchio[b + 3 : b + 6, 3:6] = turned.T, np.eye(3)
                extra[b : b + 3] = np.cross(v[state, 3:6], turned.T @ v[state, :3])
            elif name == "skid":
                configuration[a : a + 4] = [*skid[state], cos, sin]
                back = np.array([[cos, sin], [-sin, cos]])
                to_pinocchio[b : b + 2, 6:8], to_pinocchio[b + 2, 8] = back, 1
                x, y = back @ v[state, 6:8]
                extra[b : b + 2] = v[state, 8] * np.array([-y, x])
            else:
                k, ratio, angle = 4, -1.5, follower[state]
                if name != "right":
                    k, ratio = driven.index(name), 1
                    angle = q[state, k]
                to_pinocchio[b, 9 + k] = ratio
                unbounded = model.nqs[joint] == 2
                configuration[a : a + 2] = (
                    [math.cos(angle), math.sin(angle)] if unbounded else angle
                )
        rates = to_pinocchio @ v[state]
        mass = pin.crba(model, data, configuration)
        mass = np.triu(mass) + np.triu(mass, 1).T
        slew = by[list(model.names).index("slew") - 1]
        friction = 0.3 * math.tanh(rates[slew] / 1e-3)
        forces = pin.nonLinearEffects(model, data, configuration, rates) + model.damping * rates
        forces[slew] += friction
        # Rates of Pinocchio are T v, their derivatives T v' - extra.
        forces -= mass @ extra
        reduced = to_pinocchio.T @ mass @ to_pinocchio
        pushed = np.concatenate([np.zeros(9), u[state]])
        exact = np.linalg.solve(reduced, pushed - to_pinocchio.T @ forces)
        assert_equal_to(exact, found[state])


def mjcf_files():
    installed = find_spec("mujoco")
    files = [ROBOTS / "crawler.xml", ROBOTS / "disabled.xml"]
    if installed is not None and installed.origin is not None:
        files.append(Path(installed.origin).parent / "testdata" / "model.xml")
    return [file for file in files if file.is_file()]


@pytest.mark.parametrize("file", mjcf_files(), ids=lambda file: file.stem)
def test_mjcf_moves_as_in_mujoco(file, tmp_path):
    """Two robots of our own; and a model that comes with MuJoCo, with 43 degrees of freedom."""
    mujoco = pytest.importorskip("mujoco")
    robot = read_mjcf(read_source(file), Notes())
    plan = plan_of(robot, Names(), carried_by_joints(robot), limits=True)
    widths = {Kind.FLOATS: 6, Kind.BALL: 3}
    loose = [joint for joint in plan.joints.values() if joint.kind in widths]
    driven, count = plan.driven, len(plan.driven)
    free = [f"robot.{plan.parts[joint.name]}.free.f as v{k}" for k, joint in enumerate(loose)]
    gravity = (
        "" if robot.gravity is None else f"set gravity = {math.hypot(*robot.gravity)!r} m/s^2;"
    )
    probe = imported(file, tmp_path, count, ", ".join([*free, "motors.f as v"]), gravity)

    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.disableflags |= int(sum(getattr(mujoco.mjtDisableBit, f"mjDSBL_{x}") for x in OFF))
    model.opt.density = model.opt.viscosity = 0
    model.body_gravcomp[:] = model.tendon_stiffness[:] = model.tendon_damping[:] = 0
    data = mujoco.MjData(model)
    numbers = {model.joint(k).name: k for k in range(model.njnt) if model.joint(k).name}
    for joint in plan.joints.values():  # those without a name, by the name of their body
        if joint.kind is not Kind.FIXED and joint.name not in numbers:
            body = re.fullmatch(r"body_(\d+)", joint.child)
            body = model.body(int(body[1]) if body else joint.child)
            numbers[joint.name] = int(body.jntadr[0] + body.jntnum[0]) - 1

    rng = np.random.default_rng(5)
    size = count + sum(widths[joint.kind] for joint in loose)
    v, u = rng.normal(size=(STATES, size)), rng.normal(size=(STATES, count))
    low = [-1 if joint.lower is None else joint.lower for joint in driven]
    high = [1 if joint.upper is None else joint.upper for joint in driven]
    q = rng.uniform(low, high, (STATES, count))
    coupled, declared = np.zeros((model.nv, size)), {}
    positions = np.tile(model.qpos0, (STATES, 1))
    column = 0
    for joint in plan.joints.values():
        part = f"robot.{plan.parts[joint.name]}"
        if joint.kind is Kind.FIXED:
            continue
        at, dof = (a[numbers[joint.name]] for a in (model.jnt_qposadr, model.jnt_dofadr))
        if joint.kind in widths:
            width, h = widths[joint.kind], quaternions(rng, STATES)
            declared |= components(f"{part}.attitude.h", h)
            positions[:, at + width - 3 : at + width + 1] = h
            if joint.kind is Kind.FLOATS:
                place = positions[:, at : at + 3] = rng.normal(size=(STATES, 3))
                declared |= components(f"{part}.position", place)
            coupled[dof : dof + width, column : column + width] = np.eye(width)
            column += width
            continue
        ratio, offset, leader = 1.0, 0.0, joint
        if joint.mimic is not None:
            ratio, offset = joint.mimic.ratio, joint.mimic.offset
            leader = next(x for x in driven if x.name == joint.mimic.leader)
        k = driven.index(leader)
        value = ratio * q[:, k] + offset
        positions[:, at] += value
        coupled[dof, size - count + k] = ratio
        declared[f"{part}.{'angle' if joint.kind is Kind.TURNS else 'extension'}"] = value
        if joint.name in plan.stops:
            declared[f"robot.{plan.stops[joint.name][0]}.contact.q"] = value
        if joint.stiffness:
            declared[f"robot.{plan.extras[joint.name, 'spring']}.q"] = value - joint.relaxed
    found = probe.accelerate(probe.at(declared, v), u)

    for state in range(STATES):
        data.qpos[:], data.qvel[:] = positions[state], coupled @ v[state]
        mujoco.mj_forward(model, data)
        mass = np.array([_product(mujoco, model, data, e) for e in np.eye(model.nv)])
        forces = data.qfrc_bias - data.qfrc_passive
        for joint in plan.joints.values():
            if joint.friction:
                dof = model.jnt_dofadr[numbers[joint.name]]
                forces[dof] += joint.friction * math.tanh(data.qvel[dof] / 1e-3)
        pushed = np.concatenate([np.zeros(size - count), u[state]])
        exact = np.linalg.solve(coupled.T @ mass @ coupled, pushed - coupled.T @ forces)
        assert_equal_to(exact, found[state])


def assert_equal_to(exact, found):
    largest = np.abs(exact).max()
    np.testing.assert_allclose(found / largest, exact / largest, rtol=0, atol=1e-10)


def _product(mujoco, model, data, vector):
    product = np.zeros(model.nv)
    mujoco.mj_mulM(model, data, product, vector)
    return product


def test_the_example_of_an_arm_starts_at_rest_and_moves(tmp_path):
    """Its servos hold it, and move each joint by what the scene asks."""
    file = tmp_path / "arm.urdf"
    file.write_text(ARM)
    path = tmp_path / "arm.bg"
    path.write_text(import_text(file, tmp_path, Choices()).text)
    result = bgc.compile(path).simulate()
    q = result["q"]
    assert np.ptp(q[result.time < 0.5], axis=0).max() < 1e-9
    np.testing.assert_allclose(q[-1] - q[0], [0.2, 0.02], atol=1e-4)
    assert result["effort"][0, 0] == pytest.approx(0, abs=1e-6)
    assert result["effort"][0, 1] == pytest.approx(2 * 9.81, rel=1e-6)
    assert np.abs(result["energy.residual"]).max() < 1e-4


def test_a_robot_is_held_by_the_derivatives_of_its_potential_energy(tmp_path):
    """Torques as the manual writes them; the hand of 2 kg weighs on the slide alone."""
    file, path = tmp_path / "arm.urdf", tmp_path / "held.bg"
    tilted = ARM.replace('<axis xyz="0 0 1"/>\n  </joint>', '<axis xyz="0 1 0"/>\n  </joint>', 1)
    file.write_text(tilted)
    (tmp_path / "arm.bg").write_text(import_text(file, tmp_path, Choices()).text)
    path.write_text(
        """import "arm.bg"; import crane.crane;
        model Held {
          ground : Ground; robot : Arm_2(q0 = [0.4, 0.3]); end : Se[6](e = zeros(6));
          let energy = potential(robot.column_body.mass, robot.column_body.centre)
            + potential(robot.hand_body.mass, robot.hand_body.centre);
          let weight[1, 2] = jacobian(energy, [robot.turn.angle, robot.lift.extension]);
          hold : Se[2](e = -weight[1, 1..2]);
          ground -> robot -> end; robot.drives -> hold;
        }
        scene held of Held { observe robot.q as q, hold.e as effort; run 3 s every 0.1 s; }"""
    )
    result = bgc.compile(path).simulate()
    np.testing.assert_allclose(result["q"], np.broadcast_to([0.4, 0.3], (31, 2)), atol=1e-9)
    assert result["effort"][-1, 1] == pytest.approx(-2 * 9.81 * math.cos(0.4), rel=1e-9)


def test_the_mass_matrix_is_that_of_the_linear_form(tmp_path):
    """Efforts of `free` oppose the drives: C B is -M^-1, the sign that the manual gives."""
    pin = pytest.importorskip("pinocchio")
    file, path = tmp_path / "arm.urdf", tmp_path / "arm.bg"
    file.write_text(ARM.replace("iyy", 'ixy="0" ixz="0" iyz="0" iyy'))  # urdfdom needs all six
    text = import_text(file, tmp_path, Choices()).text
    begin, end = text.index("  // 8 Hz"), text.index("  ground -> robot")
    text = text[:begin] + "  free : Se[2](e = zeros(2));\n" + text[end:]
    text = text.replace("robot.drives -> servo;", "robot.drives -> free;")
    path.write_text(
        text[: text.index("/// Rests")] + "scene falls of Arm2Cell { observe free.f as rates; }"
    )
    model, q = bgc.compile(path), [0.3, 0.2]
    model.parameters["q0"] = q
    linear = model.linearise(["free.e"], ["rates"])
    found = -np.linalg.inv(linear.C @ linear.B)
    reference = pin.buildModelFromUrdf(str(file))
    turned = np.array([math.cos(q[0]), math.sin(q[0]), q[1]])  # a joint without limits
    exact = np.triu(pin.crba(reference, reference.createData(), turned))
    np.testing.assert_allclose(found, exact + np.triu(exact, 1).T, rtol=0, atol=1e-12)


ARM = """<robot name="arm">
  <link name="base"/>
  <link name="column">
    <inertial><origin xyz="0.1 0 0"/><mass value="3"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
  </link>
  <link name="hand">
    <inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial>
  </link>
  <joint name="turn" type="continuous">
    <parent link="base"/><child link="column"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="lift" type="prismatic">
    <origin xyz="0.5 0 0"/>
    <parent link="column"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.5" effort="100" velocity="1"/>
  </joint>
</robot>
"""
