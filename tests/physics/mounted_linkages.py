"""Planar linkages in space at random, with mounts between bodies and joints as people write them.

All axes of a linkage are parallel, in a direction that may be any. Each body has its own axes, and
each joint its own. Mounts relate them: none, by quarter turns, by turns whose cosine is 0.6, or by
general turns in 11 or 17 digits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

KINDS = ("four_bar", "parallelogram", "slider_crank", "triangle")
MOUNTS = ("quarter", "rational", "eleven", "general")
BASES = ("ground", "body", "driven")

MASSES = (3.0, 8.0, 5.0)
RATE = 1.3  # rad/s, of a driven crank
_SIDE = 0.1
_TORQUE = 30.0
_JOINTS = {"four_bar": "rrrr", "parallelogram": "rrrr", "slider_crank": "rrrp", "triangle": "rrpr"}
BASE_MASS = 40.0
_BASE_INERTIA = np.diag([9.0, 11.0, 13.0])
_PLANE = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])  # columns: along, upwards, normal (-y)
_TURNS = {
    "quarter": ((0.0, 1.0), (0.0, -1.0), (-1.0, 0.0)),
    "rational": ((0.6, 0.8), (0.8, -0.6), (-0.6, 0.8)),
}


@dataclass(frozen=True)
class MountedLinkage:
    """A scene `linkage`, and the linkage in its plane.

    `lengths` are those of the bars; the last joint is at `foot`. `joints` has r for a pin, p for a
    slide. The scene observes the coordinates of the joints as q0 .. q3, their rates as v0 .. v3,
    the centres of the bars in the world as c0 .. c2, the place of a base that floats as r, the gap
    and the energies.
    """

    source: str
    joints: str
    lengths: tuple[float, ...]
    foot: float

    def misfit(self, q: np.ndarray, v: np.ndarray) -> float:
        """The gap that coordinates (rows: times) and rates leave, in m, rad, m/s and rad/s."""
        turned, turning = np.zeros((2, len(q)))
        end, moving = np.zeros((2, len(q)), complex)
        for k, joint in enumerate(self.joints):
            if joint == "r":
                turned, turning = turned + q[:, k], turning + v[:, k]
            else:
                end += q[:, k] * np.exp(1j * turned)
                moving += (v[:, k] + 1j * turning * q[:, k]) * np.exp(1j * turned)
            if k < len(self.lengths):
                bar = self.lengths[k] * np.exp(1j * turned)
                end, moving = end + bar, moving + 1j * turning * bar
        gaps = (end - self.foot, moving, 2 * np.sin(turned / 2), turning)
        return max(np.abs(gap).max() for gap in gaps)


def mounted_linkage(
    seed: int, kind: str, mounts: str, base: str = "ground", places: int = 4, digits: int = 0
) -> MountedLinkage:
    """A linkage with its own axes at some joints and bodies, as many of each as `places`.

    `digits` are the decimals of all mounts, axes and moments, by default those of the kind.
    """
    rng = np.random.default_rng(seed)
    lengths, foot, angle = _shape(rng, kind)
    joints = _JOINTS[kind]
    with_joint, with_body = (set(rng.permutation(4)[:places].tolist()) for _ in range(2))
    tilt = _drawn(rng, mounts) if places else np.eye(3)
    start = frame = tilt if base == "body" else np.eye(3)
    along, _, normal = (tilt @ _PLANE).T
    digits = digits or (11 if mounts == "eleven" else 17)
    parts, chain, offset = [], ["root"], np.zeros(3)

    def mounted(name: str, after: np.ndarray) -> np.ndarray:
        if not np.array_equal(after, frame) or offset.any():
            table = _table(frame.T @ after, digits)
            parts.append(
                f"  {name} : Mount(axes = {table}, offset = {_list(frame.T @ offset, digits)});\n"
            )
            chain.append(name)
        return after

    for k, joint in enumerate(joints):
        frame = mounted(f"to{k}", _drawn(rng, mounts) if k in with_joint else frame)
        axis = _list(frame.T @ (normal if joint == "r" else along), digits)
        own = f", angle0 = {angle!r}" if not k else ""
        if not k and base == "body":
            own += f", torque = {_TORQUE}"
        named = "Revolute" if joint == "r" else "Prismatic"
        powered = "Powered" if not k and base == "driven" else ""
        parts.append(f"  pin{k} : {powered}{named}(axis = {axis}{own}, lock = Rigid[5]);\n")
        chain.append(f"pin{k}")
        offset = np.zeros(3)
        if k == len(lengths):
            break
        frame = mounted(f"off{k}", _drawn(rng, mounts) if k in with_body else frame)
        parts.append(_body(k, lengths[k], frame.T @ tilt @ _PLANE, digits))
        chain.append(f"bar{k}")
        offset = along * lengths[k]
    table = _table(start.T @ frame, digits)
    parts.append(
        f"  far : Mount(axes = {table}, offset = {_list(start.T @ along * foot, digits)});\n"
    )
    source = _text(base, joints, parts, chain)
    return MountedLinkage(source, joints, lengths, foot)


def _shape(rng: np.random.Generator, kind: str) -> tuple[tuple[float, ...], float, float]:
    """Lengths of the bars, place of the last joint, and angle of the first bar."""
    stretch = [round(float(x), 3) for x in rng.uniform(0.9, 1.1, 4)]
    angle = round(float(rng.uniform(0.7, 2.0)), 3)
    match kind:
        case "four_bar":
            return (stretch[0], 2.5 * stretch[1], 1.8 * stretch[2]), 2.4 * stretch[3], angle
        case "parallelogram":
            return (stretch[0], 2 * stretch[1], stretch[0]), 2 * stretch[1], angle
        case "slider_crank":
            return (0.5 * stretch[0], 1.5 * stretch[1], 0.0), 3.0 * stretch[2], angle
        case _:
            return (2 * stretch[0], 0.8 * stretch[1], 0.7 * stretch[2]), 0.9 * stretch[3], angle


def _drawn(rng: np.random.Generator, mounts: str) -> np.ndarray:
    """A rotation; of the exact kinds, two turns about different coordinate axes."""
    if mounts not in _TURNS:
        return Rotation.random(random_state=rng).as_matrix()
    whole = np.eye(3)
    for k in rng.choice(3, 2, replace=False):
        c, s = _TURNS[mounts][rng.integers(3)]
        i, j = (k + 1) % 3, (k + 2) % 3
        turn = np.eye(3)
        turn[i, i] = turn[j, j] = c
        turn[i, j], turn[j, i] = -s, s
        whole = whole @ turn
    return whole


def _body(k: int, length: float, axes: np.ndarray, digits: int) -> str:
    """A bar whose direction, breadth and height are the columns of `axes`."""
    mass = MASSES[k]
    across = mass * (length**2 + _SIDE**2) / 12
    inertia = axes @ np.diag([mass * _SIDE**2 / 6, across, across]) @ axes.T
    upper = ", ".join(_number(x, digits) for x in inertia[np.triu_indices(3)])
    com = _list(axes[:, 0] * length / 2, digits)
    return (
        f"  bar{k} : J1;\n  mass{k} : HeavyBody(mass = {mass}, com = {com},"
        f" inertia = symmetric({upper}));\n  bar{k} -> mass{k};\n"
    )


def _text(base: str, joints: str, parts: list[str], chain: list[str]) -> str:
    observed = "".join(
        f"  observe pin{k}.{'angle' if joint == 'r' else 'extension'} as q{k},"
        f" pin{k}.free.f as v{k};\n"
        for k, joint in enumerate(joints)
    )
    observed += "  observe mass0.centre as c0, mass1.centre as c1, mass2.centre as c2;\n"
    match base:
        case "body":
            float_ = f"FreeBody(mass = {BASE_MASS}, inertia = {_table(_BASE_INERTIA, 17)})"
            root = f"  float : {float_};\n  root : J1;\n  float -> root;\n"
            observed += "  observe float.tip.r as r;\n"
        case _:
            root = "  ground : Ground;\n  root : J1;\n  ground -> root;\n"
    if base == "driven":
        root += f"  drive : Sf(f = {RATE} rad/s);\n  pin0.shaft -> drive;\n"
    return (
        "import arms.link;\nimport mechanics.closing;\n\nmodel Linkage {\n"
        f"{root}{''.join(parts)}  weld : Weld;\n"
        f"  {' -> '.join(chain)} -> weld.b;\n  root -> far -> weld.a;\n}}\n\n"
        f"scene linkage of Linkage {{\n{observed}"
        "  observe weld.gap as gap, energy.residual, energy.stored;\n"
        "  solver rodas5p(rtol = 1e-10);\n  run 0.5 s every 0.05 s;\n}\n"
    )


def _number(x: float, digits: int) -> str:
    """A number with so many decimals, without those that rounding makes up."""
    return f"{round(float(x), min(digits, 16)) + 0.0:.{digits}f}".rstrip("0").rstrip(".") or "0"


def _list(values: np.ndarray, digits: int) -> str:
    return f"[{', '.join(_number(x, digits) for x in values)}]"


def _table(rows: np.ndarray, digits: int) -> str:
    return f"[{', '.join(_list(row, digits) for row in rows)}]"
