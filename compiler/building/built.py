"""The result of a compilation: a shared object, and the facts of the scene that a run needs."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.language.columns import AccountColumn
from bgc.values.shown import ShownRow

if TYPE_CHECKING:  # a warm start does not import the compiler's own modules
    from bgc.ir.graph import Observation, Parameter
    from bgc.ir.port_facts import ForceFacts, PortFacts
    from bgc.ir.program import Program, ProgramState
    from bgc.ir.scene import Requirement, SceneFacts
    from bgc.ir.shapes import ShapeUse

ENERGY_ACCOUNTS = ("stored", "supplied", "dissipated", "residual")  # as rows of C have them


@dataclass(frozen=True, slots=True)
class Panel:
    """Columns to draw together, against the column `across`: `time`, or another one."""

    columns: tuple[str, ...]
    across: str = "time"


@dataclass(frozen=True, slots=True)
class Sampled:
    """A value that a sampled part holds: its number among all such values."""

    number: int
    name: str
    unit: str


@dataclass(frozen=True, slots=True)
class Rest:
    """A start at rest: the outputs whose values are held, and the parameters that are varied.

    `momenta` are the indices of the states that are momenta, `sampled` the values of sampled parts,
    without those of sampled ports.
    """

    hold: tuple[str, ...] = ()
    vary: tuple[str, ...] = ()
    momenta: tuple[int, ...] = ()
    sampled: tuple[Sampled, ...] = ()


@dataclass(frozen=True, slots=True)
class RunFacts:
    """The run settings of a scene, in plain values; None where the scene gives none.

    `columns` are the observed names in the scene's order. Columns that are not outputs of the
    model are energy accounts, which `accounts` lists. Times are in seconds, `solver_options` are SI
    numbers. `folded` are the parameters compiled in as zeros and ones. `requirements` are the
    required accuracies by output; an output may be required without being a column. `content` is
    a hash of the emitted C without comments. `timed` is true where rates or observed powers depend
    explicitly on time. `passive` lists the parameters that a run should not make negative, each
    with its meaning and its element. `operations` counts those of each C function of the model.
    `shown_outputs`, `shown_states` and `shown_parameters` list those that tables and plots show in
    a unit other than their SI unit: a name, the unit and its factor.
    `rest` is the scene's start at rest; None where it starts from the initial values that are
    given, and `resting` one without held values and varied parameters. `shapes` is the JSON text of
    the recorded shapes, empty where none are recorded. `overrun` is the policy of a loop in real
    time that is late, None where the scene gives none. `criteria` are limits of columns, as
    `bgc operability` reads them. `ports` are the sampled ports, `forces` what makes the force on
    each device, `slots` the paths of the slots with the models in them.
    """

    scene: str
    model: str
    columns: tuple[str, ...]
    accounts: tuple[AccountColumn, ...] = ()
    solver: str | None = None
    solver_options: tuple[tuple[str, float], ...] = ()
    step: float | None = None
    duration: float | None = None
    every: float | None = None
    deadline: float | None = None
    panels: tuple[Panel, ...] = ()
    folded: tuple[tuple[str, float], ...] = ()
    requirements: tuple[tuple[str, float], ...] = ()
    content: str = ""
    timed: bool = True
    passive: tuple[tuple[str, str, str], ...] = ()
    operations: tuple[tuple[str, int], ...] = ()
    shown_outputs: tuple[ShownRow, ...] = ()
    shown_states: tuple[ShownRow, ...] = ()
    shown_parameters: tuple[ShownRow, ...] = ()
    rest: Rest | None = None
    resting: Rest = Rest()
    shapes: str = ""
    overrun: str | None = None
    criteria: tuple[str, ...] = ()
    ports: tuple[PortFacts, ...] = ()
    forces: tuple[ForceFacts, ...] = ()
    slots: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Place:
    """A place in the source that a run may report, with the states that it depends on."""

    span: Span | None
    states: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Places:
    """The places of a model's assertions, switches, divisors, jumps, held values and ports.

    All are in the order of its tables. `checks` are those of its checks of parameters; only those
    that a matrix is symmetric have a span, that of the storage element. `parameters` are those of a
    range and those that their values follow from; instead of states they name the parameters that
    the value reads directly.

    `start` names the elements whose initial values the runtime solves for; `loops` are the
    algebraic loops that it solves, each with the names of its states and of its elements.
    """

    assertions: tuple[Place, ...] = ()
    switches: tuple[Place, ...] = ()
    divisors: tuple[Place, ...] = ()
    start: tuple[str, ...] = ()
    loops: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = ()
    jumps: tuple[Place, ...] = ()
    held: tuple[Place, ...] = ()
    ports: tuple[Place, ...] = ()
    checks: tuple[Place, ...] = ()
    parameters: tuple[Place, ...] = ()


@dataclass(frozen=True, slots=True)
class Built:
    """A model that is ready to load. `warm` is true where it came from the cache."""

    library: Path
    facts: RunFacts
    warnings: tuple[Diagnostic, ...] = ()
    warm: bool = False
    places: Places = Places()


@dataclass(frozen=True, slots=True)
class ShownNames:
    """The outputs, states and parameters that are not shown in their SI unit."""

    outputs: tuple[ShownRow, ...] = ()
    states: tuple[ShownRow, ...] = ()
    parameters: tuple[ShownRow, ...] = ()


def shown_names(program: Program) -> ShownNames:
    """The units as written of a program's outputs, states and parameters."""
    lists = (program.observations, program.states, program.parameters)
    return ShownNames(*(tuple(_shown_rows(named)) for named in lists))


