"""The program: explicit state equations, ready to be optimised and emitted.

All nodes depend on PARAM, TIME, INPUT and STATE symbols only.
"""

from __future__ import annotations

from enum import Enum

from bgc.algebra.dag import Dag
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.ir.fields import StateIndex
from bgc.ir.graph import FmuUse, Guard, Held, Matrix, Node, Observation, Parameter, SampleRate
from bgc.ir.scene_nodes import DeviceUse, Requirement
from bgc.language.scene import Scene
from bgc.record_class import dataclass
from bgc.values.shown_units import Shown


@dataclass(frozen=True, slots=True)
class ProgramState:
    """State x[i]: `kind` is `momentum`, `displacement`, `declared` or `algebraic`.

    `scale`, a node of PARAM level, is the natural size of the state, by which its absolute
    tolerance is multiplied (the momentum of the smallest certain inertia at 1 m/s, a displacement
    of 1 unit, ...). The row of an `algebraic` state in the mass matrix is zero. `stores` names the
    elements whose momenta or displacements it holds: one, several for a merged state, else none.
    `shown` is the unit in which tables show it, None for `unit`. `stiffness` is the change of the
    effort by a displacement that is a storage state of its own, at the start with the parameters'
    defaults; 0 for others.
    """

    name: str
    unit: str
    kind: str
    initial: Node
    derivative: Node  # right-hand side f_i of M y' = f
    projection: Node | None
    scale: Node
    stores: tuple[str, ...] = ()
    shown: Shown | None = None
    stiffness: float = 0.0


@dataclass(frozen=True, slots=True)
class Start:
    """Equations that the runtime solves once, for initial values without a closed form.

    The `residuals` are zero; they depend on the unknowns (START symbols), PARAM, TIME and INPUT.
    `guess` is the solution with parameters at their defaults. State `number` of `values` starts at
    its node in the unknowns. `names` are the elements whose given values the equations satisfy.
    """

    residuals: tuple[Node, ...]
    guess: tuple[float, ...]
    values: tuple[tuple[StateIndex, Node], ...]
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class GivenValue:
    """An initial value that the user gives: `node`, of the start, has to be `value`.

    It is not obvious that it is: a law, a loop or a closed chain is solved for the start, or a
    state is projected. `is_default` is one that the model gives as zero; it holds unless parameters
    make it another. `is_rounded` is one whose digits may miss an invariant, as a quaternion's do.
    """

    node: Node
    value: Node
    variable: str  # `q0`, `p0`, `e0`, `f0`, `INITIAL_VALUE` of a declared state
    name: str  # of the element or state
    span: Span
    is_default: bool = False
    is_rounded: bool = False


@dataclass(frozen=True, slots=True)
class MassEntry:
    """One entry of M in `M y' = f`; a node of CONST or PARAM level."""

    row: StateIndex
    column: StateIndex
    value: Node


@dataclass(frozen=True, slots=True)
class Energy:
    """The energy accounts: stored energy in J, supplied and dissipated power in W."""

    stored: Node
    supplied: Node
    dissipated: Node


@dataclass(frozen=True, slots=True)
class PositiveParameter:
    """An expression of PARAM level that must be nonzero; positive if `strictly_positive`.

    One that is `finite` may be zero, but not infinite or undefined. One that is a `bound` is the
    least distance of a divisor that varies from zero, which no other node has to hold. `symmetric`
    is the place of the storage element if the check compares two mirrored entries of its matrix.
    """

    node: Node
    message: str
    strictly_positive: bool
    finite: bool = False
    bound: bool = False
    symmetric: Span | None = None


@dataclass(frozen=True, slots=True)
class Divisor:
    """A divisor that varies during a run and may vanish; `what` names what it belongs to."""

    node: Node
    what: str
    span: Span


@dataclass(frozen=True, slots=True)
class StateReset:
    """A reset of state `state` to the value of a node."""

    state: StateIndex
    value: Node


@dataclass(frozen=True, slots=True)
class StateJump:
    """A `when`: where the condition becomes nonzero, all its resets apply at once.

    The values are those before the jump. Of resets of one state at one instant the last applies.
    """

    condition: Node
    resets: tuple[StateReset, ...]
    span: Span


class LoopKind(Enum):
    """The way in which the variables of an algebraic loop enter its equations."""

    CONSTANT = "linear, its matrix from parameters alone"
    VARYING = "linear, its matrix from states or time"
    NONLINEAR = "nonlinear"


class LoopSolution(Enum):
    """The method that solves an algebraic loop."""

    ELIMINATION = "by unrolled elimination"
    CLOSED_FORM = "in closed form"
    NEWTON = "by Newton's method, as rows without a rate"


