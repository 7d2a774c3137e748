"""The text of a robot: models of its links, the robot, and a scene."""

from __future__ import annotations

import math
import os
from pathlib import Path

from bgc.diagnostics.source import Source
from bgc.grammar.format import format_source
from bgc.runtime.importing.example import example
from bgc.runtime.importing.identifiers import Names
from bgc.runtime.importing.inertia import carried_by_joints, principal
from bgc.runtime.importing.layout import bracketed, call, chained
from bgc.runtime.importing.plan import Plan, plan_of
from bgc.runtime.importing.robot import ORIGIN, Body, Joint, Kind, Link, Picture, Pose, Robot
from bgc.runtime.importing.rotation_text import Vector, number

_AXES = {(1.0, 0.0, 0.0): "x", (0.0, 1.0, 0.0): "y", (0.0, 0.0, 1.0): "z"}
_PARTS = {
    Kind.TURNS: "PoweredRevolute",
    Kind.SLIDES: "PoweredPrismatic",
    Kind.FLOATS: "Free",
    Kind.PLANAR: "Planar",
    Kind.BALL: "Spherical",
}
_HELD = {Kind.TURNS: 5, Kind.SLIDES: 5, Kind.PLANAR: 3, Kind.BALL: 3}


def write_robot(robot: Robot, folder: Path, *, limits: bool = True, floating: bool = False) -> str:
    """Write a robot as a `.bg` text in canonical form.

    Parameters
    ----------
    robot
        The robot, its links in the order of their tree.
    folder
        Folder of the file to write, from which the files of meshes are named.
    limits
        Whether joints get end stops at their limits.
    floating
        Whether the example's base floats instead of standing on the ground.
    """
    names = Names()
    plan = plan_of(robot, names, carried_by_joints(robot), limits=limits)
    writer = _Writer(plan, names, folder)
    text = "\n".join([*writer.head(), *writer.model(), *example(plan, names, floating=floating)])
    return format_source(Source(f"{robot.name}.bg", text + "\n"))


