"""Random trees of bodies on rigid joints: as a scene, and as a table for Pinocchio."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_KINDS = ("turns", "slides", "swings", "fixed")
_FREEDOMS = {"floats": 6, "turns": 1, "slides": 1, "swings": 3, "fixed": 0}


@dataclass(frozen=True)
class RandomArm:
    """A scene `tree`, the same as a table, and each joint's kind in the order of both."""

    source: str
    table: str
    kinds: tuple[str, ...]

    @property
    def freedoms(self) -> tuple[int, ...]:
        """Degrees of freedom of each joint."""
        return tuple(_FREEDOMS[kind] for kind in self.kinds)


def random_arm(seed: int, bodies: int, angles: Sequence[float] = ()) -> RandomArm:
    """Bodies each on one before, or on a base that stands or floats.

    Mounts are turned by the given angles in degrees; with none given nothing is aligned.
    """
    rng = np.random.default_rng(seed)
    floats = bool(rng.integers(2))
    kinds = ["floats" if floats else _draw(rng, _KINDS[:3])]
    parents = [-1]
    for k in range(1, bodies):
        kinds.append(_draw(rng, _KINDS))
        parents.append(int(rng.integers(max(0, k - 2), k)))
    parts, table, observed = [], [], []
    for k, (kind, parent) in enumerate(zip(kinds, parents, strict=True)):
        axis = rng.integers(-9, 10, 3)
        axis[int(rng.integers(3))] += 10  # never zero
        origin, centre = rng.uniform(-1, 1, (2, 3)).round(3)
        turns = rng.choice(angles, 3) if angles else rng.uniform(-180, 180, 3).round(1)
        mass = round(float(rng.uniform(1, 20)), 3)
        root = rng.uniform(-1, 1, (3, 3))
        inertia = (mass * (root @ root.T / 4 + 0.2 * np.eye(3))).round(6)
        if kind == "floats":  # from the ground's own frame
            origin, turns = np.zeros(3), np.zeros(3)
        before = "ground" if parent < 0 else f"node{parent}"
        parts.append(_part(k, kind, before, axis, origin, turns, mass, centre, inertia))
        table.append(_rows(k, kind, parent, axis, origin, turns, mass, centre, inertia))
        if _FREEDOMS[kind]:
            flow = f"node{k}.f" if kind == "floats" else f"joint{k}.free.f"
            observed.append(f"  observe {flow} as v{k};\n")
    source = (
        "import arms.link;\n\nmodel Tree {\n  ground : Ground;\n"
        + "".join(parts)
        + "}\n\nscene tree of Tree {\n"
        + "".join(observed)
        + "}\n"
    )
    return RandomArm(source, "\n" + "".join(table), tuple(kinds))


def _draw(rng: np.random.Generator, kinds: Sequence[str]) -> str:
    return kinds[int(rng.integers(len(kinds)))]


def _part(k, kind, before, axis, origin, turns, mass, centre, inertia) -> str:
    vector = f"{_list(axis)}/norm({_list(axis)})"
    joint = {
        "floats": "Free",
        "turns": f"Revolute(axis = {vector}, lock = Rigid[5])",
        "slides": f"Prismatic(axis = {vector}, lock = Rigid[5])",
        "swings": "Spherical(lock = Rigid[3])",
        "fixed": "Fixed(lock = Rigid[6])",
    }[kind]
    degrees = ", ".join(f"{x} deg" for x in turns)
    upper = ", ".join(str(x) for x in inertia[np.triu_indices(3)])
    return (
        f"  mount{k} : Mount(offset = {_list(origin)}, axes = euler_matrix([{degrees}]));\n"
        f"  joint{k} : {joint};\n"
        f"  node{k} : J1;\n"
        f"  body{k} : HeavyBody(\n"
        f"    mass = {mass}, com = {_list(centre)}, inertia = symmetric({upper}));\n"
        f"  {before} -> mount{k} -> joint{k} -> node{k} -> body{k};\n"
    )


def _rows(k, kind, parent, axis, origin, turns, mass, centre, inertia) -> str:
    before = "-" if parent < 0 else f"b{parent}"
    numbers = " ".join(str(x) for x in (*axis, *origin, *turns))
    body = " ".join(str(x) for x in (mass, *centre, *inertia[np.triu_indices(3)]))
    return f"b{k} {before} {kind} {numbers}\n  {body}\n"


def _list(values: object) -> str:
    return "[" + ", ".join(str(x) for x in np.asarray(values).tolist()) + "]"
