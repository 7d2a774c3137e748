"""Select the parts of a robot that are written, and give them their names."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from bgc.record_class import dataclass, field
from bgc.runtime.importing.identifiers import Names
from bgc.runtime.importing.inertia import Carried, rounded
from bgc.runtime.importing.robot import Joint, Kind, Link, Robot
from bgc.runtime.importing.rotation_text import Vector, number

_SERVO = 2 * math.pi * 8  # rad/s: frequency of the example's servos
_STOP = 2 * math.pi * 40  # rad/s: frequency of end stops
_LARGEST_LIMIT = 1e6  # rad or m; joints with wider limits have none


@dataclass(slots=True)
class Plan:
    """Names of the parts of each link and joint.

    `driven` are the joints with a drive, whose coordinates at the start are `start`; `gains` the
    stiffness and damping of their servos in the example. `frames` are fixed frames without mass:
    title, name, junction of the link that carries them, and their offset from it.
    """

    robot: Robot
    model: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    tip: str
    hubs: dict[str, str] = field(default_factory=dict)
    bodies: dict[str, str] = field(default_factory=dict)
    parts: dict[str, str] = field(default_factory=dict)
    mounts: dict[str, str] = field(default_factory=dict)
    ends: dict[str, str] = field(default_factory=dict)
    shafts: dict[str, str] = field(default_factory=dict)
    stops: dict[str, tuple[str, float]] = field(default_factory=dict)
    couplings: dict[str, str] = field(default_factory=dict)
    extras: dict[tuple[str, str], str] = field(default_factory=dict)
    driven: list[Joint] = field(default_factory=list)
    start: tuple[float, ...] = ()
    gains: list[tuple[float, float]] = field(default_factory=list)
    frames: list[tuple[str, str, str, Vector]] = field(default_factory=list)

    def coordinate(self, joint: Joint) -> str:
        """Write the coordinate of a driven or following joint at the start."""
        ratio, offset, leader = 1.0, 0.0, joint
        named = {j.name: j for j in self.joints.values()}
        while leader.mimic is not None:
            offset += ratio * leader.mimic.offset
            ratio *= leader.mimic.ratio
            leader = named[leader.mimic.leader]
        own = f"q0[{[j.name for j in self.driven].index(leader.name) + 1}]"
        return own if leader is joint else f"mimicked({own}, {number(ratio)}, {number(offset)})"

    def extra(self, joint: Joint, what: str) -> str:
        """Return the name of a part on a joint's shaft."""
        return self.extras[joint.name, what]

    def summary(self) -> list[str]:
        """Describe the driven joints, a line each."""
        if not self.driven:
            return ["No joint has a drive."]
        lines = ["Driven joints, in the order of `drives` and `q`:"]
        for count, joint in enumerate(self.driven, 1):
            facts = [joint.note or joint.kind.value]
            unit, torque, rate = (
                ("rad", "N m", "rad/s") if joint.kind is Kind.TURNS else ("m", "N", "m/s")
            )
            if joint.lower is not None and joint.upper is not None:
                facts.append(f"{joint.lower:g} to {joint.upper:g} {unit}")
            if joint.effort:
                facts.append(f"at most {joint.effort:g} {torque}")
            if joint.velocity:
                facts.append(f"at most {joint.velocity:g} {rate}")
            lines.append(f"{count}. {' '.join(joint.name.split())}: {', '.join(facts)}")
        return lines