class _Writer:
    """Writes the models of links, and that of the robot."""

    def __init__(self, plan: Plan, names: Names, folder: Path) -> None:
        self.plan = plan
        self.robot = plan.robot
        self.names = names
        self.folder = folder
        self.pictured: dict[str, str] = {}
        self.imports = {"arms.link", "mechanics.actuators"}
        self.size = 0.1 * max(
            [0.1, *(math.dist(j.place.origin, ORIGIN) for j in plan.joints.values())]
        )

    def head(self) -> list[str]:
        """Write the imports, and a model for each link with pictures."""
        models: list[str] = []
        for link in self.plan.links.values():
            if link.pictures:
                models += self._link_model(link)
        for joint in self.plan.joints.values():
            if joint.kind is Kind.PLANAR:
                self.imports.add("mechanics.pairs")
            if joint.friction and joint.kind.driven:
                self.imports.add("mechanics.friction")
            if joint.mimic or joint.name in self.plan.stops:
                self.imports.add("mechanics.coupling")
        return [*(f"import {name};" for name in sorted(self.imports)), "", *models]

    def model(self) -> list[str]:
        """Write the model of the robot."""
        plan, robot = self.plan, self.robot
        count = len(plan.driven)
        lines = [
            f"/// The robot {robot.name}, from the {robot.form} file {robot.file}.",
            "///",
            *(f"/// {line}".rstrip() for line in plan.summary()),
            f"model {plan.model} is Arm[{count}] {{" if count else f"model {plan.model} {{",
            f"/// Frame of {_quoted(robot.root)}, which the base carries.",
            "port base in : Frame;",
            f"/// Frame of {_quoted(plan.tip)}.",
            "port tip out : Frame main;",
        ]
        if count:
            lines += [
                "/// Rates of the driven joints (rad/s, m/s), and their torques or forces on the "
                "drives (N m, N).",
                f"port drives[{count}] out;",
                "/// Coordinates of the driven joints at the start, rad and m.",
                bracketed(f"param q0[{count}] = ", [number(q) for q in plan.start]),
            ]
        lines.append("")
        for name in plan.links:
            lines += self._link(name)
        lines += self._drives()
        lines += self._frames()
        lines.append("}")
        return [*lines, ""]

    # --- links ---------------------------------------------------------------------

    def _link_model(self, link: Link) -> list[str]:
        name = self.names.type(f"{link.name}_body")
        self.pictured[link.name] = name
        self.imports.add("mechanics.body")
        head = f"model {name} is"
        whole = link.body is not None and self._as_points(link.body) is None
        return [
            f"/// The link {_quoted(link.name)}.",
            call(f"{head} HeavyBody", self._mass(link.body), " {")
            if link.body is not None and whole
            else f"{head} MasslessBody {{",
            *(self._picture(picture) for picture in link.pictures),
            "}",
            "",
        ]

    def _picture(self, picture: Picture) -> str:
        lengths = [f"{number(size)} m" for size in picture.sizes]
        if picture.file is not None:
            relative = os.path.relpath(picture.file.absolute(), self.folder.absolute())
            lengths = ['"' + relative.replace("\\", "/").replace('"', "") + '"']
            if picture.sizes[0] != 1:
                lengths.append(number(picture.sizes[0]))
        place = _vector(picture.pose.origin)
        at = ""
        if place or picture.pose.axes.text:
            at = f" at {place or 'zeros(3)'}"
            at += f", {picture.pose.axes.text}" if picture.pose.axes.text else ""
        colour = f' colour "{picture.colour}"' if picture.colour else ""
        return f"shape {picture.kind}({', '.join(lengths)}){at}{colour};"

    def _as_points(self, body: Body | None) -> list[list[str]] | None:
        """Write a body that has no mass, or no moment about some axis: parts and arguments."""
        found = None if body is None else principal(body)
        if body is None or found is None:
            return None
        moments, axes = found
        parts = []
        if body.mass:
            place = _vector(body.com)
            com = [f"com = {place}"] if place else []
            parts.append(["PointMass", f"mass = {number(body.mass)} kg", *com])
        if moments:
            rows = ", ".join(_listed(tuple(float(x) + 0.0 for x in row)) for row in axes)
            given = [f"moments = {_listed(moments)}", f"axes = [{rows}]"]
            parts.append([f"RotaryInertia[{len(moments)}]", *given])
        return parts

    def _mass(self, body: Body) -> list[str]:
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
        if xy == xz == yz == 0:
            inertia = f"diag({_listed((xx, yy, zz))})"
        else:
            inertia = f"symmetric({', '.join(map(number, (xx, xy, xz, yy, yz, zz)))})"
        com = _vector(body.com)
        place = [f"com = {com}"] if com else []
        return [f"mass = {number(body.mass)} kg", *place, f"inertia = {inertia}"]

    def _link(self, name: str) -> list[str]:
        """Write a link with the joint that carries it."""
        plan = self.plan
        link, hub = plan.links[name], plan.hubs[name]
        joint = plan.joints.get(name)
        parts: list[str] = []
        if joint is None:
            lines, chain = [f"// {name}: the root"], ["base"]
        else:
            kind = joint.note or joint.kind.value
            lines = [f"// {name}: on {joint.parent} by the {kind} joint {joint.name}"]
            chain = [plan.hubs[joint.parent], *self._joint(joint, parts)]
        chain.append(hub)
        parts.append(f"{hub} : J1;")
        ends = []
        points = self._as_points(link.body)
        if name in self.pictured:
            ends.append(plan.bodies[name])
            parts.append(f"{ends[0]} : {self.pictured[name]};")
        elif link.body is not None and points is None:
            ends.append(plan.bodies[name])
            parts.append(call(f"{ends[0]} : HeavyBody", self._mass(link.body)))
        for part in points or []:
            ends.append(self.names.value(f"{plan.bodies[name]}_mass", "mass"))
            parts.append(call(f"{ends[-1]} : {part[0]}", part[1:]))
        if name == plan.tip:
            ends.append("tip")
        bonds = [f"{' -> '.join(chain)}{' -> ' + ', '.join(ends) if ends else ''};"]
        if joint is not None and joint.kind is Kind.BALL and joint.rotor:
            rotor = plan.extra(joint, "rotor")
            parts.append(f"{rotor} : I[3]({number(joint.rotor)} kg*m^2);")
            bonds.append(f"{plan.parts[joint.name]}.shaft -> {rotor};")
        if joint is not None and joint.name in plan.shafts:
            bonds += self._shaft(joint, parts)
            if joint.mimic:
                leader = plan.shafts[joint.mimic.leader]
                coupling = plan.couplings[joint.name]
                parts.append(f"{coupling} : Mimic(ratio = {number(joint.mimic.ratio)});")
                bonds += [
                    f"{leader} -> {coupling}.leader;",
                    f"{plan.shafts[joint.name]} -> {coupling}.follower;",
                ]
        return ["", *map(_one_line, lines), *parts, *bonds]

    def _joint(self, joint: Joint, parts: list[str]) -> list[str]:
        """Write the parts of a joint; return their chain."""
        plan = self.plan
        chain = []
        fixed = joint.kind is Kind.FIXED
        place = joint.place
        if joint.kind is Kind.FLOATS and self.robot.form == "MJCF":
            place = Pose()  # part of its coordinates
        offset, axes = _vector(place.origin), place.axes.text
        if fixed or offset or axes:
            mount = plan.mounts[joint.name] if not fixed else plan.parts[joint.name]
            given = [f"offset = {offset}"] if offset else []
            given += [f"axes = {axes}"] if axes else []
            parts.append(call(f"{mount} : Mount", given))
            chain.append(mount)
        if not fixed:
            powered = "Powered" if joint.kind is Kind.BALL and joint.rotor else ""
            part = f"{plan.parts[joint.name]} : {powered}{_PARTS[joint.kind]}"
            parts.append(call(part, self._moving(joint)))
            chain.append(plan.parts[joint.name])
        if after := _vector(joint.after):
            parts.append(f"{plan.ends[joint.name]} : Mount(offset = {after});")
            chain.append(plan.ends[joint.name])
        return chain

    def _moving(self, joint: Joint) -> list[str]:
        """Write the arguments of a joint that moves."""
        given: list[str] = []
        if joint.kind in (Kind.TURNS, Kind.SLIDES, Kind.PLANAR):
            given.append(f"axis = {_axis(joint.axis)}")
        if joint.kind is Kind.TURNS:
            given.append(f"angle0 = {self.plan.coordinate(joint)}")
            given += [f"friction = {number(joint.damping)} N*m*s"] if joint.damping else []
        elif joint.kind is Kind.SLIDES:
            given.append(f"extension0 = {self.plan.coordinate(joint)}")
            given += [f"friction = {number(joint.damping)} N*s/m"] if joint.damping else []
        elif joint.kind is Kind.FLOATS and self.robot.form == "MJCF":
            if offset := _vector(joint.place.origin):
                given.append(f"position0 = {offset}")
            if joint.place.axes.text:
                given.append(f"angles0 = {_listed(_angles(joint.place))}")
        elif joint.kind is Kind.BALL and joint.damping:
            given.append(f"friction = {number(joint.damping)} N*m*s")
        if joint.kind in _HELD:
            given.append(f"lock = Rigid[{_HELD[joint.kind]}]")
            size = self.size * (0.3 if joint.kind is Kind.SLIDES else 0.4)
            given.append(f"size = {number(float(f'{size:.1g}'))} m")
        return given

    def _shaft(self, joint: Joint, parts: list[str]) -> list[str]:
        """Write what acts on the coordinate of a driven joint."""
        plan = self.plan
        shaft = plan.shafts[joint.name]
        ends = []
        parts.append(f"{shaft} : J1;")
        if joint.name in plan.stops:
            stop, stiffness = plan.stops[joint.name]
            given = {
                "lower": number(joint.lower or 0),
                "upper": number(joint.upper or 0),
                "position0": plan.coordinate(joint),
                "stiffness": number(stiffness),
            }
            parts.append(call(f"{stop} : JointStop", [f"{k} = {v}" for k, v in given.items()]))
            ends.append(stop)
        if joint.friction:
            ends.append(plan.extra(joint, "friction"))
            kinetic = number(joint.friction)
            parts.append(f"{ends[-1]} : DryFriction(kinetic = {kinetic}, creep = 1e-3);")
        if joint.rotor:
            ends.append(plan.extra(joint, "rotor"))
            unit = "kg*m^2" if joint.kind is Kind.TURNS else "kg"
            parts.append(f"{ends[-1]} : I({number(joint.rotor)} {unit});")
        if joint.stiffness:
            ends.append(plan.extra(joint, "spring"))
            unit = "N*m" if joint.kind is Kind.TURNS else "N/m"
            stretch = plan.coordinate(joint)
            if joint.relaxed:
                stretch += f" - {number(joint.relaxed)}".replace("- -", "+ ")
            parts.append(
                f"{ends[-1]} : C(stiffness = {number(joint.stiffness)} {unit}, q0 = {stretch});"
            )
        port = "shaft" if joint.kind is Kind.TURNS else "rod"
        acting = f" -> {', '.join(ends)}" if ends else ""
        return [f"{plan.parts[joint.name]}.{port} -> {shaft}{acting};"]

    # --- the whole -----------------------------------------------------------------

    def _drives(self) -> list[str]:
        plan = self.plan
        if not plan.driven:
            return []
        shafts = [plan.shafts[joint.name] for joint in plan.driven]
        lines = [""]
        if len(shafts) == 1:
            lines.append(f"{shafts[0]} -> drives;")
        else:
            lines += [
                bracketed("shafts : Mux", ["1"] * len(shafts)),
                chained(shafts, " -> shafts -> drives;"),
            ]
        values = [
            f"{plan.parts[j.name]}.{'angle' if j.kind is Kind.TURNS else 'extension'}"
            for j in plan.driven
        ]
        return [
            *lines,
            "",
            "/// Coordinates of the driven joints, rad and m.",
            bracketed(f"output q[{len(values)}] = ", values),
        ]

    def _frames(self) -> list[str]:
        """Write frames without mass, and the capsules of a robot without pictures."""
        plan = self.plan
        lines = [""] if plan.frames else []
        for title, name, hub, offset in plan.frames:
            lines.append(f"/// Origin of {_quoted(title)} in the world.")
            moved = f" + {hub}.A*{_vector(offset)}" if _vector(offset) else ""
            lines.append(f"output {name}[3] : m = {hub}.r{moved};")
        if not self.pictured:
            drawn = [
                f"shape capsule({number(float(f'{0.3 * self.size:.1g}'))} m) "
                f'from {plan.hubs[joint.parent]} to {plan.hubs[child]} colour "lightgrey";'
                for child, joint in plan.joints.items()
                if math.dist(joint.place.origin, ORIGIN) > 1e-6 and joint.kind is not Kind.FLOATS
            ]
            lines += ["", *drawn] if drawn else []
        return lines


