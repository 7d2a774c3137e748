"""The paper's crane on its vessel, three times more: for MuJoCo, for Pinocchio, and by energies.

Generalised velocities are the hull's twist [v; w] in its own axes and the rates of slew, luff and
fold. The data are those of the library, read from a compiled model's parameters; axes and signs
are written here again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

GRAVITY = 9.81
NED = np.diag([1.0, -1, -1, 1, -1, -1])
X, Y, Z = np.eye(3)
AXES = (Z, -Y, -Y)
BEAM_AXES = (Z, X, X)
BEAMS = ("post", "boom", "jib")


def skew(v: Array) -> Array:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def turn(axis: Array, angle: complex) -> Array:
    """Rodrigues: child's axes -> parent's."""
    s = skew(axis)
    return np.eye(3) + np.sin(angle) * s + (1 - np.cos(angle)) * (s @ s)


@dataclass(frozen=True)
class Body:
    """Mass, centre of mass, inertia about it, and the 6x6 inertia about the frame's origin."""

    mass: float
    centre: Array
    about_centre: Array

    @property
    def about_origin(self) -> Array:
        c = skew(self.centre)
        return np.block(
            [
                [self.mass * np.eye(3), -self.mass * c],
                [self.mass * c, self.about_centre - self.mass * c @ c],
            ]
        )


@dataclass(frozen=True)
class Crane:
    """The hull's two inertias in the library's axes, and the beams with their places."""

    rigid_body: Array
    added: Array
    beams: tuple[Body, ...]
    places: tuple[Array, ...]  # of each beam's base, in the axes of the body before
    reach: Array  # of the tip, in the jib's axes

    @property
    def hull(self) -> Body:
        mass = self.rigid_body[0, 0]
        lever = self.rigid_body[3:, :3] / mass
        centre = np.array([lever[2, 1], lever[0, 2], lever[1, 0]])
        about = self.rigid_body[3:, 3:] + mass * skew(centre) @ skew(centre)
        return Body(mass, centre, (about + about.T) / 2)


def crane_of(parameters: Mapping[str, float]) -> Crane:
    """Read the data of `vessel` and `crane`."""

    def matrix(name: str) -> Array:
        rows = [[parameters[f"{name}[{i},{j}]"] for j in range(1, 7)] for i in range(1, 7)]
        return NED @ np.array(rows) @ NED

    beams = []
    for name, axis in zip(BEAMS, BEAM_AXES, strict=True):
        mass, length, side = (parameters[f"crane.{name}.{x}"] for x in ("mass", "length", "side"))
        across = mass / 12 * (length**2 + side**2) * np.eye(3)
        about = across + (mass / 6 * side**2 - across[0, 0]) * np.outer(axis, axis)
        beams.append(Body(mass, length / 2 * axis, about))
    deck = np.array([parameters[f"vessel.deck_at[{k}]"] for k in (1, 2, 3)])
    ends = [parameters[f"crane.{b}.length"] * a for b, a in zip(BEAMS, BEAM_AXES, strict=True)]
    return Crane(
        matrix("vessel.M_RB"), matrix("vessel.M_A"), tuple(beams), (deck, *ends[:2]), ends[2]
    )


@dataclass(frozen=True)
class State:
    """Orientation of the hull, joint angles, generalised velocities, and what pushes."""

    orientation: Array  # hull's axes -> world's
    angles: Array
    velocities: Array
    push: Array  # wrench on the tip, in the jib's axes
    steering: Array  # force that the drives yield to, in the axes of the crane's foot


def _twist_maps(crane: Crane, angles: Array) -> list[Array]:
    """Jacobians of all four twists, each in its own body's axes, by the generalised velocities."""
    maps = [np.hstack([np.eye(6), np.zeros((6, 3))]).astype(angles.dtype)]
    for k in range(3):
        back = turn(AXES[k], angles[k]).T
        shift = np.block([[np.eye(3), -skew(crane.places[k])], [np.zeros((3, 3)), np.eye(3)]])
        carried = np.kron(np.eye(2), back) @ shift @ maps[-1]
        carried[3:, 6 + k] += AXES[k]
        maps.append(carried)
    return maps


def _mass_matrix(crane: Crane, angles: Array) -> Array:
    inertias = (crane.rigid_body + crane.added, *(b.about_origin for b in crane.beams))
    maps = _twist_maps(crane, angles)
    return sum(m.T @ i @ m for m, i in zip(maps, inertias, strict=True))


def _steering_map(crane: Crane, angles: Array) -> Array:
    """The tip's velocity seen from the foot, in its axes, by the rates of the joints."""
    still = np.hstack([np.zeros((9, 6)), np.vstack([np.zeros((6, 3)), np.eye(3)])])
    jib = _twist_maps(crane, angles)[-1] @ still
    tip = jib[:3] - skew(crane.reach) @ jib[3:]
    turned = turn(AXES[0], angles[0]) @ turn(AXES[1], angles[1]) @ turn(AXES[2], angles[2])
    return (turned @ tip)[:, 6:]


def drive_torques(crane: Crane, state: State) -> Array:
    """Efforts of the drives, which hold the weights outboard and yield to the steering."""
    down = -GRAVITY * state.orientation[2]
    torques = -_steering_map(crane, state.angles).T @ state.steering
    for k, beam_map in enumerate(_twist_maps(crane, state.angles)[1:]):
        turned = np.eye(3)
        for axis, angle in zip(AXES[: k + 1], state.angles[: k + 1], strict=True):
            turned = turned @ turn(axis, angle)
        beam = crane.beams[k]
        at_centre = beam_map[:3] - skew(beam.centre) @ beam_map[3:]
        torques -= at_centre[:, 6:].T @ (beam.mass * (turned.T @ down))
    return torques