def plan_of(robot: Robot, names: Names, carried: Mapping[str, Carried], *, limits: bool) -> Plan:
    """Choose what is written, and name it."""
    tip = _tip(robot)
    kept = _kept(robot, tip)
    plan = Plan(
        robot,
        names.type(robot.name),
        {name: link for name, link in robot.links.items() if name in kept},
        {name: joint for name, joint in robot.joints.items() if name in kept},
        tip,
    )
    for name, link in plan.links.items():
        plan.hubs[name] = names.value(name, "link")
        if link.body is not None or link.pictures:
            plan.bodies[name] = names.value(f"{plan.hubs[name].removesuffix('_link')}_body", "body")
    for joint in plan.joints.values():
        _name_joint(plan, joint, names)
    start = []
    for child, joint in plan.joints.items():
        if not joint.kind.driven:
            continue
        along = max(carried[child].along_axis, 1e-9)
        if joint.mimic is None:
            plan.driven.append(joint)
            start.append(_start(joint))
            plan.gains.append((rounded(along * _SERVO**2), rounded(2 * along * _SERVO)))
        if limits and _limited(joint):
            stem = _stem(plan.parts[joint.name])
            stiffness = rounded(along * _STOP**2)
            plan.stops[joint.name] = names.value(f"{stem}_stop", "stop"), stiffness
    plan.start = tuple(start)
    _place_frames(plan, kept, names)
    return plan


def _name_joint(plan: Plan, joint: Joint, names: Names) -> None:
    part = plan.parts[joint.name] = names.value(joint.name, "joint")
    stem = _stem(part)
    if joint.kind is not Kind.FIXED:
        plan.mounts[joint.name] = names.value(f"{stem}_mount", "mount")
    if any(joint.after):
        plan.ends[joint.name] = names.value(f"{stem}_end", "mount")
    if joint.kind.driven:
        plan.shafts[joint.name] = names.value(f"{stem}_shaft", "shaft")
    if joint.kind.driven or joint.kind is Kind.BALL:
        present = {"friction": joint.friction, "rotor": joint.rotor, "spring": joint.stiffness}
        for what, value in present.items():
            if value:
                plan.extras[joint.name, what] = names.value(f"{stem}_{what}", what)
    if joint.mimic is not None:
        plan.couplings[joint.name] = names.value(f"{stem}_mimic", "mimic")


def _stem(name: str) -> str:
    return name.removesuffix("_joint")


def _limited(joint: Joint) -> bool:
    return (
        joint.lower is not None
        and joint.upper is not None
        and max(-joint.lower, joint.upper) < _LARGEST_LIMIT
    )


def _start(joint: Joint) -> float:
    """Zero, or the middle of a range that excludes it."""
    if joint.lower is None or joint.upper is None or joint.lower <= 0 <= joint.upper:
        return 0.0
    return rounded((joint.lower + joint.upper) / 2, 4)


def _tip(robot: Robot) -> str:
    """Return the link behind the most moving joints; of several, the first that ends a chain."""
    moving = {robot.root: (0, 0)}
    for name, joint in robot.joints.items():
        count, length = moving[joint.parent]
        moving[name] = count + (joint.kind is not Kind.FIXED), length + 1
    return max(moving, key=lambda name: moving[name])


def _kept(robot: Robot, tip: str) -> set[str]:
    """Return the links that are written: without fixed frames that carry nothing."""
    kept = set()
    for name in reversed(robot.links):
        link, joint = robot.links[name], robot.joints.get(name)
        needed = name in kept or name == tip or joint is None or joint.kind is not Kind.FIXED
        if needed or link.body is not None or link.pictures:
            kept.add(name)
            if joint is not None:
                kept.add(joint.parent)
    return kept


def _place_frames(plan: Plan, kept: set[str], names: Names) -> None:
    places: dict[str, tuple[str, np.ndarray, np.ndarray]] = {}
    for name, joint in plan.robot.joints.items():
        if name in kept:
            continue
        if joint.parent in kept:
            hub, r, axes = plan.hubs[joint.parent], np.zeros(3), np.eye(3)
        else:
            hub, r, axes = places[joint.parent]
        r = r + axes @ joint.place.origin
        places[name] = hub, r, axes @ joint.place.axes.matrix
        x, y, z = (float(f"{c:.12g}") for c in r)
        plan.frames.append((name, names.value(f"{name}_at", "frame"), hub, (x, y, z)))
