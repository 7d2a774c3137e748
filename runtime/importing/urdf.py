"""Robots in URDF.

Source of the format: wiki.ros.org/urdf/XML. Rotor inertia stands in transmissions, as
`rotorInertia` with `mechanicalReduction`, or as Drake's `rotor_inertia` and `gear_ratio`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np

from bgc.diagnostics.catalogue import did_you_mean, listed
from bgc.diagnostics.catalogue.imported import (
    left_out,
    not_importable,
    wrong_structure,
    wrong_value,
)
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Label
from bgc.diagnostics.source import Source
from bgc.runtime.importing.inertia import body_of
from bgc.runtime.importing.link_tree import in_depth_first_order
from bgc.runtime.importing.meshes import Meshes
from bgc.runtime.importing.notes import Notes
from bgc.runtime.importing.robot import Body, Joint, Kind, Link, Mimicked, Picture, Pose, Robot
from bgc.runtime.importing.rotation_text import Vector, by_roll_pitch_yaw
from bgc.runtime.importing.xml_elements import Element, read_elements

_KINDS = {
    "fixed": Kind.FIXED,
    "revolute": Kind.TURNS,
    "continuous": Kind.TURNS,
    "prismatic": Kind.SLIDES,
    "floating": Kind.FLOATS,
    "planar": Kind.PLANAR,
}
_READ = {"link", "joint", "transmission", "material"}
_IN_JOINT = {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"}
_BENIGN = {"calibration", "safety_controller"}  # of controllers, not of the machine
_ZERO: Vector = (0.0, 0.0, 0.0)
_Item = TypeVar("_Item", Link, Joint)


def read_urdf(source: Source, packages: Mapping[str, Path], notes: Notes) -> Robot:
    """Read a robot.

    Parameters
    ----------
    source
        The text; its name is the path of the file, from which meshes are found.
    packages
        Folders of `package://NAME/`.
    notes
        Takes the warnings.

    Raises
    ------
    BgError
        BG137, BG138 or BG270, with all faults of links and joints that were found.
    """
    root = read_elements(source)
    if root.tag != "robot":
        what = f"the file has `<{root.tag[:40]}>` where a URDF has `<robot>`"
        help = "name a file of MuJoCo .xml; other formats are not read"
        raise BgError([not_importable(what, root.span, help)])
    _refuse_macros(root)
    return _Urdf(root, packages, notes).read()


def _refuse_macros(root: Element) -> None:
    macro = next((child for child in root.children if child.tag.startswith("xacro:")), None)
    if macro is not None:
        what = f"`<{macro.tag[:40]}>` is a macro of xacro, which has to be expanded first"
        help = "run `xacro robot.urdf.xacro > robot.urdf`, and import robot.urdf"
        raise BgError([not_importable(what, macro.span, help)])


class _Urdf:
    """Reads links and joints, gathers their faults."""

    def __init__(self, root: Element, packages: Mapping[str, Path], notes: Notes) -> None:
        self.root = root
        self.notes = notes
        folder = Path(root.span.source.name).parent
        self.meshes = Meshes(folder, packages, notes)
        self.colours = {
            material.attributes.get("name", ""): _colour(material)
            for material in root.all("material")
        }
        self.faults: list[Diagnostic] = []

    def read(self) -> Robot:
        links = self._named("link", self._link)
        rotors = self._rotors()
        joints = self._named("joint", lambda element: self._joint(element, rotors))
        for child in self.root.children:
            if child.tag not in _READ:
                self.notes.group(
                    child.span,
                    f"`<{child.tag[:40]}>` is left out",
                    "nothing, unless it changes the motion: then add it to the generated file",
                )
        if not links and not self.faults:
            what = "the robot has no links"
            self.faults.append(wrong_structure(self.root.span, what, 'add `<link name=".."/>`'))
        for joint in joints.values():
            self._check_names(joint, links, joints)
        if self.faults:
            raise BgError(self.faults)
        source = self.root.span.source
        name = self.root.attributes.get("name", "").strip() or Path(source.name).stem
        return in_depth_first_order(
            Robot(name, Path(source.name).name, "URDF", links, joints), self.notes
        )

    def _named(self, tag: str, read: Callable[[Element], _Item]) -> dict[str, _Item]:
        """Read the elements with a tag by name; a name that occurs twice is a fault."""
        found: dict[str, _Item] = {}
        places: dict[str, Element] = {}
        for element in self.root.all(tag):
            try:
                name = element.need("name")
                if name in places:
                    first = Label(places[name].place("name"), "the first one")
                    what = f"two `<{tag}>` have the name `{name}`"
                    help = "give one of them another name"
                    raise BgError([wrong_structure(element.place("name"), what, help, (first,))])
                places[name] = element
                found[name] = read(element)
            except BgError as fault:
                self.faults.extend(fault.diagnostics)
        return found

    # --- links ---------------------------------------------------------------------

    def _link(self, element: Element) -> Link:
        name = element.need("name")
        pictures = self._pictures(element, "visual", quiet=True)
        if not pictures and (pictures := self._pictures(element, "collision", quiet=True)):
            if (visual := element.first("visual")) is not None:
                cause = "a link is drawn by its `<collision>`, as its `<visual>` cannot be shown"
                help = "convert meshes to .glb, .gltf, .stl or .obj, or give --package"
                self.notes.group(visual.span, cause, help)
        elif not pictures:
            self._pictures(element, "visual", quiet=False)
        return Link(name, self._body(element, name), tuple(pictures), element.span)

    def _body(self, link: Element, name: str) -> Body | None:
        inertial = link.first("inertial")
        if inertial is None:
            return None
        mass, inertia = inertial.first("mass"), inertial.first("inertia")
        if mass is None:
            help = 'add `<mass value=".."/>`, or remove `<inertial>`'
            raise BgError(
                [wrong_value(inertial.span, f"the inertial of `{name}` has no mass", help)]
            )
        tensor = np.zeros((3, 3))
        if inertia is not None:
            for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
                key = f"i{'xyz'[i]}{'xyz'[j]}"
                tensor[i, j] = tensor[j, i] = inertia.number(key, 0.0 if i != j else None)
        elif mass.number("value"):
            self.notes.group(
                inertial.span,
                "a body without `<inertia>` is taken for a point",
                'add `<inertia ixx=".." ../>`',
            )
        span = mass.place("value")
        centre = self._pose(inertial)
        return body_of(mass.number("value"), centre, tensor, name, span, self.notes)

    def _pictures(self, link: Element, tag: str, *, quiet: bool) -> list[Picture]:
        """Read the shapes that can be shown; a fault of one changes no motion and is a warning.

        Where none can be shown, a second look, which is not quiet, notes the reasons.
        """
        found = []
        for element in link.all(tag):
            try:
                picture = self._picture(element, quiet=quiet)
            except BgError as fault:
                first = fault.diagnostics[0]
                if quiet:
                    cause = f"a `<{tag}>` with a fault is left out: {first.message}"
                    self.notes.group(first.span, cause, first.help)
                continue
            if picture is not None:
                found.append(picture)
        return found

    def _picture(self, element: Element, *, quiet: bool) -> Picture | None:
        geometry = element.first("geometry")
        if geometry is None or not geometry.children:
            return None
        shape = geometry.children[0]
        pose = self._pose(element)
        material = element.first("material")
        colour = ""
        if material is not None:
            colour = _colour(material) or self.colours.get(material.attributes.get("name", ""), "")
        match shape.tag:
            case "box":
                sizes = shape.vector("size", _ZERO)
            case "cylinder" | "capsule":
                sizes = shape.number("radius"), shape.number("length")
            case "sphere":
                sizes = (shape.number("radius"),)
            case "mesh":
                scale = shape.vector("scale", (1.0, 1.0, 1.0))
                file = self.meshes.find(
                    shape.need("filename"), shape.place("filename"), scale, quiet=quiet
                )
                if file is None:
                    return None
                return Picture("mesh", (scale[0],), pose, colour, file)
            case tag:
                cause = f"a shape `<{tag[:40]}>` is left out"
                if not quiet:
                    self.notes.group(shape.span, cause, "use a box, cylinder, sphere or mesh")
                return None
        if min(sizes) <= 0:
            cause = f"a {shape.tag} without extent is left out"
            if not quiet:
                self.notes.group(shape.span, cause, "give positive lengths")
            return None
        return Picture(shape.tag, tuple(sizes), pose, colour)

    # --- joints --------------------------------------------------------------------

    def _rotors(self) -> dict[str, float]:
        """Rotor inertia on the joint's side, by joint."""
        found: dict[str, float] = {}
        for transmission in self.root.all("transmission"):
            for joint in transmission.all("joint"):
                name = joint.attributes.get("name", "")
                for actuator in transmission.all("actuator"):
                    try:
                        inertia = _within(actuator, ("rotorInertia", "rotor_inertia"))
                        if not inertia:
                            continue  # generators of URDF write words where a ratio is unknown
                        ratio = _within(actuator, ("mechanicalReduction", "gear_ratio"))
                        ratio = ratio or _within(joint, ("mechanicalReduction",)) or 1.0
                        found[name] = found.get(name, 0.0) + ratio * ratio * inertia
                    except BgError as fault:
                        self.faults.extend(fault.diagnostics)
        return found

    def _joint(self, element: Element, rotors: Mapping[str, float]) -> Joint:
        name = element.need("name")
        word = element.need("type")
        if word not in _KINDS:
            what = f"`{word[:40]}` is not a type of joint"
            help = did_you_mean(word, _KINDS) or f"use {listed(list(_KINDS))}"
            raise BgError([wrong_value(element.place("type"), what, help)])
        kind = _KINDS[word]
        ends = {}
        for tag in ("parent", "child"):
            end = element.first(tag)
            if end is None:
                help = f'add `<{tag} link=".."/>`'
                raise BgError([wrong_structure(element.span, f"`{name}` has no {tag}", help)])
            ends[tag] = end.need("link")
        for child in element.children:
            if child.tag not in _IN_JOINT | _BENIGN:
                cause = f"`<{child.tag[:40]}>` of a joint is left out"
                self.notes.group(child.span, cause, "nothing, unless it changes the motion")
        axis = (1.0, 0.0, 0.0)
        if (direction := element.first("axis")) is not None and kind is not Kind.FIXED:
            x, y, z = direction.vector("xyz", axis)
            axis = (x, y, z)
            if not math.hypot(*axis) > 0 and (kind.driven or kind is Kind.PLANAR):
                what = f"the axis of `{name}` has no direction"
                raise BgError([wrong_value(direction.place("xyz"), what, 'write `xyz="0 0 1"`')])
        damping, friction = self._dynamics(element, kind)
        lower, upper, effort, velocity = self._limits(element, name, word)
        return Joint(
            name,
            kind,
            ends["parent"],
            ends["child"],
            self._pose(element),
            axis,
            lower,
            upper,
            effort,
            velocity,
            damping,
            friction,
            rotors.get(name, 0.0),
            mimic=self._mimic(element, name, kind),
            note=word,
            span=element.span,
        )

    def _dynamics(self, element: Element, kind: Kind) -> tuple[float, float]:
        dynamics = element.first("dynamics")
        if dynamics is None or kind is Kind.FIXED:
            return 0.0, 0.0
        values = []
        for name in ("damping", "friction"):
            value = dynamics.number(name, 0.0)
            if value < 0:
                what = f"the {name} of a joint is negative"
                raise BgError([wrong_value(dynamics.place(name), what, "give zero or more")])
            values.append(value)
        if any(values) and not kind.driven:
            cause = f"the friction of a {kind.value} joint is left out"
            self.notes.group(dynamics.span, cause, "add it to the generated file")
            return 0.0, 0.0
        return values[0], values[1]

    def _limits(
        self, element: Element, name: str, word: str
    ) -> tuple[float | None, float | None, float, float]:
        limit = element.first("limit")
        if limit is None:
            if word in ("revolute", "prismatic"):
                cause = f"a {word} joint without `<limit>` has no end stops"
                self.notes.group(element.span, cause, 'add `<limit lower=".." upper=".." ../>`')
            return None, None, 0.0, 0.0
        effort, velocity = limit.number("effort", 0.0), limit.number("velocity", 0.0)
        if word not in ("revolute", "prismatic"):
            return None, None, effort, velocity
        lower, upper = limit.number("lower", 0.0), limit.number("upper", 0.0)
        if lower >= upper:
            what = f"the limits of `{name}`, {lower:g} and {upper:g}, leave no range"
            self.notes.add(left_out(limit.span, what, "write `lower` below `upper`"))
            return None, None, effort, velocity
        return lower, upper, effort, velocity

    def _mimic(self, element: Element, name: str, kind: Kind) -> Mimicked | None:
        mimic = element.first("mimic")
        if mimic is None:
            return None
        if not kind.driven:
            cause = f"`<mimic>` of a {kind.value} joint is left out"
            self.notes.group(mimic.span, cause, "let a revolute or prismatic joint follow")
            return None
        ratio = mimic.number("multiplier", 1.0)
        return Mimicked(mimic.need("joint"), ratio, mimic.number("offset", 0.0))

    def _check_names(
        self, joint: Joint, links: Mapping[str, Link], joints: Mapping[str, Joint]
    ) -> None:
        element = next(e for e in self.root.all("joint") if e.span is joint.span)
        for tag, name in (("parent", joint.parent), ("child", joint.child)):
            end = element.first(tag)
            if name not in links and end is not None and not self._was_wrong("link", name):
                what = f"`{joint.name}` has the {tag} `{name}`, which is not a link of the robot"
                help = did_you_mean(name, links) or f'add `<link name="{name}"/>`'
                self.faults.append(wrong_structure(end.place("link"), what, help))
        if joint.mimic is not None and joint.mimic.leader not in joints:
            if self._was_wrong("joint", joint.mimic.leader):
                return
            what = f"`{joint.name}` follows `{joint.mimic.leader}`, which is not a joint"
            place = element.first("mimic")
            help = did_you_mean(joint.mimic.leader, joints) or "name a joint of the robot"
            span = joint.span if place is None else place.place("joint")
            self.faults.append(wrong_structure(span, what, help))

    def _was_wrong(self, tag: str, name: str) -> bool:
        """Return whether an element of that name exists, which has a fault of its own."""
        return any(e.attributes.get("name", "").strip() == name for e in self.root.all(tag))

    def _pose(self, element: Element) -> Pose:
        origin = element.first("origin")
        if origin is None:
            return Pose()
        x, y, z = origin.vector("xyz", _ZERO)
        return Pose((x, y, z), by_roll_pitch_yaw(origin.vector("rpy", _ZERO)))


def _within(element: Element, tags: tuple[str, ...]) -> float:
    """Read a number, the text or `value` of a child with any prefix of its tag; 0 without."""
    for child in element.children:
        if child.tag.rpartition(":")[2] in tags:
            if "value" not in child.attributes:
                child.attributes["value"] = child.text.strip()
            return child.number("value")
    return 0.0


def _colour(material: Element) -> str:
    """Write the colour of a material as `#rrggbb`; empty without one."""
    colour = material.first("color")
    if colour is None:
        return ""
    try:
        rgba = colour.vector("rgba", (0.5, 0.5, 0.5, 1.0))
    except BgError:
        return ""
    return "#" + "".join(f"{round(255 * min(max(c, 0), 1)):02x}" for c in rgba[:3])
