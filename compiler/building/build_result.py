"""The result of a compilation: a shared object, and the facts of the scene that a run needs."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.ir.port_facts import FmuFacts, ForceFacts, PortFacts
from bgc.language.scene import Rest, Scene
from bgc.record_class import dataclass, field, fields
from bgc.values.shown_units import ShownRow

if TYPE_CHECKING:  # a warm start does not import the compiler's own modules
    from bgc.ir.graph import Observation, Parameter
    from bgc.ir.program import Program, ProgramState
    from bgc.ir.shapes import ShapeUse

ENERGY_ACCOUNTS = ("stored", "supplied", "dissipated", "residual")  # as rows of C have them


@dataclass(frozen=True, slots=True)
class ShownNames:
    """The outputs, states and parameters that are not shown in their SI unit.

    Each is a name, the unit in which tables and plots show it, and its factor.
    """

    outputs: tuple[ShownRow, ...] = ()
    states: tuple[ShownRow, ...] = ()
    parameters: tuple[ShownRow, ...] = ()


@dataclass(frozen=True, slots=True)
class RunFacts(Scene):
    """The record of a run, with what its compilation adds, in plain values.

    `folded` are the parameters compiled in as zeros and ones. `requirements` are the
    required accuracies by output; an output may be required without being a column. `content` is
    a hash of the emitted C without comments. `timed` is true where rates or observed powers depend
    explicitly on time. `passive` lists the parameters that a run should not make negative, each
    with its meaning and its element. `operations` counts those of each C function of the model.
    `resting` is a start at rest without held values and varied parameters. `shapes` is the JSON
    text of the recorded shapes, empty where none are recorded. `ports` are the sampled ports,
    `forces` what makes the force on each device, `slots` the paths of the slots with the models in
    them, `fmus` the FMUs of other tools.
    """

    folded: tuple[tuple[str, float], ...] = ()
    requirements: tuple[tuple[str, float], ...] = ()
    content: str = ""
    timed: bool = True
    passive: tuple[tuple[str, str, str], ...] = ()
    operations: tuple[tuple[str, int], ...] = ()
    shown: ShownNames = ShownNames()
    resting: Rest = field(default_factory=Rest)
    shapes: str = ""
    ports: tuple[PortFacts, ...] = ()
    forces: tuple[ForceFacts, ...] = ()
    slots: tuple[tuple[str, str], ...] = ()
    fmus: tuple[FmuFacts, ...] = ()

    def rest_for(self, start: str) -> Rest | None:
        """The start at rest of a run with `start` of `Solver`; None for one from given values."""
        if start == "given":
            return None
        return self.rest or (self.resting if start == "rest" else None)


def run_facts(scene: Scene, **added: Any) -> RunFacts:
    """Add to the record of a run what its compilation found, by the names of `RunFacts`."""
    return RunFacts(*(getattr(scene, each.name) for each in fields(scene)), **added)


@dataclass(frozen=True, slots=True)
class Place:
    """A place in the source that a run may report, with the states that it depends on."""

    span: Span | None
    states: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Places:
    """The places of a model's assertions, switches, divisors, jumps, given values ..

    All are in the order of its tables. `checks` are those of its checks of parameters; only those
    that a matrix is symmetric have a span, that of the storage element. `parameters` are those of a
    range and those that their values follow from; instead of states they name the parameters that
    the value reads directly.

    The places of given values name the variable and the element instead of states.
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
    fmus: tuple[Place, ...] = ()
    given: tuple[Place, ...] = ()
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