@dataclass(frozen=True, slots=True)
class Loop:
    """An algebraic loop: variables that depend on each other at the same instant.

    `bonds` are the bonds along the loop, `elements` those with laws in it. `torn` are the tearing
    variables, which are solved for together; all others follow from them one by one.
    """

    bonds: tuple[str, ...]
    elements: tuple[str, ...]
    torn: tuple[str, ...]
    kind: LoopKind
    solution: LoopSolution
    span: Span


@dataclass(frozen=True, slots=True)
class ClosedChain:
    """A closed chain of rigid connections: the parts along it, for messages."""

    names: tuple[str, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Closures:
    """Constraints of closed chains: rows of flows w and conditions on positions g, both zero.

    The first `kept` flows have a multiplier each, which the derivatives of the states contain
    already; the other rows follow from them. Of the kept rows of chain k, `ranks[k]` are
    independent. Where there are more, the runtime chooses that many by their pivots, anew along a
    run, and sets the selector of each to 1; a multiplier with a selector of 0 is 0. Selectors are
    SELECTOR symbols, or the constant 1 in a chain without a choice; at first the rows that come
    first in each chain are chosen. Likewise `held_rank` of the first `held` conditions are
    independent. Projection moves the states `impulses` along `response` until w is zero, and the
    states `moved` until g is zero.
    """

    chains: tuple[ClosedChain, ...]
    chain_of: tuple[int, ...]  # kept row -> its chain
    flows: tuple[Node, ...]
    kept: int
    ranks: tuple[int, ...]  # of the chains
    selectors: tuple[Node, ...]  # of the kept rows
    conditions: tuple[Node, ...]
    names: tuple[str, ...]  # of the conditions
    held: int
    held_rank: int
    impulses: tuple[StateIndex, ...]  # states (momenta) that the multipliers act on
    moved: tuple[StateIndex, ...]  # states in the conditions
    starts: tuple[Node, ...]  # parameters that may close the start
    by_impulse: Matrix  # dw/dx of the kept rows, by the states `impulses`
    response: Matrix  # a row for each of `impulses`: its rate by each multiplier
    by_place: Matrix  # dg/dx of the held conditions, by the states `moved`
    by_start: Matrix  # a row for each of `moved`: the derivatives of its start by `starts`


@dataclass(frozen=True, slots=True)
class SpeedEquations:
    """The equations that independent flows u of merged inertias satisfy, before they were solved.

    Flow k is `values[k]`, an expression of states. It is also the solution of `residuals`, where
    SPEED symbol k stands for it: 0 = pi_k - (N' M (N u + N_s s))_k. The nodes are in a DAG of their
    own: they are equal to others of the program by value, which must not be found.
    """

    dag: Dag
    values: tuple[Node, ...]
    residuals: tuple[Node, ...]


class Reason(Enum):
    """The reason why slicing removed a state."""

    UNREAD = "nothing that the scene reads depends on it"
    ZERO = "starts at zero and stays there"
    CONSTANT = "never changes"


@dataclass(frozen=True, slots=True)
class Dropped:
    """A state that slicing removed."""

    name: str
    reason: Reason


@dataclass(frozen=True, slots=True)
class Program:
    """`M y' = f(t, y, u, p)` with the observations, commands and guards of the scene.

    `mass` is None for the identity. The initial values of states that `start` sets are those at the
    parameters' defaults. `inputs` is the number of INPUT symbols. Initial values
    depend on PARAM symbols, and on TIME and INPUT symbols taken at the start.
    """

    dag: Dag
    scene: Scene
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
    dropped: tuple[Dropped, ...]  # states that slicing removed
    kept: tuple[str, ...] = ()  # paths of the states that slicing must retain
    divisors: tuple[Divisor, ...] = ()  # watched during a run
    loops: tuple[Loop, ...] = ()  # algebraic loops, in the order in which they are solved
    start: Start | None = None  # initial values that depend on parameters by equations
    given: tuple[GivenValue, ...] = ()  # checked at each start
    ignored_defaults: tuple[str, ...] = ()  # storage whose default start contradicts given values
    closures: Closures | None = None
    jumps: tuple[StateJump, ...] = ()
    held: tuple[Held, ...] = ()  # by sampled parts
    rates: tuple[SampleRate, ...] = ()
    coupling_energies: tuple[tuple[int, int, int], ...] = ()  # of each sampled port: INPUT symbols
    slots: int = 0  # INPUT symbols of held values, also of those that slicing removed
    warnings: tuple[Diagnostic, ...] = ()
    speeds: SpeedEquations | None = None
    fmus: tuple[FmuUse, ...] = ()