def by_energies(crane: Crane, state: State) -> Array:
    """Kirchhoff's equations of the whole, Lagrange's of the joints.

    The kinetic energy T(q, v, q') of hull, water and beams does not depend on the hull's pose.
    With P and L its derivatives by the hull's v and w: P' + w x P = F, L' + w x L + v x P = M, and
    d/dt dT/dq' - dT/dq = torque. dM/dq by complex steps: exact to rounding.
    """
    q, v = state.angles, state.velocities
    mass = _mass_matrix(crane, q)
    slopes = [_mass_matrix(crane, q + 1e-30j * e).imag / 1e-30 for e in np.eye(3)]
    linear, angular = mass[:3] @ v, mass[3:6] @ v
    rates = np.concatenate(
        [
            -np.cross(v[3:6], linear),
            -np.cross(v[3:6], angular) - np.cross(v[:3], linear),
            [v @ slope @ v / 2 for slope in slopes] + drive_torques(crane, state),
        ]
    )
    maps = _twist_maps(crane, q)
    turned = state.orientation
    for beam, beam_map, axis, angle in zip(crane.beams, maps[1:], AXES, q, strict=True):
        turned = turned @ turn(axis, angle)
        weight = turned.T @ [0, 0, -GRAVITY * beam.mass]
        rates += beam_map.T @ np.concatenate([weight, np.cross(beam.centre, weight)])
    force, moment = state.push[:3], state.push[3:]
    rates += maps[-1].T @ np.concatenate([force, moment + np.cross(crane.reach, force)])
    drift = sum(slope * rate for slope, rate in zip(slopes, v[6:], strict=True)) @ v
    return np.linalg.solve(mass, rates - drift)


class ByPinocchio:
    """The articulated body algorithm, on the crane without added mass."""

    def __init__(self, crane: Crane) -> None:
        import pinocchio as pin

        self.pin, self.crane = pin, crane
        self.model = pin.Model()
        self.model.gravity.linear = np.array([0, 0, -GRAVITY])
        joint = self.model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "hull")
        self._add(joint, crane.hull)
        for place, axis, beam in zip(crane.places, AXES, crane.beams, strict=True):
            mount = pin.SE3(np.eye(3), place)
            joint = self.model.addJoint(
                joint, pin.JointModelRevoluteUnaligned(*axis), mount, f"joint {joint}"
            )
            self._add(joint, beam)
        self.data = self.model.createData()

    def _add(self, joint: int, body: Body) -> None:
        inertia = self.pin.Inertia(body.mass, body.centre, body.about_centre)
        self.model.appendBodyToJoint(joint, inertia, self.pin.SE3.Identity())

    def __call__(self, state: State) -> Array:
        pin, crane = self.pin, self.crane
        quaternion = pin.Quaternion(state.orientation).coeffs()
        q = np.concatenate([np.zeros(3), quaternion, state.angles])
        lift = state.orientation.T @ [0, 0, GRAVITY * crane.hull.mass]  # the water's
        force, moment = state.push[:3], state.push[3:]
        wrenches = [pin.Force.Zero() for _ in range(self.model.njoints)]
        wrenches[1] = pin.Force(lift, np.cross(crane.hull.centre, lift))
        wrenches[4] = pin.Force(force, moment + np.cross(crane.reach, force))
        torques = np.concatenate([np.zeros(6), drive_torques(crane, state)])
        return pin.aba(self.model, self.data, q, state.velocities, torques, wrenches)


class ByMujoco:
    """MuJoCo's forward dynamics, on the crane without added mass."""

    def __init__(self, crane: Crane) -> None:
        import mujoco

        self.mujoco, self.crane = mujoco, crane
        body = ""
        for place, axis, beam in reversed(list(zip(crane.places, AXES, crane.beams, strict=True))):
            joint = f'<joint type="hinge" axis="{_row(axis)}"/>'
            body = f'<body pos="{_row(place)}">{joint}{_inertial(beam)}{body}</body>'
        self.model = mujoco.MjModel.from_xml_string(f"""<mujoco>
          <option gravity="0 0 {-GRAVITY}"><flag contact="disable"/></option>
          <worldbody><body gravcomp="1"><freejoint/>{_inertial(crane.hull)}{body}</body></worldbody>
        </mujoco>""")
        self.data = mujoco.MjData(self.model)

    def __call__(self, state: State) -> Array:
        data, v = self.data, state.velocities
        axes = state.orientation  # MuJoCo's linear velocity is in the world's axes
        self.mujoco.mju_mat2Quat(data.qpos[3:7], axes.ravel())
        data.qpos[7:] = state.angles
        data.qvel[:] = [*(axes @ v[:3]), *v[3:]]
        data.qfrc_applied[6:] = drive_torques(self.crane, state)
        self.mujoco.mj_kinematics(self.model, self.data)
        jib = data.xmat[-1].reshape(3, 3)
        lever = self.crane.reach - self.crane.beams[-1].centre
        force, moment = state.push[:3], state.push[3:]
        data.xfrc_applied[-1] = [*(jib @ force), *(jib @ (moment + np.cross(lever, force)))]
        self.mujoco.mj_forward(self.model, data)
        linear = axes.T @ data.qacc[:3] - np.cross(v[3:6], v[:3])
        return np.concatenate([linear, data.qacc[3:]])


def _inertial(body: Body) -> str:
    full = [body.about_centre[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    place, mass = _row(body.centre), _row([body.mass])
    return f'<inertial pos="{place}" mass="{mass}" fullinertia="{_row(full)}"/>'


def _row(values: object) -> str:
    return " ".join(repr(float(x)) for x in np.asarray(values))
