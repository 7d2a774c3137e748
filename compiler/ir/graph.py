"""The flat bond graph: scalar bonds between elements, with all laws as nodes of one DAG.

It is the result of elaboration. Models, slots, widths and units of expressions are resolved;
names, spans and units remain for messages and tables.

Conventions
-----------
A bond's effort and flow are positive when power runs along its half arrow, tail to head.
A port's `sign` is +1 where the half arrow points into the element, -1 where it points out.
The language permits only +1 for C, I and R; the passes after elaboration accept both.
TF: ports 1 (power in) and ports 2 (power out): `f2 = m f1`, `e1 = m' e2`, m an n2 x n1 matrix.
GY: `e1 = r' f2`, `e2 = r f1`, r an n2 x n1 matrix.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, TypeAlias

from bgc.algebra.dag import Dag
from bgc.algebra.nodes import Matrix as Matrix
from bgc.algebra.nodes import Node as Node
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.ir.fields import BondIndex, RateIndex
from bgc.ir.scene_nodes import DeviceUse, Requirement
from bgc.ir.shapes import ShapeUse
from bgc.language.elements import Form as Form
from bgc.language.scene import Scene
from bgc.record_class import dataclass
from bgc.values.shown_units import Shown


@dataclass(frozen=True, slots=True)
class Bond:
    """A scalar bond: component `component` (from 1) of the bond named `wide`, of `width`.

    `power` is False in pseudo domains, whose effort times flow is not a power.
    """

    index: int
    wide: str
    component: int
    width: int
    effort_unit: str
    flow_unit: str
    power: bool
    span: Span

    @property
    def name(self) -> str:
        """`base -> hub`, or `base -> hub [3]` in a wide bond."""
        return self.wide if self.width == 1 else f"{self.wide} [{self.component}]"


@dataclass(frozen=True, slots=True)
class Port:
    """One end of a bond at an element; `sign` is +1 where the half arrow points in, else -1."""

    bond: BondIndex
    sign: int


@dataclass(frozen=True, slots=True)
class LinearLaw:
    """A law `left = matrix * right`; the form and the element's kind determine the variables."""

    form: Form
    matrix: Matrix


@dataclass(frozen=True, slots=True)
class ExplicitLaw:
    """A nonlinear law: one node per port for the variable of `form`.

    C: form EFFORT, nodes in DISPLACEMENT symbols. I: form FLOW, nodes in MOMENTUM symbols.
    R: form EFFORT with nodes in FLOW symbols of its bonds, or FLOW with EFFORT symbols. Symbols of
    the element's own bonds are taken in the element's sense (positive into the element).
    """

    form: Form
    nodes: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class EnergyLaw:
    """The energy `H` in DISPLACEMENT (C), MOMENTUM (I) or both kinds of symbols (IC)."""

    energy: Node


Law: TypeAlias = LinearLaw | ExplicitLaw | EnergyLaw


@dataclass(frozen=True, slots=True)
class Initial:
    """A value that is given for the start: `variable` is `q`, `p`, `e` or `f`.

    `port` is the position of a storage element's port, 0 at a junction. `is_default` marks a zero
    that is the default of a part's parameter or input. It is ignored where it contradicts other
    initial values.
    """

    port: int
    variable: str
    value: Node
    span: Span
    is_default: bool = False


@dataclass(frozen=True, slots=True)
class Junction:
    """A scalar J0 (common effort) or J1 (common flow), possibly a component of a wide one.

    `initial` is what its effort (J0) or flow (J1) has to be at the start, if anything.
    """

    name: str
    kind: str  # "J0" or "J1"
    ports: tuple[Port, ...]
    span: Span
    initial: Initial | None = None


@dataclass(frozen=True, slots=True)
class Source:
    """Se or Sf: sets its bond's effort or flow, in the bond's own sense, to `value`.

    `Se(e = 5 V)` imposes 5 V for either direction of its half arrow. A source that `follows` has a
    value that depends on its own bond's other variable: causality takes it as a resistance.
    """

    name: str
    kind: str  # "Se" or "Sf"
    port: Port
    value: Node
    span: Span
    follows: bool = False