def _angles(pose: Pose) -> Vector:
    """Roll, pitch and yaw of a pose."""
    rows = pose.axes.rows
    pitch = -math.asin(max(-1.0, min(1.0, rows[2][0])))
    if abs(rows[2][0]) > 1 - 1e-14:
        return math.atan2(-rows[1][2], rows[1][1]), pitch, 0.0
    return math.atan2(rows[2][1], rows[2][2]), pitch, math.atan2(rows[1][0], rows[0][0])


def _axis(axis: Vector) -> str:
    length = math.hypot(*axis)
    unit = tuple(component / length + 0.0 for component in axis)
    for known, name in _AXES.items():
        if unit == known:
            return name
        if unit == tuple(-c + 0.0 for c in known):
            return f"-{name}"
    text = _listed(axis)
    return text if length == 1 else f"{text}/norm({text})"


def _vector(values: Vector) -> str:
    """Write a vector of lengths; empty for the zero vector."""
    if not any(values):
        return ""
    return f"[{', '.join(f'{number(v)} m' if v else '0' for v in values)}]"


def _listed(values: tuple[float, ...]) -> str:
    return f"[{', '.join(map(number, values))}]"


def _quoted(name: str) -> str:
    return _one_line(f"`{name}`")


def _one_line(text: str) -> str:
    return " ".join(text.split())
