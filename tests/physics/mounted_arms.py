"""Random trees on rigid joints, with mounts and axes as people write them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_FREEDOMS = {"floats": 6, "turns": 1, "slides": 1, "swings": 3, "fixed": 0, "clamped": 0}
_KINDS = ("turns", "turns", "turns", "slides", "swings", "fixed", "clamped")
_BASES = ("ground", "ground", "free", "body", "vessel")
# Angles of mounts in radians: none, one as exact as eleven digits, or any.
_ANGLES = ("0", "0", "1.57079632679", "-1.57079632679", "3.14159265359", "0.3", "any")
NOTHING_ALIGNED = tuple(round(0.1 * k, 1) for k in range(-1800, 1800))  # degrees
_MASS, _INERTIA = 40.0, (9.0, 11.0, 13.0)  # of a base that floats


@dataclass(frozen=True)
class MountedArm:
    """A scene `tree`, the same as a table for Pinocchio, and the states and rates of its joints.

    `kinds[k]` is the kind of joint k, `states[k]` the names of its position and attitude (of its
    coordinate), `base` the kind of base. The weight of a vessel rests on the water.
    """

    source: str
    table: str
    kinds: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    base: str

    @property
    def freedoms(self) -> tuple[int, ...]:
        """Degrees of freedom of each joint."""
        return tuple(_FREEDOMS[kind] for kind in self.kinds)

    def push(self, rotation: np.ndarray, gravity: float) -> np.ndarray:
        """The wrench of the surroundings on the base, in its axes."""
        rests = self.base == "vessel"
        return np.append(rotation.T @ [0, 0, _MASS * gravity * rests], np.zeros(3))


def mounted_arm(seed: int, bodies: int, base: str = "", angles: Sequence[float] = ()) -> MountedArm:
    """Bodies on a base, most axes along x, y or z, offsets with zeros among them.

    Mounts are absent, turned about an axis, by quarters written in eleven digits, or general; with
    `angles`, in degrees, all are turned by three of these.
    """
    rng = np.random.default_rng(seed)
    base = base or str(rng.choice(_BASES))
    parts, rows, kinds, states, observed = [], [], [], [], []
    if base != "ground":
        text, flow, names = _base(base)
        parts.append(text)
        rows.append(_row("b0", "-", "floats", *np.zeros((4, 3)), _MASS, np.diag(_INERTIA)))
        kinds.append("floats")
        states.append(names)
        observed.append(f"  observe {flow} as v0;\n")
    for k in range(len(kinds), bodies):
        parent = int(rng.integers(max(0, k - 2), k)) if k else -1
        kind = str(rng.choice(_KINDS if k else _KINDS[:5]))
        axis, axis_text = _axis(rng)
        turns, turns_text = _turns(rng, angles)
        origin = _vector(rng)
        centre = _vector(rng)
        mass = round(float(rng.uniform(1, 20)), 3)
        root = rng.uniform(-1, 1, (3, 3))
        inertia = (mass * (root @ root.T / 4 + 0.2 * np.eye(3))).round(6)
        before = "ground" if parent < 0 else f"node{parent}"
        if kind == "clamped":
            turns = np.array([round(float(rng.uniform(-3, 3)), 3), 0, 0])
        mount, joint = _joint(kind, axis_text, turns, turns_text, origin)
        upper = ", ".join(str(x) for x in inertia[np.triu_indices(3)])
        if mount:
            parts.append(f"  mount{k} : {mount};\n")
        parts.append(
            f"  joint{k} : {joint};\n  node{k} : J1;\n"
            f"  body{k} : HeavyBody(\n"
            f"    mass = {mass}, com = {_list(centre)}, inertia = symmetric({upper}));\n"
            f"  {before} -> {f'mount{k} -> ' if mount else ''}joint{k} -> node{k} -> body{k};\n"
        )
        parent_name = "-" if parent < 0 else f"b{parent}"
        rows.append(_row(f"b{k}", parent_name, kind, axis, origin, turns, centre, mass, inertia))
        kinds.append(kind)
        coordinate = {"turns": "angle", "slides": "extension", "swings": "attitude.h"}.get(kind)
        states.append((f"joint{k}.{coordinate}",) if coordinate else ())
        if coordinate:
            observed.append(f"  observe joint{k}.free.f as v{k};\n")
    source = (
        "import arms.link;\nimport marine.vessel;\n\nmodel Tree {\n  ground : Ground;\n"
        + "".join(parts)
        + ("  unused : Se[6](e = zeros(6));\n  ground -> unused;\n" if base != "ground" else "")
        + "}\n\nscene tree of Tree {\n"
        + "".join(observed)
        + "}\n"
    )
    if base == "free":
        source = source.replace("  unused : Se[6](e = zeros(6));\n  ground -> unused;\n", "")
    return MountedArm(source, "\n" + "".join(rows), tuple(kinds), tuple(states), base)


def _base(base: str) -> tuple[str, str, tuple[str, ...]]:
    """The text of a base that floats, its flow, and its position and attitude."""
    inertia = f"diag({_list(_INERTIA)})"
    match base:
        case "free":
            body = f"HeavyBody(mass = {_MASS}, inertia = {inertia})"
            part = f"  joint0 : Free;\n  body0 : {body};\n  ground -> joint0 -> node0 -> body0;\n"
            return f"  node0 : J1;\n{part}", "node0.f", ("joint0.position", "joint0.attitude.h")
        case "body":
            body = f"FreeBody(mass = {_MASS}, inertia = {inertia})"
            weight = (
                "  pull : Se[6](e = stack("
                f"-{_MASS}*gravity*(transpose(float.tip.A)*z), zeros(3)));\n  pull -> node0;\n"
            )
            part = f"  float : {body};\n  float -> node0;\n{weight}"
            return f"  node0 : J1;\n{part}", "node0.f", ("float.pose.r", "float.pose.attitude.h")
        case _:
            masses = _list((_MASS,) * 3 + _INERTIA)
            part = f"  float : Vessel(M_RB = diag({masses}));\n  float -> node0;\n"
            return f"  node0 : J1;\n{part}", "node0.f", ("float.pose.r", "float.pose.attitude.h")


def _axis(rng: np.random.Generator) -> tuple[np.ndarray, str]:
    if rng.random() < 0.8:
        k, sign = int(rng.integers(3)), int(rng.choice([1, 1, -1]))
        return sign * np.eye(3)[k], ("-" if sign < 0 else "") + "xyz"[k]
    axis = rng.integers(-9, 10, 3)
    axis[int(rng.integers(3))] += 10  # never zero
    return axis, f"{_list(axis)}/norm({_list(axis)})"


def _turns(rng: np.random.Generator, angles: Sequence[float]) -> tuple[np.ndarray, list[str]]:
    """Roll, pitch and yaw in degrees, and as text: of `angles`, in degrees, or in radians."""
    if angles:
        drawn = rng.choice(angles, 3)
        return drawn, [f"{x} deg" if x else "0" for x in drawn]
    texts = [str(rng.choice(_ANGLES)) for _ in range(3)]
    texts = [str(round(float(rng.uniform(-3, 3)), 11)) if t == "any" else t for t in texts]
    return np.degrees([float(t) for t in texts]), texts


def _vector(rng: np.random.Generator) -> np.ndarray:
    vector = rng.uniform(-1, 1, 3).round(3)
    vector[rng.random(3) < rng.choice([0, 0.4, 0.8])] = 0
    return vector


def _joint(
    kind: str, axis: str, turns: np.ndarray, texts: list[str], origin: np.ndarray
) -> tuple[str, str]:
    """The mount before a joint, if any, and the joint."""
    if kind == "clamped":
        return "", (
            f"Fixed(axis = {axis}, angle = {turns[0]} deg, offset = {_list(origin)}, "
            "lock = Rigid[6])"
        )
    about = [k for k in range(3) if texts[k] != "0"]
    match about:
        case []:
            mount = f"Mount(offset = {_list(origin)})" if origin.any() else ""
        case [k]:
            mount = f"Mount(offset = {_list(origin)}, axes = rot_{'xyz'[k]}({texts[k]}))"
        case _:
            mount = f"Mount(offset = {_list(origin)}, axes = euler_matrix([{', '.join(texts)}]))"
    joint = {
        "turns": f"Revolute(axis = {axis}, lock = Rigid[5])",
        "slides": f"Prismatic(axis = {axis}, lock = Rigid[5])",
        "swings": "Spherical(lock = Rigid[3])",
        "fixed": "Fixed(lock = Rigid[6])",
    }[kind]
    return mount, joint


def _row(name, before, kind, axis, origin, turns, centre, mass, inertia) -> str:
    numbers = " ".join(repr(float(x)) for x in (*axis, *origin, *turns))
    upper = inertia[np.triu_indices(3)]
    body = " ".join(repr(float(x)) for x in (mass, *centre, *upper))
    return f"{name} {before} {kind} {numbers}\n  {body}\n"


def _list(values: Sequence[float] | np.ndarray) -> str:
    return "[" + ", ".join(str(x) for x in np.asarray(values).tolist()) + "]"
