"""Random programs of bodies joined by transformers and gyrators, and their dense equations.

Each body has a full mass matrix of width 1 to 3. The matrices that join bodies read states, flows
and momenta, those of the bodies that they join among them. The reference is written from the same
drawing: the Newton-Euler equations with a force for each row of a transformer, whose rows are
differentiated by differences, solved densely at each instant.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

Values = dict[str, float]
Entry = tuple[str, Callable[[Values], float]]
_STEP = 1e-6  # for differences


def _entry(rng: random.Random, reads: Sequence[tuple[str, str]]) -> Entry:
    """An entry of a matrix: its text, and its value."""
    if rng.random() < 0.35:
        number = round(rng.uniform(-2, 2), 2) or 1.0
        return f"({number})", lambda v: number
    name, unit = rng.choice(reads)
    a, b = round(rng.uniform(0.3, 1.5), 2), round(rng.uniform(0.3, 1.2), 2)
    x = f"{name}/(1 {unit})" if unit else name
    forms: list[Entry] = [
        (f"({a} + {b}*sin({x}))", lambda v: a + b * np.sin(v[name])),
        (f"cos({a}*{x})", lambda v: np.cos(a * v[name])),
        (f"({a} + 0.1*{x})", lambda v: a + 0.1 * v[name]),
        (f"sin({x})", lambda v: np.sin(v[name])),
        (f"({a}*tanh({b}*{x}))", lambda v: a * np.tanh(b * v[name])),
    ]
    return rng.choice(forms)


@dataclass
class Joint:
    """A transformer (f2 = A f1) or gyrator (e2 = A f1) from one body to another."""

    first: int
    second: int
    entries: list[list[Entry]]

    def matrix(self, values: Values) -> np.ndarray:
        """A, at values of what it reads."""
        return np.array([[value(values) for _, value in row] for row in self.entries])


@dataclass
class Bodies:
    """A program, and what its dense equations need."""

    masses: list[np.ndarray] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    transformers: list[Joint] = field(default_factory=list)
    gyrators: list[Joint] = field(default_factory=list)
    dampings: dict[int, float] = field(default_factory=dict)
    stiffnesses: dict[int, float] = field(default_factory=dict)
    turns: int = 0  # the place of the flow that turns z
    pushed: int = 0  # the body that a force acts on

    def width(self, i: int) -> int:
        """The number of flows of a body."""
        return len(self.masses[i])

    def slice_of(self, i: int) -> slice:
        """The places of a body's flows."""
        first = sum(map(len, self.masses[:i]))
        return slice(first, first + self.width(i))

    def names(self, i: int, variable: str) -> list[str]:
        """A variable of a body, entry by entry."""
        size = self.width(i)
        return [f"{variable}[{k + 1}]" for k in range(size)] if size > 1 else [variable]

    @property
    def flows(self) -> list[str]:
        """The names of all flows."""
        return [name for i in range(len(self.masses)) for name in self.names(i, f"n{i}.f")]

    @property
    def observed(self) -> list[str]:
        """The states of the dense equations: z, all flows, the springs' charges."""
        charges = [name for i in self.stiffnesses for name in self.names(i, f"c{i}.q")]
        return ["z", *self.flows, *charges]

    def text(self, duration: float) -> str:
        """The program."""
        lines = "\n".join(f"  {line};" for line in self.lines)
        scene = f"observe {', '.join(self.observed)}; run {duration} s every {duration / 4} s;"
        return f"model Bodies {{\n{lines}\n}}\nscene s of Bodies {{ {scene} }}\n"

    def _values(self, z: float, flows: np.ndarray) -> Values:
        found = {"z": z}
        for i, mass in enumerate(self.masses):
            own = flows[self.slice_of(i)]
            found |= zip(self.names(i, f"n{i}.f"), own, strict=True)
            found |= zip(self.names(i, f"m{i}.p"), mass @ own, strict=True)
        return found

    def gaps(self, z: float, flows: np.ndarray) -> np.ndarray:
        """The rows of the transformers, `f2 - A f1`, which are zero."""
        values = self._values(z, flows)
        rows = [
            flows[self.slice_of(t.second)] - t.matrix(values) @ flows[self.slice_of(t.first)]
            for t in self.transformers
        ]
        return np.concatenate(rows) if rows else np.zeros(0)

    def rates(self, time: float, x: np.ndarray) -> np.ndarray:
        """The rates of z, the flows and the charges."""
        size = sum(map(len, self.masses))
        z, flows, charges = x[0], x[1 : 1 + size], x[1 + size :]
        values, at = self._values(z, flows), self.slice_of
        force, moved, turning = np.zeros(size), [], flows[self.turns]
        for g in self.gyrators:
            force[at(g.second)] += g.matrix(values) @ flows[at(g.first)]
            force[at(g.first)] -= g.matrix(values).T @ flows[at(g.second)]
        for i, damping in self.dampings.items():
            force[at(i)] -= damping * flows[at(i)]
        for i, stiffness in self.stiffnesses.items():
            force[at(i)] -= stiffness * charges[: self.width(i)]
            charges = charges[self.width(i) :]
            moved.append(flows[at(i)])
        force[at(self.pushed)] += np.cos(2 * time)
        mass, pulls = np.zeros((size, size)), []
        for i, own in enumerate(self.masses):
            mass[at(i), at(i)] = own
        for t in self.transformers:
            pull = np.zeros((self.width(t.second), size))
            pull[:, at(t.second)] = np.eye(self.width(t.second))
            pull[:, at(t.first)] -= t.matrix(values)
            pulls.append(pull)
        pull = np.vstack([np.zeros((0, size)), *pulls])
        steps = _STEP * np.eye(size)
        slopes = [(self.gaps(z, flows + d) - self.gaps(z, flows - d)) / (2 * _STEP) for d in steps]
        shift = _STEP * turning
        drift = (self.gaps(z + shift, flows) - self.gaps(z - shift, flows)) / (2 * _STEP)
        none = np.zeros((len(pull), len(pull)))
        system = np.block([[mass, pull.T], [np.array(slopes).T.reshape(-1, size), none]])
        changes = np.linalg.solve(system, [*force, *-drift])[:size]
        return np.concatenate([[turning], changes, *moved])


