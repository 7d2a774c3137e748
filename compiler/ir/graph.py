"""The flat bond graph: scalar bonds between elements, every law in the nodes of one DAG.

What elaboration makes and causality reads. No models, slots, widths or units of expressions
are left; what remains of them are names, spans and units for messages and tables.

Conventions
-----------
A bond's effort and flow are positive when power runs along its half arrow, tail to head.
A port's `sign` is +1 where the half arrow points into the element, -1 where it points out.
Of C, I and R the language only allows +1; the passes after elaboration accept both.
TF: port sets 1 (power in) and 2 (power out): `f2 = m f1`, `e1 = m' e2` for an n2 x n1 matrix m.
GY: `e1 = r' f2`, `e2 = r f1` for an n2 x n1 matrix r.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from bgc.algebra.dag import Dag
from bgc.algebra.nodes import Matrix as Matrix
from bgc.algebra.nodes import Node as Node
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


@dataclass(frozen=True, slots=True)
class Bond:
    """A scalar bond. `wide` names the bond it is component `component` (from 1) of.

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
        """`base -> hub`, or `base -> hub [3]` of a wide bond."""
        return self.wide if self.width == 1 else f"{self.wide} [{self.component}]"


@dataclass(frozen=True, slots=True)
class Port:
    """Where a bond meets an element: the bond, and +1 where its arrow points in."""

    bond: int
    sign: int


class Form(Enum):
    """Which way round a law is written.

    EFFORT: efforts in terms of the other variable: C `e = K q`, R `e = R f`.
    FLOW: flows in terms of it: I `f = W p`, R `f = G e`.
    DISPLACEMENT: `q = C e`.  MOMENTUM: `p = M f`.
    """

    EFFORT = "effort"
    FLOW = "flow"
    DISPLACEMENT = "displacement"
    MOMENTUM = "momentum"


@dataclass(frozen=True, slots=True)
class LinearLaw:
    """`left = matrix * right`, the two named by the form and the element's kind."""

    form: Form
    matrix: Matrix


@dataclass(frozen=True, slots=True)
class ExplicitLaw:
    """One node a port for the variable that `form` names, in the law's other variable.

    Of C: form EFFORT, nodes in DISPLACEMENT symbols. Of I: form FLOW, nodes in MOMENTUM
    symbols. Of R: form EFFORT with nodes in FLOW symbols of its bonds, or FLOW with EFFORT
    symbols. Symbols of its own bonds are taken in the element's sense (into the element).
    """

    form: Form
    nodes: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class EnergyLaw:
    """`H` in DISPLACEMENT (C), MOMENTUM (I) or both kinds of symbols (IC)."""

    energy: Node


Law: TypeAlias = LinearLaw | ExplicitLaw | EnergyLaw


