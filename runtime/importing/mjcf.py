"""Robots in MJCF, as MuJoCo compiles them: defaults, classes, angles and inertia from geoms.

Source: MuJoCo's documentation, chapters Computation and XML reference. The coordinate of a joint is
that of MuJoCo less `ref`.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.imported import left_out, not_importable, wrong_value
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source, Span
from bgc.language.shape_table import MESH_FILES
from bgc.runtime.importing.identifiers import free_name
from bgc.runtime.importing.inertia import body_of
from bgc.runtime.importing.link_tree import in_depth_first_order
from bgc.runtime.importing.notes import Notes
from bgc.runtime.importing.robot import (
    ORIGIN,
    Body,
    Joint,
    Kind,
    Link,
    Mimicked,
    Picture,
    Pose,
    Robot,
)
from bgc.runtime.importing.rotation_text import Vector, by_quaternion
from bgc.runtime.importing.xml_elements import Element, read_elements
from bgc.runtime.results.columns import optional_package

_EARTH = (0.0, 0.0, -9.81)
_NAMES = frozenset(("name", "class", "childclass", "model", "file"))
_NOT_FINITE = re.compile(r"(?<!\S)[+-]?(?:nan|inf|infinity)(?!\S)", re.IGNORECASE)
_CONTACT = "contacts are not imported"
# Flags of `<option>` that disable a part of every joint; PASSIVE is that of older versions.
_FLAGS = {
    "damping": ("DAMPER", "PASSIVE"),
    "friction": ("FRICTIONLOSS", "CONSTRAINT"),
    "stiffness": ("SPRING", "PASSIVE"),
}


def read_mjcf(source: Source, notes: Notes) -> Robot:
    """Read a robot.

    Raises
    ------
    BgError
        BG137 for a text that is not MJCF, BG138 with MuJoCo's own message where it refuses the
        model, BG058 without the package mujoco.
    """
    root = read_elements(source)
    if root.tag != "mujoco":
        what = f"the file has `<{root.tag[:40]}>` where MJCF has `<mujoco>`"
        help = "a URDF has the ending .urdf; other formats are not read"
        raise BgError([not_importable(what, root.span, help)])
    _check_finite(root)
    mujoco = optional_package("mujoco", "MJCF")
    try:
        with _messages(mujoco) as messages:
            spec = mujoco.MjSpec.from_file(source.name)
            model = spec.compile()
    except (ValueError, RuntimeError, mujoco.FatalError) as fault:
        raise BgError([_refused(source, str(fault))]) from None
    for message in dict.fromkeys(" ".join(each.split()) for each in messages):
        notes.add(left_out(root.span, f"MuJoCo warns: {message[:300]}", "correct it if it matters"))
    return _Mjcf(mujoco, spec, model, root, notes).read()


@contextmanager
def _messages(mujoco: Any) -> Iterator[list[str]]:
    """Collect the warnings of MuJoCo: it prints them, and writes a log in the working folder."""
    found: list[str] = []
    shown: list[warnings.WarningMessage] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(found.append)
    try:
        with warnings.catch_warnings(record=True) as shown:
            warnings.simplefilter("always", UserWarning)
            yield found
    finally:
        mujoco.set_mju_user_warning(before)
        found += [str(each.message) for each in shown]


def _check_finite(root: Element) -> None:
    """Raise BG138 for a number that is not finite: MuJoCo takes its default for NaN."""
    for element in root.walk():
        for attribute, text in element.attributes.items():
            found = None if attribute in _NAMES else _NOT_FINITE.search(text)
            if found is not None:
                what = f"`{attribute}` is not a number: {found[0]!r}"
                raise BgError([wrong_value(element.place(attribute), what, "write a number")])


def _refused(source: Source, message: str) -> Any:
    """The message of MuJoCo, at the line that it names."""
    found = re.search(r"line[ =]'?(\d+)", message)
    span = None
    if found is not None and 1 <= int(found[1]) <= len(source.line_starts):
        start = source.line_starts[int(found[1]) - 1]
        text = source.line(int(found[1]))
        start += len(text) - len(text.lstrip())
        span = Span(source, start, start + max(len(text.strip()), 1))
    words = " ".join(message.split())
    what = f"MuJoCo refuses the model: {words[:300]}"
    help = "correct the file; meshes and included files have to lie where it says"
    return wrong_value(span, what, help)


class _Mjcf:
    """Reads a compiled model."""

    def __init__(self, mujoco: Any, spec: Any, model: Any, root: Element, notes: Notes) -> None:
        self.mujoco, self.spec, self.model = mujoco, spec, model
        self.root = root
        self.notes = notes
        self.links: dict[str, Link] = {}
        self.joints: dict[str, Joint] = {}
        self.bodies: list[str] = []
        self.named: dict[int, str] = {}
        self.spans = self._places()

    def read(self) -> Robot:
        model = self.model
        for number in range(model.nbody):
            self._body(number)
        self._equalities()
        self._note_the_rest()
        gravity = ORIGIN if self._off("GRAVITY") else _vector(model.opt.gravity)
        source = self.root.span.source
        name = self.root.attributes.get("model", "").strip() or Path(source.name).stem
        robot = Robot(
            name,
            Path(source.name).name,
            "MJCF",
            self.links,
            self.joints,
            None if gravity == _EARTH else gravity,
        )
        return in_depth_first_order(robot, self.notes)

    def _off(self, *flags: str) -> bool:
        """Return whether `<flag>` of the model's options disables one of these parts of MuJoCo.

        A version of MuJoCo that lacks a flag never disables its part.
        """
        bits = (getattr(self.mujoco.mjtDisableBit, f"mjDSBL_{flag}", 0) for flag in flags)
        return any(int(bit) & int(self.model.opt.disableflags) for bit in bits)

    # --- bodies --------------------------------------------------------------------

    def _body(self, number: int) -> None:
        model = self.model
        name = self._unique(model.body(number).name or f"body_{number}")
        self.bodies.append(name)
        span = self.spans.get(("body", model.body(number).name))
        link = Link(name, self._mass(number, name, span), self._pictures(number), span)
        if number == 0:
            self.links[name] = link
            return
        parent = self.bodies[int(model.body_parentid[number])]
        place = Pose(_vector(model.body_pos[number]), by_quaternion(model.body_quat[number]))
        count, first = int(model.body_jntnum[number]), int(model.body_jntadr[number])
        after: Vector = ORIGIN
        for k in range(first, first + count):
            anchor = _vector(model.jnt_pos[k])
            child = name if k == first + count - 1 else self._unique(f"{name}_{k - first + 1}")
            if k > first:
                place = Pose(_difference(anchor, after))
            elif any(anchor):
                moved = np.array(place.origin) + place.axes.matrix @ anchor
                place = Pose(_vector(moved), place.axes)
            after = anchor
            behind = _difference(ORIGIN, anchor) if child == name else ORIGIN
            self._add_joint(k, parent, child, place, behind)
            if child != name:
                self.links[child] = Link(child)
            parent = child
        if not count:
            joint = self._unique_joint(f"{name}_fixed")
            self.joints[joint] = Joint(joint, Kind.FIXED, parent, name, place, span=span)
        self.links[name] = link

    def _mass(self, number: int, name: str, span: Span | None) -> Body | None:
        model = self.model
        if number == 0:
            return None
        centre = Pose(_vector(model.body_ipos[number]), by_quaternion(model.body_iquat[number]))
        tensor = np.diag(model.body_inertia[number])
        return body_of(float(model.body_mass[number]), centre, tensor, name, span, self.notes)

    # --- joints --------------------------------------------------------------------

    def _add_joint(self, k: int, parent: str, child: str, place: Pose, after: Vector) -> None:
        model, types = self.model, self.mujoco.mjtJoint
        kind = {
            types.mjJNT_FREE: Kind.FLOATS,
            types.mjJNT_BALL: Kind.BALL,
            types.mjJNT_SLIDE: Kind.SLIDES,
            types.mjJNT_HINGE: Kind.TURNS,
        }[types(int(model.jnt_type[k]))]
        title = model.joint(k).name
        name = self._unique_joint(title or f"{child}_joint")
        self.named[k] = name
        span = self.spans.get(("joint", title), self.spans.get(("freejoint", title)))
        dof = int(model.jnt_dofadr[k])
        size = {Kind.FLOATS: 6, Kind.BALL: 3}.get(kind, 1)
        damping = model.dof_damping[dof : dof + size]
        rotor = model.dof_armature[dof : dof + size]
        friction = model.dof_frictionloss[dof : dof + size]
        stiffness = float(np.ravel(model.jnt_stiffness[k])[0])
        self._refuse_curves(k, dof, name, span)
        reference = float(model.qpos0[model.jnt_qposadr[k]]) if kind.driven else 0.0
        limited = bool(model.jnt_limited[k]) and not self._off("LIMIT", "CONSTRAINT")
        lower, upper = (float(x) for x in model.jnt_range[k])
        given = {
            "damping": float(damping[0]),
            "friction": float(friction[0]),
            "rotor": float(rotor[0]),
            "stiffness": stiffness,
        }
        given |= {part: 0.0 for part, flags in _FLAGS.items() if self._off(*flags)}
        if not kind.driven:
            kept = {"damping", "rotor"} if kind is Kind.BALL else set()
            for what in [w for w, value in given.items() if value and w not in kept]:
                cause = f"the {what} of a {kind.value} joint is left out"
                self.notes.group(span, cause, "add it to the generated file")
            if limited:
                cause = f"the limit of a {kind.value} joint is left out"
                self.notes.group(span, cause, "add it to the generated file")
            given = {what: given[what] for what in kept}
        spring = float(model.qpos_spring[model.jnt_qposadr[k]]) if kind.driven else 0.0
        self.joints[name] = Joint(
            name,
            kind,
            parent,
            child,
            place,
            _vector(model.jnt_axis[k]) if kind.driven else (0.0, 0.0, 1.0),
            lower - reference if limited and kind.driven else None,
            upper - reference if limited and kind.driven else None,
            relaxed=spring - reference,
            after=after,
            note={Kind.TURNS: "hinge", Kind.SLIDES: "slide", Kind.FLOATS: "free"}.get(kind, ""),
            span=span,
            damping=given.get("damping", 0.0),
            friction=given.get("friction", 0.0),
            rotor=given.get("rotor", 0.0),
            stiffness=given.get("stiffness", 0.0),
        )
        if reference:
            what = f"the coordinate of `{name}` counts from its `ref`, {reference:g}"
            self.notes.add(left_out(span, what, f"add {reference:g} for MuJoCo's qpos"))

    def _refuse_curves(self, k: int, dof: int, name: str, span: Span | None) -> None:
        """Note springs and dampers that are not linear (since MuJoCo 3.4)."""
        model = self.model
        spring = getattr(model, "jnt_stiffnesspoly", None)
        damper = getattr(model, "dof_dampingpoly", None)
        curved = (spring is not None and spring[k].any()) or (
            damper is not None and damper[dof].any()
        )
        if curved:
            cause = "higher powers of a spring or damper are left out"
            self.notes.group(span, cause, "give the part a law in the generated file")

    def _equalities(self) -> None:
        model, types = self.model, self.mujoco.mjtEq
        if self._off("EQUALITY", "CONSTRAINT"):
            return
        for k in range(model.neq):
            kind = types(int(model.eq_type[k]))
            if not model.eq_active0[k]:
                continue
            span = self._equality_span(k)
            factors = model.eq_data[k][:5]
            if kind != types.mjEQ_JOINT or factors[2:].any():
                word = kind.name.removeprefix("mjEQ_").lower()
                cause = (
                    f"an equality `{word}` other than a linear coupling of two joints is left out"
                )
                help = "close a loop in the generated file with a `Weld`"
                self.notes.group(span, cause, help)
                continue
            follower = self.named[int(model.eq_obj1id[k])]
            if int(model.eq_obj2id[k]) < 0:
                cause = "an equality that holds one joint is left out"
                self.notes.group(span, cause, "hold it with a `RateSource`")
                continue
            mimic = Mimicked(
                self.named[int(model.eq_obj2id[k])], float(factors[1]), float(factors[0])
            )
            if self.joints[follower].mimic is not None:
                self.notes.group(span, "a second coupling of a joint is left out", "remove one")
                continue
            self.joints[follower] = replace(self.joints[follower], mimic=mimic)

    def _note_the_rest(self) -> None:
        """Note what has no counterpart."""
        model = self.model
        help = "add it to the generated file, where it matters"
        for count, cause in (
            (model.ntendon, "tendons are left out"),
            (model.nu, "actuators are left out: each hinge and slide has a drive"),
            (model.nflex, "flexible bodies are left out"),
            (
                model.npair + int(((model.geom_contype | model.geom_conaffinity) != 0).any()),
                _CONTACT,
            ),
            (int(model.opt.density > 0 or model.opt.viscosity > 0), "the fluid is left out"),
            (int(model.opt.wind.any()), "the wind is left out"),
            (int((model.body_gravcomp != 0).any()), "gravity compensation is left out"),
        ):
            if count:
                self.notes.group(self.root.span, cause, help)

    # --- pictures ------------------------------------------------------------------

    def _pictures(self, number: int) -> tuple[Picture, ...]:
        model = self.model
        first = int(model.body_geomadr[number])
        geoms = list(range(first, first + int(model.body_geomnum[number]))) if first >= 0 else []
        # By convention groups from 3 on are hidden: shapes for contacts.
        shown = [g for g in geoms if model.geom_group[g] < 3] or geoms
        return tuple(p for g in shown if (p := self._picture(g)) is not None)

    def _picture(self, g: int) -> Picture | None:
        model, types = self.model, self.mujoco.mjtGeom
        kind = types(int(model.geom_type[g]))
        size = [float(s) for s in model.geom_size[g]]
        pose = Pose(_vector(model.geom_pos[g]), by_quaternion(model.geom_quat[g]))
        colour = "#" + "".join(
            f"{round(255 * min(max(float(c), 0), 1)):02x}" for c in model.geom_rgba[g][:3]
        )
        match kind:
            case types.mjGEOM_BOX:
                return Picture("box", (2 * size[0], 2 * size[1], 2 * size[2]), pose, colour)
            case types.mjGEOM_SPHERE:
                return Picture("sphere", (size[0],), pose, colour)
            case types.mjGEOM_CYLINDER:
                return Picture("cylinder", (size[0], 2 * size[1]), pose, colour)
            case types.mjGEOM_CAPSULE:
                return Picture("capsule", (size[0], 2 * size[1]), pose, colour)
            case types.mjGEOM_MESH:
                return self._mesh(int(model.geom_dataid[g]), pose, colour)
        word = kind.name.removeprefix("mjGEOM_").lower()
        self.notes.group(self.root.span, f"the picture of a {word} is left out", "add a `shape`")
        return None

    def _mesh(self, k: int, pose: Pose, colour: str) -> Picture | None:
        """A mesh, which MuJoCo has moved to its centre and principal axes."""
        model = self.model
        title = model.mesh(k).name
        found = next((m for m in self.spec.meshes if m.name == title), None)
        folder = Path(self.root.span.source.name).parent
        scale = [float(s) for s in model.mesh_scale[k]]
        file = folder / (self.spec.meshdir or "") / (found.file if found is not None else "")
        if file.suffix.lower() not in MESH_FILES or len(set(scale)) > 1 or not file.is_file():
            cause = (
                f"a mesh that cannot be shown is left out ({file.suffix[:10] or 'without file'})"
            )
            help = f"convert it to one of {', '.join(MESH_FILES)}, with one scale"
            self.notes.group(self.root.span, cause, help)
            return None
        turned = by_quaternion(model.mesh_quat[k]).matrix
        axes = pose.axes.matrix @ turned.T
        origin = np.array(pose.origin) - axes @ np.array(model.mesh_pos[k])
        h = np.zeros(4)
        self.mujoco.mju_mat2Quat(h, axes.ravel())
        return Picture(
            "mesh", (scale[0],), Pose(_vector(origin), by_quaternion(h.tolist())), colour, file
        )

    # --- names and places ----------------------------------------------------------

    def _unique(self, name: str) -> str:
        return free_name(name, {*self.links, *self.bodies})

    def _unique_joint(self, name: str) -> str:
        return free_name(name, self.joints)

    def _places(self) -> dict[tuple[str, str], Span]:
        """Places of the elements with names, in the main file."""
        found: dict[tuple[str, str], Span] = {}
        stack = [self.root]
        while stack:
            element = stack.pop()
            found.setdefault((element.tag, element.attributes.get("name", "")), element.span)
            stack.extend(element.children)
        return found

    def _equality_span(self, k: int) -> Span | None:
        elements = [e for group in self.root.all("equality") for e in group.children]
        return elements[k].span if k < len(elements) else self.root.span


def _vector(values: Any) -> Vector:
    x, y, z = (0.0 if abs(v) < 1e-300 or math.isnan(v) else float(v) for v in values)
    return x, y, z


def _difference(a: Vector, b: Vector) -> Vector:
    return _vector(np.array(a) - np.array(b))