@dataclass(frozen=True, slots=True)
class Storage:
    """C, I or IC with any number of ports.

    Port k has the DISPLACEMENT (C) or MOMENTUM (I) symbol `first_state + k`; an IC port has both,
    with the same index.
    """

    name: str
    kind: str  # "C", "I" or "IC"
    ports: tuple[Port, ...]
    law: Law
    first_state: int
    initial: tuple[Initial, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Resistor:
    """R with any number of ports."""

    name: str
    ports: tuple[Port, ...]
    law: LinearLaw | ExplicitLaw
    span: Span
    kind: ClassVar = "R"  # the label in drawings


@dataclass(frozen=True, slots=True)
class Transformer:
    """TF or MTF: `f2 = m f1`, `e1 = m' e2`; ports 1 have sign +1, ports 2 sign -1.

    `given` is the left side of the user's equation. For "f2" and "e1" `matrix` is m (n2 x n1);
    for "f1" and "e2" it is the matrix w (n1 x n2) of `f1 = w f2`, `e2 = w' e1`. A non-square
    matrix thereby determines the causality. `inverse` is the matrix of the opposite direction if
    the user gives it (for a rotation the transpose), else None.
    """

    name: str
    given: str
    ports1: tuple[Port, ...]
    ports2: tuple[Port, ...]
    matrix: Matrix
    inverse: Matrix | None
    span: Span
    kind: ClassVar = "TF"  # the label in drawings, also for an MTF


@dataclass(frozen=True, slots=True)
class Gyrator:
    """GY or MGY: `e1 = r' f2`, `e2 = r f1`; ports 1 have sign +1, ports 2 sign -1."""

    name: str
    ports1: tuple[Port, ...]
    ports2: tuple[Port, ...]
    matrix: Matrix
    span: Span
    kind: ClassVar = "GY"  # the label in drawings, also for an MGY


@dataclass(frozen=True, slots=True)
class Gyristor:
    """A one-sided MGY: `e = S f` with skew S, on the ports of one wide bond (eq. 13)."""

    name: str
    ports: tuple[Port, ...]
    matrix: Matrix
    span: Span
    kind: ClassVar = "GY"  # the label in drawings


Element: TypeAlias = Junction | Source | Storage | Resistor | Transformer | Gyrator | Gyristor


def ports_of(element: Element) -> tuple[Port, ...]:
    """All ports of an element; for a two-port, ports 1, then ports 2."""
    match element:
        case Source():
            return (element.port,)
        case Transformer() | Gyrator():
            return element.ports1 + element.ports2
        case _:
            return element.ports


@dataclass(frozen=True, slots=True)
class Parameter:
    """A run-time parameter in SI units. `index` is that of its PARAM symbol.

    `value` is its default, a node in constants and other parameters; it is recomputed when those
    change, unless the parameter itself is set. `low` and `high` are its bounds, None without one.
    `is_own` marks parameters of the scene's own model rather than its parts, `is_set` those that
    the scene or the command line sets. `shown` is the unit in which tables show it, None for
    `unit`.
    """

    index: int
    name: str
    unit: str
    value: Node
    low: float | None
    high: float | None
    span: Span
    is_own: bool = True
    is_set: bool = False
    shown: Shown | None = None


@dataclass(frozen=True, slots=True)
class State:
    """A component of a declared state; `derivative` is None where equations determine it.

    `shown` is the unit in which tables show it, None for `unit`.
    """

    index: int
    name: str
    unit: str
    initial: Node
    derivative: Node | None
    projection: Node | None  # the value to which each completed step projects it
    span: Span
    free: tuple[Node, ...] = ()  # the parameters that give `initial`, where nothing sets any
    shown: Shown | None = None


@dataclass(frozen=True, slots=True)
class Condition:
    """A component of `project x = value` where x is a signal: `residual = 0` holds by the bonds.

    Integration keeps it only within its tolerance; each completed step projects the states onto
    it. It also closes the start.
    """

    name: str
    residual: Node
    span: Span


@dataclass(frozen=True, slots=True)
class Unknown:
    """A component of a declared unknown; `start` is the initial guess of its solution.

    `shown` is the unit in which tables show it, None for `unit`.
    """

    index: int
    name: str
    unit: str
    start: Node
    span: Span
    shown: Shown | None = None


@dataclass(frozen=True, slots=True)
class Equation:
    """An equation `residual = 0`, which may contain UNKNOWN and RATE symbols."""

    residual: Node
    span: Span


@dataclass(frozen=True, slots=True)
class DataSource:
    """A data file that a model reads: its name in messages, its path, a hash of its content."""

    name: str
    path: str
    digest: str


@dataclass(frozen=True, slots=True)
class Guard:
    """A condition that must remain nonzero (true); otherwise the run ends with the message."""

    condition: Node
    message: str
    span: Span


@dataclass(frozen=True, slots=True)
class Reset:
    """A component of `reset x = value`.

    `target` is the STATE, DISPLACEMENT or MOMENTUM symbol that takes the value, `name` its name.
    """

    target: Node
    value: Node
    name: str
    span: Span


@dataclass(frozen=True, slots=True)
class Jump:
    """A `when`: its resets apply where the condition becomes nonzero (true)."""

    condition: Node
    resets: tuple[Reset, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class SampleRate:
    """The instants of sampled parts: `offset + k period`, k = 0, 1, .., in s; of PARAM level."""

    period: Node
    offset: Node
    span: Span


@dataclass(frozen=True, slots=True)
class Held:
    """A component of a state or output of a sampled part, INPUT symbol `index` between instants.

    At each instant of rate number `rate` it takes the value `update`, evaluated before all held
    values change. A state starts at `initial`, an output at zero.
    """

    index: int
    name: str
    unit: str
    initial: Node
    update: Node
    rate: RateIndex
    is_state: bool
    span: Span


@dataclass(frozen=True, slots=True)
class FmuLink:
    """A number that an FMU gives or takes, and the INPUT symbol of the value that is held for it.

    `role` is `parameter` (set at the start), `tunable` (a parameter, set where it changes), `input`
    (set at each instant) or `output`. `kind` is its type in FMI. It is number `place` of the
    `count` numbers behind `reference`. In SI units it is `factor * number + offset`. `start` is the
    number that a parameter has in the FMU, None where that is not known.
    """

    name: str
    reference: int
    kind: str
    role: str
    symbol: Node
    place: int
    count: int
    factor: float
    offset: float
    start: float | None


@dataclass(frozen=True, slots=True)
class FmuUse:
    """An FMU of another tool that takes a communication step at each instant of a sampled part.

    `file` is its name in messages, `path` where it lies, `digest` a hash of its content. `once`
    tells that a process may hold one instance of it. What is set comes before what is read, in the
    order of references.
    """

    name: str
    file: str
    path: str
    digest: str
    version: int
    identifier: str
    token: str
    once: bool
    links: tuple[FmuLink, ...]
    span: Span

    @property
    def symbols(self) -> tuple[Node, ...]:
        """The symbols of all its held values."""
        return tuple(link.symbol for link in self.links)


@dataclass(frozen=True, slots=True)
class SampledPort:
    """A virtual coupling between a device and the bonds named `name`, held over samples.

    `balance` is the energy in it at any time, J: that of the last instant less the work that its
    effort has done on the bond since. `coupling_energies` are the INPUT symbols of the energies
    that it has received from the device, dissipated, and created by sampling since the start. Its
    sources are the elements `name.source`. The other nodes are of PARAM level: stiffness, damping,
    the mass of the device, the resolution of its position, the lag in periods, and the period, s.
    """

    name: str
    width: int
    balance: Node
    coupling_energies: tuple[int, int, int]
    stiffness: Node
    damping: Node
    mass: Node
    resolution: Node
    lag: Node
    period: Node
    span: Span


@dataclass(frozen=True, slots=True)
class Observation:
    """A scalar output, named as in the header of the result (`tip[1]`).

    Its value is in `unit`, an SI unit unless the scene says `observe x in deg`. `shown` is the
    unit in which tables and plots show it, None for `unit`.
    """

    name: str
    unit: str
    node: Node
    span: Span
    shown: Shown | None = None


@dataclass(frozen=True, slots=True)
class Slot:
    """A slot of the model: its interface with dimensions (`Lock[5]`), and the model in it.

    `given` are the names of the arguments of that model.
    """

    path: str
    interface: str
    dims: tuple[int, ...]
    filled_by: str
    given: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Part:
    """An instance of a model, the scene's own with an empty path; `span` declares it.

    `dims` are the names of its model's dimensions, with their sizes.
    """

    path: str
    model: str
    span: Span
    dims: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, slots=True)
class FlatGraph:
    """A model as causality assignment expects it; later passes add nodes to its `dag`."""

    dag: Dag
    scene: Scene
    bonds: tuple[Bond, ...]
    elements: tuple[Element, ...]
    parameters: tuple[Parameter, ...]
    states: tuple[State, ...]
    unknowns: tuple[Unknown, ...]
    equations: tuple[Equation, ...]
    guards: tuple[Guard, ...]
    observations: tuple[Observation, ...]
    requirements: tuple[Requirement, ...]
    devices: tuple[DeviceUse, ...]
    kept: tuple[str, ...]
    warnings: tuple[Diagnostic, ...] = ()
    varied: int = 0  # additional INPUT symbols, after those of the devices, set by the caller
    slots: tuple[Slot, ...] = ()
    conditions: tuple[Condition, ...] = ()
    data: tuple[DataSource, ...] = ()
    shapes: tuple[ShapeUse, ...] = ()
    jumps: tuple[Jump, ...] = ()
    held: tuple[Held, ...] = ()
    rates: tuple[SampleRate, ...] = ()
    parts: tuple[Part, ...] = ()
    ports: tuple[SampledPort, ...] = ()
    solver_span: Span | None = None  # of the statement `solver`
    fmus: tuple[FmuUse, ...] = ()


def port_ends(graph: FlatGraph) -> Iterator[tuple[int, int, int]]:
    """The bond, the sign and the element of every port."""
    for index, element in enumerate(graph.elements):
        for port in ports_of(element):
            yield port.bond, port.sign, index