@dataclass(frozen=True, slots=True)
class Junction:
    """A scalar J0 (common effort) or J1 (common flow), component of a wide one or alone."""

    name: str
    kind: str  # "J0" or "J1"
    ports: tuple[Port, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Source:
    """Se or Sf: sets its bond's effort or flow, in the bond's own sense, to `value`.

    (`Se(e = 5 V)` drives 5 V whichever way its arrow points.)
    """

    name: str
    kind: str  # "Se" or "Sf"
    port: Port
    value: Node
    span: Span


@dataclass(frozen=True, slots=True)
class Initial:
    """A given initial value of one storage port: `variable` is `q`, `p`, `e` or `f`.

    `yields` tells a zero that nobody chose: the default of a part's parameter or input, left
    alone. It holds as long as it contradicts nothing else.
    """

    port: int  # which port of the element
    variable: str
    value: Node
    span: Span
    yields: bool = False


@dataclass(frozen=True, slots=True)
class Storage:
    """C, I or IC, of any number of ports.

    `first_state` is the index of port 0 among the DISPLACEMENT (C), MOMENTUM (I) symbols;
    port k has `first_state + k`. An IC port has both symbols, at the same index.
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
    """R of any number of ports."""

    name: str
    ports: tuple[Port, ...]
    law: LinearLaw | ExplicitLaw
    span: Span

    @property
    def kind(self) -> str:
        """Its name in a drawing: R."""
        return "R"


@dataclass(frozen=True, slots=True)
class Transformer:
    """TF or MTF: `f2 = m f1`, `e1 = m' e2`; ports 1 have sign +1, ports 2 sign -1.

    `given` says which equation the user wrote: `matrix` is m for "f2" and "e1" (already
    transposed), and the matrix of `f1 = w f2`, `e2 = w' e1` for "f1" and "e2", in which case
    `matrix` is n1 x n2. A non-square matrix so fixes the causality. `inverse` is the matrix
    the other way round where it is known (a rotation's transpose), else None.
    """

    name: str
    given: str
    ports1: tuple[Port, ...]
    ports2: tuple[Port, ...]
    matrix: Matrix
    inverse: Matrix | None
    span: Span

    @property
    def kind(self) -> str:
        """Its name in a drawing: TF, also of an MTF."""
        return "TF"


@dataclass(frozen=True, slots=True)
class Gyrator:
    """GY or MGY: `e1 = r' f2`, `e2 = r f1`; ports 1 have sign +1, ports 2 sign -1."""

    name: str
    ports1: tuple[Port, ...]
    ports2: tuple[Port, ...]
    matrix: Matrix
    span: Span

    @property
    def kind(self) -> str:
        """Its name in a drawing: GY, also of an MGY."""
        return "GY"


@dataclass(frozen=True, slots=True)
class Gyristor:
    """A one-sided MGY: `e = S f` with skew S, on the ports of one wide bond (eq. 13)."""

    name: str
    ports: tuple[Port, ...]
    matrix: Matrix
    span: Span

    @property
    def kind(self) -> str:
        """Its name in a drawing: GY: an MGY on one side."""
        return "GY"


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
    """A run-time parameter, SI value. `index` is that of its PARAM symbol.

    `value` is its default, a node in constants and other parameters (recomputed when those
    change unless it was set itself). `low`, `high` bound it, None where open. `is_own` tells
    parameters of the scene's own model from those of its parts, `is_set` those which the scene
    or the command line gives a value.
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


@dataclass(frozen=True, slots=True)
class State:
    """A declared state, one component. `derivative` is None when only equations hold it."""

    index: int
    name: str
    unit: str
    initial: Node
    derivative: Node | None
    projection: Node | None  # what it is set to after each completed step
    span: Span


@dataclass(frozen=True, slots=True)
class Unknown:
    """A declared unknown, one component, with the value the solution is searched from."""

    index: int
    name: str
    unit: str
    start: Node
    span: Span


@dataclass(frozen=True, slots=True)
class Equation:
    """`residual = 0`, which may hold UNKNOWN and RATE symbols."""

    residual: Node
    span: Span


@dataclass(frozen=True, slots=True)
class Guard:
    """A condition that must stay nonzero (true); the run ends with the message otherwise."""

    condition: Node
    message: str
    span: Span


@dataclass(frozen=True, slots=True)
class Observation:
    """One scalar output: `name` as the header prints it (`tip[1]`), in SI units."""

    name: str
    unit: str
    node: Node
    span: Span


@dataclass(frozen=True, slots=True)
class Requirement:
    """The accuracy asked of an expression, one scalar component.

    `name` is the output that shows it: a column of the scene, or one of its own.
    """

    name: str
    unit: str
    node: Node
    tolerance: float
    span: Span


@dataclass(frozen=True, slots=True)
class DeviceUse:
    """A device of the scene: its name, driver, and the driver's options as text.

    `inputs` and `commands` list the channel components used, components counted from 1:
    `inputs[k] = (channel, component)` fills INPUT symbol `first_input + k`; `commands[k]` gets
    node k of `values`.
    """

    name: str
    driver: str
    options: tuple[tuple[str, str], ...]
    first_input: int
    inputs: tuple[tuple[str, int], ...]
    commands: tuple[tuple[str, int], ...]
    values: tuple[Node, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class SolverChoice:
    """`solver name(rtol = ..)`: options as SI numbers. Name `auto` picks by measurement."""

    name: str
    options: tuple[tuple[str, float], ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Plot:
    """A panel of the scene's plot: observed columns against another one, or None: time."""

    columns: tuple[str, ...]
    against: str | None


@dataclass(frozen=True, slots=True)
class SceneFacts:
    """What the scene says of the run; None where it says nothing."""

    name: str
    model: str
    solver: SolverChoice | None
    step: float | None
    duration: float | None
    every: float | None
    deadline: float | None
    accounts: tuple[str, ...]  # observed energy accounts: stored supplied dissipated residual
    columns: tuple[str, ...]  # all observed columns in order, the accounts among them
    plots: tuple[Plot, ...] = ()

    @property
    def needed_accounts(self) -> frozenset[str]:
        """Which of stored, supplied and dissipated are read; the residual takes all three."""
        basic = {"stored", "supplied", "dissipated"}
        return frozenset(basic if "residual" in self.accounts else basic & set(self.accounts))


@dataclass(frozen=True, slots=True)
class Slot:
    """A slot of the model: what it asks for, `Lock[5]`, and the model that fills it."""

    path: str
    interface: str
    dims: tuple[int, ...]
    filled_by: str


@dataclass(frozen=True, slots=True)
class FlatGraph:
    """A model ready for causality. `dag` is shared with, and grown by, the later passes."""

    dag: Dag
    scene: SceneFacts
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
    varied: int = 0  # INPUT symbols beyond those of the devices, which the caller sets
    slots: tuple[Slot, ...] = ()


def port_ends(graph: FlatGraph) -> Iterator[tuple[int, int, int]]:
    """The bond, the sign and the element of every port."""
    for index, element in enumerate(graph.elements):
        for port in ports_of(element):
            yield port.bond, port.sign, index