def draw_bodies(seed: int) -> Bodies:
    """Draw two to five bodies in a tree of transformers and gyrators."""
    rng = random.Random(seed)
    found, count = Bodies(), rng.randint(2, 5)
    add = found.lines.append
    for i in range(count):
        half = np.array([rng.uniform(-1, 1) for _ in range(9)])[: (size := rng.randint(1, 3)) ** 2]
        half = half.reshape(size, size)
        mass = np.round(half @ half.T + np.eye(size), 3)
        found.masses.append(mass)
        rows = ", ".join("[" + ", ".join(f"{x} kg" for x in row) + "]" for row in mass)
        wide = f"[{size}]" if size > 1 else ""
        add(f"n{i} : J1{wide}")
        add(f"m{i} : I{wide}([{rows}])" if size > 1 else f"m{i} : I({mass[0, 0]} kg)")
        add(f"n{i} -> m{i}")
    found.turns = rng.randrange(len(found.flows))
    add("state z = 0.3")
    add(f"der(z) = {found.flows[found.turns]}/(1 m)")
    reads = [("z", ""), *((name, "m/s") for name in found.flows)]
    reads += [(name, "N*s") for i in range(count) for name in found.names(i, f"m{i}.p")]
    for j in range(1, count):
        i = rng.randrange(j)
        chosen = reads if rng.random() < 0.7 else reads[:1]
        shape = [range(found.width(i))] * found.width(j)
        joint = Joint(i, j, [[_entry(rng, chosen) for _ in row] for row in shape])
        rows = "[" + ", ".join(f"[{', '.join(t for t, _ in row)}]" for row in joint.entries) + "]"
        wide = f"[{found.width(i)}, {found.width(j)}]"
        if wide == "[1, 1]":
            wide, rows = "", joint.entries[0][0][0]
        if rng.random() < 0.65:
            add(f"t{j} : MTF{wide} {{ f2 = {rows}*f1; }}")
            found.transformers.append(joint)
        else:
            add(f"t{j} : MGY{wide} {{ e2 = {rows}*(1 N*s/m)*f1; }}")
            found.gyrators.append(joint)
        add(f"n{i} -> t{j} -> n{j}")
    for i in range(count):
        wide = f"[{found.width(i)}]" if found.width(i) > 1 else ""
        if rng.random() < 0.5:
            found.dampings[i] = round(rng.uniform(0.2, 1), 2)
            add(f"r{i} : R{wide}({found.dampings[i]} N*s/m)")
            add(f"n{i} -> r{i}")
        if rng.random() < 0.4:
            found.stiffnesses[i] = round(rng.uniform(0.5, 3), 2)
            add(f"c{i} : C{wide}(stiffness = {found.stiffnesses[i]} N/m)")
            add(f"n{i} -> c{i}")
    found.pushed = rng.randrange(count)
    size, force = found.width(found.pushed), "1 N * cos(2*time/(1 s))"
    add(f"s : Se[{size}]([{', '.join([force] * size)}])" if size > 1 else f"s : Se({force})")
    add(f"s -> n{found.pushed}")
    return found
