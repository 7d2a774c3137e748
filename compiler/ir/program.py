"""The program: assigned state equations, ready to be optimised and emitted.

All nodes are in PARAM, TIME, INPUT and STATE symbols only.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from bgc.algebra.dag import Dag
from bgc.diagnostics.source import Span
from bgc.ir.graph import DeviceUse, Guard, Node, Observation, Parameter, Requirement, SceneFacts


@dataclass(frozen=True, slots=True)
class ProgramState:
    """State x[i]: `kind` is `momentum`, `displacement`, `declared` or `algebraic`.

    `scale` weighs its absolute tolerance: 1 in the unit of the state (the momentum of the
    smallest certain inertia at 1 m/s, a displacement of 1 unit, ...), a node of PARAM level.
    The row of an `algebraic` state in the mass matrix is zero. `stores` names the elements whose
    momenta or charges it holds: one, of a merged state several, of any other state none.
    """

    name: str
    unit: str
    kind: str
    initial: Node
    derivative: Node  # right-hand side f_i of M y' = f
    projection: Node | None
    scale: Node
    stores: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class MassEntry:
    """One entry of M in `M y' = f`; a node of CONST or PARAM level."""

    row: int
    column: int
    value: Node


@dataclass(frozen=True, slots=True)
class Energy:
    """The accounts: stored energy now, power supplied by sources, power dissipated, in W."""

    stored: Node
    supplied: Node
    dissipated: Node


@dataclass(frozen=True, slots=True)
class PositiveParameter:
    """A node of PARAM level that was divided by: it must stay positive (or nonzero)."""

    node: Node
    message: str
    strictly_positive: bool


class LoopKind(Enum):
    """How the variables of an algebraic loop enter its equations."""

    CONSTANT = "linear, its matrix from parameters alone"
    VARYING = "linear, its matrix from states or time"
    NONLINEAR = "nonlinear"


class LoopSolution(Enum):
    """How an algebraic loop is closed."""

    ELIMINATION = "by unrolled elimination"
    CLOSED_FORM = "in closed form"
    NEWTON = "by Newton's method, as rows without a rate"


@dataclass(frozen=True, slots=True)
class Loop:
    """Variables that depend on each other at one instant.

    `bonds` are those it runs through, `elements` those whose laws are in it, and `torn` the
    variables that are solved for together; all others follow from them one by one.
    """

    bonds: tuple[str, ...]
    elements: tuple[str, ...]
    torn: tuple[str, ...]
    kind: LoopKind
    solution: LoopSolution
    span: Span


class Reason(Enum):
    """Why a state is not in the program."""

    UNREAD = "nothing that the scene reads depends on it"
    ZERO = "starts at zero and stays there"
    CONSTANT = "never changes"


@dataclass(frozen=True, slots=True)
class Dropped:
    """A state that slicing left out."""

    name: str
    reason: Reason


@dataclass(frozen=True, slots=True)
class Program:
    """`M y' = f(t, y, u, p)` with everything the scene reads.

    `mass` is None for the identity. Initial values are explicit, in PARAM symbols (and TIME,
    INPUT, at the start).
    """

    dag: Dag
    scene: SceneFacts
    parameters: tuple[Parameter, ...]
    states: tuple[ProgramState, ...]
    mass: tuple[MassEntry, ...] | None
    inputs: int
    observations: tuple[Observation, ...]
    requirements: tuple[Requirement, ...]
    devices: tuple[DeviceUse, ...]
    guards: tuple[Guard, ...]
    energy: Energy
    positive: tuple[PositiveParameter, ...]
    dropped: tuple[Dropped, ...]  # states that slicing left out
    kept: tuple[str, ...] = ()  # names of what slicing must not leave out
    loops: tuple[Loop, ...] = ()  # algebraic loops, in the order in which they are solved
    yielded: tuple[str, ...] = ()  # storage whose initial defaults gave way to what was given
