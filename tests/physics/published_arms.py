"""Robot arms for Pinocchio, from tables of their own.

The numbers of the real arms are those of ur5_robot.urdf, ur10_robot.urdf (BSD, from
ros-industrial/universal_robot) and panda.urdf (Apache-2.0, from frankaemika/franka_ros) of
github.com/Gepetto/example-robot-data at 39aa943, and of kinova.urdf of the same at 4c92367.
"""

from __future__ import annotations

from typing import Any

import numpy as np

# Two lines each body: its name, the body before, the joint between them and its axis (of any
# length, in the body's axes), origin and roll, pitch, yaw (deg) of the joint in the axes of the
# body before; mass, centre of mass, and ixx ixy ixz iyy iyz izz about it.
UR5 = """
foot - fixed  0 0 0  0 0 0  0 0 0
  4  0 0 0  0.00443333156 0 0 0.00443333156 0 0.0072
shoulder_pan foot turns  0 0 1  0 0 0.089159  0 0 0
  3.7  0 0 0  0.010267495893 0 0 0.010267495893 0 0.00666
shoulder_lift shoulder_pan turns  0 1 0  0 0.13585 0  0 90 0
  8.393  0 0 0.28  0.22689067591 0 0 0.22689067591 0 0.0151074
elbow shoulder_lift turns  0 1 0  0 -0.1197 0.425  0 0 0
  2.275  0 0 0.25  0.049443313556 0 0 0.049443313556 0 0.004095
wrist_1 elbow turns  0 1 0  0 0 0.39225  0 90 0
  1.219  0 0 0  0.111172755531 0 0 0.111172755531 0 0.21942
wrist_2 wrist_1 turns  0 0 1  0 0.093 0  0 0 0
  1.219  0 0 0  0.111172755531 0 0 0.111172755531 0 0.21942
wrist_3 wrist_2 turns  0 1 0  0 0 0.09465  0 0 0
  0.1879  0 0 0  0.0171364731454 0 0 0.0171364731454 0 0.033822
tip wrist_3 fixed  0 0 0  0 0.0823 0  -90 0 0
  0  0 0 0  0 0 0 0 0 0
"""

UR10 = """
foot - fixed  0 0 0  0 0 0  0 0 0
  4  0 0 0  0.0061063308908 0 0 0.0061063308908 0 0.01125
shoulder_pan foot turns  0 0 1  0 0 0.1273  0 0 0
  7.778  0 0 0  0.0314743125769 0 0 0.0314743125769 0 0.021875625
shoulder_lift shoulder_pan turns  0 1 0  0 0.220941 0  0 90 0
  12.93  0 0 0.306  0.421753803798 0 0 0.421753803798 0 0.036365625
elbow shoulder_lift turns  0 1 0  0 -0.1719 0.612  0 0 0
  3.87  0 0 0.28615  0.111069694097 0 0 0.111069694097 0 0.010884375
wrist_1 elbow turns  0 1 0  0 0 0.5723  0 90 0
  1.96  0 0 0  0.0051082479567 0 0 0.0051082479567 0 0.0055125
wrist_2 wrist_1 turns  0 0 1  0 0.1149 0  0 0 0
  1.96  0 0 0  0.0051082479567 0 0 0.0051082479567 0 0.0055125
wrist_3 wrist_2 turns  0 1 0  0 0 0.1157  0 0 0
  0.202  0 0 0  0.000526462289415 0 0 0.000526462289415 0 0.000568125
tip wrist_3 fixed  0 0 0  0 0.0922 0  -90 0 0
  0  0 0 0  0 0 0 0 0 0
"""

# Quarter and half turns as published: 1.57079632679 and 3.14159265359.
_QUARTER, _HALF = np.degrees([1.57079632679, 3.14159265359]).tolist()
JACO = f"""
stand - fixed  0 0 0  0 0 0  0 0 {_QUARTER!r}
  0  0 0 0  0 0 0 0 0 0
link_1 stand turns  0 0 1  0 0 0.15675  0 {_HALF!r} 0
  0.7477  0 -0.002 -0.0605  0.00152031725204 0 0 0.00152031725204 0 0.00059816
link_2 link_1 turns  0 0 1  0 0.0016 -0.11875  {-_QUARTER!r} 0 {_HALF!r}
  0.99  0 -0.2065 -0.01  0.010502207991 0 0 0.000792 0 0.010502207991
link_3 link_2 turns  0 0 1  0 -0.410 0  0 {_HALF!r} 0
  0.6763  0 0.081 -0.0086  0.00142022431908 0 0 0.000304335 0 0.00142022431908
link_4 link_3 turns  0 0 1  0 0.2073 -0.0114  {-_QUARTER!r} 0 {_HALF!r}
  0.463  0 0.0028848942 -0.0541932613  0.0004321316048 0 0 0.0004321316048 0 9.26e-05
link_5 link_4 turns  0 0 1  0 0 -0.10375  {_QUARTER!r} 0 {_HALF!r}
  0.463  0 0.0497208855 -0.0028562765  0.0004321316048 0 0 9.26e-05 0 0.0004321316048
link_6 link_5 turns  0 0 1  0 0.10375 0  {-_QUARTER!r} 0 {_HALF!r}
  0.99  0 0 -0.06  0.0003453236187 0 0 0.0003453236187 0 0.0005816
tip link_6 fixed  0 0 0  0 0 -0.16  {_HALF!r} {_QUARTER!r} 0
  0  0 0 0  0 0 0 0 0 0
"""

