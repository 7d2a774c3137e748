"""An example of a robot: a cell with a servo on each joint, and a scene."""

from __future__ import annotations

import math

from bgc.runtime.importing.identifiers import Names
from bgc.runtime.importing.inertia import rounded
from bgc.runtime.importing.layout import bracketed
from bgc.runtime.importing.plan import Plan
from bgc.runtime.importing.robot import Joint, Kind
from bgc.runtime.importing.rotation_text import Vector, number

_MOVE = {Kind.TURNS: 0.2, Kind.SLIDES: 0.02}  # rad, m


def example(plan: Plan, names: Names, *, floating: bool) -> list[str]:
    """Write the cell and the scene: the robot rests, then each joint moves a little."""
    count = len(plan.driven)
    cell = names.type(f"{plan.model}_cell")
    afloat = floating or any(j.kind is Kind.FLOATS for j in plan.joints.values())
    loose = any(j.kind in (Kind.FLOATS, Kind.PLANAR, Kind.BALL) for j in plan.joints.values())
    loose = loose or floating
    lines = [
        f"/// The robot {'afloat' if floating else 'on the ground'}"
        + (", with a position servo on each joint." if count else "."),
        f"model {cell} {{",
    ]
    if count:
        lines += [
            "/// Rates asked of the joints, rad/s and m/s.",
            f"input rates[{count}] = zeros({count});",
            "/// Coordinates at the start, rad and m.",
            bracketed(f"param q0[{count}] = ", [number(q) for q in plan.start]),
        ]
    lines += [
        "",
        f"ground : Ground{_tilt(plan.robot.gravity)};",
        *(["float : Free;"] if floating else []),
        f"robot : {plan.model}{'(q0 = q0)' if count else ''};",
        "end : Se[6](e = zeros(6));",
    ]
    if count:
        stiffness = [number(k) for k, _ in plan.gains]
        damping = [number(d) for _, d in plan.gains]
        lines += [
            "// 8 Hz, critically damped, by the inertia that each joint moves at zero.",
            f"servo : PositionServo[{count}](",
            "rate = rates,",
            bracketed("stiffness = ", stiffness, "],"),
            bracketed("damping = ", damping, "]);"),
        ]
    lines.append(f"ground -> {'float -> ' if floating else ''}robot -> end;")
    if count:
        lines.append("robot.drives -> servo;")
    lines += ["}", ""]
    return lines + _scene(plan, cell, names, loose=loose, afloat=afloat)


def _scene(plan: Plan, cell: str, names: Names, *, loose: bool, afloat: bool) -> list[str]:
    count = len(plan.driven)
    does = "Rests, then moves each joint a little." if count else "Starts at rest."
    if afloat:
        does = "Starts at rest, and falls freely."
    lines = [f"/// {does}", f"scene {names.value(plan.robot.name.lower(), 'robot')} of {cell} {{"]
    gravity = plan.robot.gravity
    if gravity is not None:
        lines.append(f"set gravity = {number(math.hypot(*gravity))} m/s^2;")
    if count:
        moves = [number(_move(j, q)) for j, q in zip(plan.driven, plan.start, strict=True)]
        lines.append(bracketed("drive rates = smooth_rate(time - 0.5 s, 1 s)*", moves))
        lines.append("observe robot.q as q, servo.effort as effort;")
    lines += ["observe robot.tip.r as tip, energy.residual;"]
    if count:
        lines += ["plot q;", "plot effort;"]
    lines += ["plot tip;", ""]
    if count and not loose:
        lines.append("start rest vary servo.stretch0;")
    lines += ["run 2 s every 20 ms;", "}"]
    return lines


def _tilt(gravity: Vector | None) -> str:
    """Turn the ground so that gravity, given in its axes, points along -z of the world."""
    if gravity is None or not any(gravity[:2]):
        return "" if gravity is None or gravity[2] <= 0 else "(angles0 = [180 deg, 0, 0])"
    x, y, z = gravity
    roll = math.atan2(-y, -z)
    pitch = math.atan2(x, math.hypot(y, z))
    return f"(angles0 = [{number(roll)}, {number(pitch)}, 0])"


def _move(joint: Joint, start: float) -> float:
    """A tenth of the range at most, to the side with more of it."""
    most = _MOVE[joint.kind]
    if joint.lower is None or joint.upper is None:
        return most
    above, below = joint.upper - start, start - joint.lower
    step = min(most, 0.1 * (above + below))
    return rounded(step if above >= below else -step, 2)