def _shown_rows(named: Iterable[Observation | ProgramState | Parameter]) -> Iterator[ShownRow]:
    for each in named:
        if each.shown is not None:
            yield each.name, each.shown.unit, each.shown.factor


def shapes_text(shapes: Sequence[ShapeUse]) -> str:
    """Write recorded shapes as JSON: for each quantity its numbers, or the outputs that hold it."""
    return json.dumps(
        [
            {
                "name": shape.name,
                "part": shape.part,
                "kind": shape.kind,
                "colour": shape.colour,
                "file": shape.file,
                "values": [
                    [v.field, v.shape, v.numbers if v.numbers is not None else v.columns]
                    for v in shape.values
                ],
            }
            for shape in shapes
        ]
    )


def run_facts(
    scene: SceneFacts,
    folded: tuple[tuple[str, float], ...] = (),
    requirements: Sequence[Requirement] = (),
    content: str = "",
    timed: bool = True,
    passive: tuple[tuple[str, str, str], ...] = (),
    operations: tuple[tuple[str, int], ...] = (),
    shown: ShownNames = ShownNames(),
    resting: Rest = Rest(),
    shapes: str = "",
    ports: tuple[PortFacts, ...] = (),
    forces: tuple[ForceFacts, ...] = (),
    slots: tuple[tuple[str, str], ...] = (),
) -> RunFacts:
    """Collect the run settings of a scene, with the folded parameters and the requirements."""
    solver = scene.solver
    return RunFacts(
        scene=scene.name,
        model=scene.model,
        columns=scene.columns,
        accounts=scene.accounts,
        solver=solver.name if solver else None,
        solver_options=solver.options if solver else (),
        step=scene.step,
        duration=scene.duration,
        every=scene.every,
        deadline=scene.deadline,
        panels=tuple(Panel(plot.columns, plot.against or "time") for plot in scene.plots),
        folded=folded,
        requirements=tuple((r.name, r.tolerance) for r in requirements),
        content=content,
        timed=timed,
        passive=passive,
        operations=operations,
        shown_outputs=shown.outputs,
        shown_states=shown.states,
        shown_parameters=shown.parameters,
        rest=None if (r := scene.rest) is None else replace(resting, hold=r.hold, vary=r.vary),
        resting=resting,
        shapes=shapes,
        overrun=scene.overrun,
        criteria=scene.criteria,
        ports=ports,
        forces=forces,
        slots=slots,
    )