PANDA = """
foot - fixed  0 0 0  0 0 0  0 0 0
  0.629769  -0.041018 -0.00014 0.049974  0.00315 0.00000082904 0.00015 0.00388 0.0000082299 0.004285
joint1 foot turns  0 0 1  0 0 0.333  0 0 0
  4.970684  0.003875 0.002081 -0.04762  0.70337 -0.000139 0.006772 0.70661 0.019169 0.009117
joint2 joint1 turns  0 0 1  0 0 0  -90 0 0
  0.646926  -0.003141 -0.02872 0.003495  0.007962 -0.003925 0.010254 0.02811 0.000704 0.025995
joint3 joint2 turns  0 0 1  0 -0.316 0  90 0 0
  3.228604  0.027518 0.039252 -0.066502  0.037242 -0.004761 -0.011396 0.036155 -0.012805 0.01083
joint4 joint3 turns  0 0 1  0.0825 0 0  90 0 0
  3.587895  -0.05317 0.104419 0.027454  0.025853 0.007796 -0.001332 0.019552 0.008641 0.028323
joint5 joint4 turns  0 0 1  -0.0825 0.384 0  -90 0 0
  1.225946  -0.011953 0.041065 -0.038437  0.035549 -0.002117 -0.004037 0.029474 0.000229 0.008627
joint6 joint5 turns  0 0 1  0 0 0  90 0 0
  1.666555  0.060149 -0.014117 -0.010517  0.001964 0.000109 -0.001158 0.004354 0.000341 0.005433
joint7 joint6 turns  0 0 1  0.088 0 0  90 0 0
  0.735522  0.010517 -0.004252 0.061597  0.012516 -0.000428 -0.001196 0.010027 -0.000741 0.004815
hand joint7 fixed  0 0 0  0 0 0.107  0 0 -45
  0.73  -0.01 0 0.03  0.001 0 0 0.0025 0 0.0017
left hand slides  0 1 0  0 0 0.0584  0 0 0
  0.015  0 0 0  0.000002375 0 0 0.000002375 0 0.00000075
right hand slides  0 -1 0  0 0 0.0584  0 0 0
  0.015  0 0 0  0.000002375 0 0 0.000002375 0 0.00000075
tip hand fixed  0 0 0  0 0 0.1034  0 0 0
  0  0 0 0  0 0 0 0 0 0
"""

SKEWED = """
slew - turns  0.36 0.48 0.8  0.4 -0.7 1.1  20 -35 50
  700  0.3 -0.2 0.9  310 -25 40 270 -35 190
luff slew turns  -1 2 0.5  0.2 0.5 1.9  -75 15 110
  900  2.1 0.4 -0.3  120 60 -45 1400 25 1350
telescope luff slides  3 -1 2  1.7 -0.6 0.8  130 40 -25
  400  0.7 -1.2 0.5  260 70 -55 310 30 240
tip telescope fixed  0 0 0  0.7 -1.2 0.5  0 0 0
  0  0 0 0  0 0 0 0 0 0
"""

EVERY_JOINT = """
ship - floats  0 0 0  0 0 0  0 0 0
  90  0.2 -0.1 0.3  9 -1 2 7 0.5 8
stone ship swings  0 0 0  0.5 0.2 -0.4  25 -40 70
  20  0.1 0.3 -0.2  2 0.3 -0.2 1.5 0.4 1.8
plate stone clamped  0.36 0.48 0.8  -0.3 0.6 0.2  50 0 0
  5  -0.2 0.1 0.4  0.4 0.1 0 0.6 -0.1 0.5
bar plate turns  -0.64 0.6 0.48  0.4 -0.1 0.7  0 0 0
  12  0.5 0.1 0  0.8 0.2 -0.3 1.4 0.1 1.6
load bar slides  0.48 -0.8 0.36  0.9 -0.2 0.1  -60 10 35
  8  0.1 -0.3 0.2  0.5 0 0.1 0.7 -0.2 0.9
tip load fixed  0 0 0  0.1 -0.3 0.2  0 0 0
  0  0 0 0  0 0 0 0 0 0
"""


def pinocchio_model(table: str, gravity: float, *, free: bool = False) -> Any:
    """The arm of a table; with `free`, its first body floats."""
    import pinocchio as pin

    model = pin.Model()
    model.gravity.linear = np.array([0, 0, -gravity])
    placed: dict[str, tuple[int, Any]] = {"-": (0, pin.SE3.Identity())}
    lines = table.split("\n")[1:-1]
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
