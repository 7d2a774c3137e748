"""Robot arms for Pinocchio, from tables of their own.

The numbers of the real arms are those of ur5_robot.urdf, ur10_robot.urdf (BSD, from
ros-industrial/universal_robot) and panda.urdf (Apache-2.0, from frankaemika/franka_ros) of
github.com/Gepetto/example-robot-data at 39aa943, and of kinova.urdf of the same at 4c92367 (jaco),
whose quarter and half turns are 1.57079632679 and 3.14159265359.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

ARMS = Path(__file__).parents[1] / "models" / "arms"


def table(name: str) -> str:
    """Read an arm of two lines each body.

    They are its name, the body before, the joint between them and its axis (of any
    length, in the body's axes), origin and roll, pitch, yaw (deg) of the joint in the axes of the
    body before; mass, centre of mass, and ixx ixy ixz iyy iyz izz about it.
    """
    return (ARMS / f"{name}.txt").read_text("utf-8")


UR5, UR10, JACO, PANDA = map(table, ("ur5", "ur10", "jaco", "panda"))
SKEWED, EVERY_JOINT = map(table, ("skewed", "every_joint"))


def pinocchio_model(table: str, gravity: float, *, free: bool = False) -> Any:
    """The arm of a table; with `free`, its first body floats."""
    import pinocchio as pin

    model = pin.Model()
    model.gravity.linear = np.array([0, 0, -gravity])
    placed: dict[str, tuple[int, Any]] = {"-": (0, pin.SE3.Identity())}
    lines = table.strip("\n").split("\n")
    for joint_line, body_line in zip(lines[::2], lines[1::2], strict=True):
        name, before, kind, *numbers = joint_line.split()
        axis, origin, angles = np.reshape(np.array(numbers, float), (3, 3))
        mass, x, y, z, *inertia = map(float, body_line.split())
        parent, place = placed[before]
        if axis.any():
            axis /= np.linalg.norm(axis)
        turn = np.radians(angles)
        clamped = kind == "clamped"  # turned about its axis by the first angle
        axes = pin.exp3(turn[0] * axis) if clamped else pin.rpy.rpyToMatrix(turn)
        place = place * pin.SE3(axes, origin)
        if free and before == "-":
            kind = "floats"
        if kind not in ("fixed", "clamped"):
            parent, place = (
                model.addJoint(parent, _joint(kind, axis), place, name),
                pin.SE3.Identity(),
            )
        about_centre = np.zeros((3, 3))
        about_centre[np.triu_indices(3)] = inertia
        about_centre += np.triu(about_centre, 1).T
        body = pin.Inertia(mass, np.array([x, y, z]), about_centre)
        model.appendBodyToJoint(parent, body, place)
        model.addFrame(pin.Frame(name, parent, place, pin.FrameType.BODY))
        placed[name] = parent, place
    return model


def _joint(kind: str, axis: Any) -> Any:
    import pinocchio as pin

    match kind:
        case "turns":
            return pin.JointModelRevoluteUnaligned(*axis)
        case "slides":
            return pin.JointModelPrismaticUnaligned(*axis)
        case "swings":
            return pin.JointModelSpherical()
        case _:
            return pin.JointModelFreeFlyer()
