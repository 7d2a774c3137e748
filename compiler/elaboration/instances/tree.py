"""Data of the instance tree: models with arguments, filled slots, expanded loops and `if`.

The tree is mutable while elaboration builds it and discarded afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import TypeAlias, TypeVar

from bgc.diagnostics.source import Span
from bgc.elaboration.instances.faces import Face
from bgc.grammar import syntax
from bgc.language.elements import ELEMENTS, ElementKind
from bgc.record_class import dataclass, field
from bgc.resolution.modules import Declared, Module
from bgc.values.fmu_files import FmuFile, FmuVariable
from bgc.values.scope import Namespace
from bgc.values.units import Dimension
from bgc.values.value import Value

_Item = TypeVar("_Item", bound=syntax.Item)


@dataclass(slots=True, eq=False)
class Environment:
    """The scope in which an expression was written.

    `instance` is None at file level; that of a scene is set when its model is instantiated.
    `locals` hold the dimensions of a model, the devices of a scene and, within a `for`, its
    variable and the values declared there.
    """

    instance: Instance | None
    module: Module
    locals: dict[str, Value | Quantity | Namespace]

    def nested(self) -> Environment:
        """A copy with its own locals, for one iteration of a `for`."""
        return Environment(self.instance, self.module, dict(self.locals))


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """An expression with its environment: an argument, a `set`, a `use`, a `drive`, a default."""

    value: syntax.Expr
    env: Environment
    span: Span


class Status(Enum):
    """The progress of the lazy evaluation of a quantity or part."""

    NEW = 0
    OPEN = 1
    DONE = 2
    FAILED = 3


@dataclass(slots=True, eq=False)
class Quantity:
    """A named value of an instance: `param const let signal input output state unknown`.

    `given` replaces its default; `parts` replace single components (`set M[1, 2] = ..`).
    `first` is the index of the first symbol of a param, state or unknown, or of a value that a
    sampled part holds (`sampled`). A `const` may be `data` of a file instead of a value. `units`
    are those of the components of a value that goes to an FMU or comes from one.
    """

    path: str
    declaration: syntax.Value
    env: Environment
    given: Given | None
    parts: Mapping[tuple[int, ...], Given] = field(default_factory=dict)
    status: Status = Status.NEW
    value: Value | None = None
    data: Namespace | None = None
    first: int = -1
    sampled: bool = False
    units: tuple[Dimension | None, ...] = ()

    @property
    def kind(self) -> str:
        """The keyword of the declaration: `param`, `state`, .."""
        return self.declaration.kind


@dataclass(slots=True, eq=False)
class PortEntry:
    """A port of a model, with one face for bonds outside and one for bonds inside the model.

    `coupling` is the model behind a sampled port.
    """

    path: str
    declaration: syntax.Port
    env: Environment
    instance: Instance
    outer: Face
    inner: Face
    coupling: Instance | None = None


@dataclass(slots=True, eq=False)
class Element:
    """A basic element. A two-port has the faces `in` and `out`, any other the face `all`."""

    path: str
    kind: str  # as in the source: "I", "MSe", "J1", "Mux"
    use: syntax.TypeUse
    law: tuple[syntax.LawEquation, ...] | None
    env: Environment
    dims: tuple[int, ...]
    span: Span
    faces: dict[str, Face]
    first_state: int = -1

    @property
    def row(self) -> ElementKind:
        """The row of its kind in the table of elements."""
        return ELEMENTS[self.kind]

    @property
    def is_gyristor(self) -> bool:
        """True for a gyrator whose bonds all point into it, with a law for the ratio (eq. 13)."""
        by_law = bool(self.law) and not self.use.arguments
        return self.basic == "GY" and by_law and not self.faces["out"].joints

    @property
    def basic(self) -> str:
        """The kind without the M of a modulated element."""
        return self.row.basic


@dataclass(frozen=True, slots=True, eq=False)
class FmuCall:
    """An FMU in a sampled part: the variables that are read, and those that are set.

    `got` holds the values that are read, `given` those that are set, each with its expression.
    """

    file: FmuFile
    span: Span
    env: Environment
    read: tuple[FmuVariable, ...]
    set: tuple[tuple[FmuVariable, syntax.Expr], ...]
    got: Quantity
    given: Quantity


@dataclass(slots=True, eq=False)
class SampledPart:
    """A `sample` of an instance: its held values, the definitions of outputs, and its statements.

    Within the block an output means its definition, outside of it the held value. `fmus` are the
    calls of FMUs in it.
    """

    item: syntax.Sample
    env: Environment
    held: list[Quantity] = field(default_factory=list)
    definitions: dict[Quantity, Quantity] = field(default_factory=dict)
    nexts: list[tuple[syntax.Next, Environment]] = field(default_factory=list)
    fmus: list[FmuCall] = field(default_factory=list)


@dataclass(slots=True, eq=False, repr=False)  # a tree's repr would repeat shared branches
class Instance:
    """An instance of a model.

    `kinds` lists the model, the models that it extends and its interfaces, each with dimensions.
    `statements` are in source order, each with the environment in which it was written.
    """

    path: str
    declared: Declared[syntax.Model]
    parent: Instance | None
    depth: int
    span: Span
    formals: dict[str, Value] = field(default_factory=dict)
    members: dict[str, Member] = field(default_factory=dict)
    kinds: list[tuple[Declared[syntax.Model], tuple[int, ...]]] = field(default_factory=list)
    statements: list[tuple[syntax.Item, Environment]] = field(default_factory=list)
    sampled: list[SampledPart] = field(default_factory=list)

    @property
    def name(self) -> str:
        """The path, or the name of the model at the root; for messages."""
        return self.path or self.declared.syntax.name

    def written(self, kind: type[_Item]) -> list[tuple[_Item, Environment]]:
        """The statements of a kind, in source order."""
        return [(item, env) for item, env in self.statements if isinstance(item, kind)]

    def within(self, name: str) -> str:
        """The path of a member."""
        return f"{self.path}.{name}" if self.path else name


@dataclass(slots=True, eq=False)
class Pending:
    """A declared part, `built` when it is first needed; `fill` is the argument for its slot."""

    path: str
    part: syntax.Part
    env: Environment
    fill: Given | None
    built: Instance | Element | None = None
    status: Status = Status.NEW


@dataclass(slots=True, eq=False)
class PartArray:
    """Parts `name[i]` or `name[i, j]`, by index."""

    path: str
    span: Span
    parts: dict[tuple[int, ...], Pending] = field(default_factory=dict)

    @property
    def description(self) -> str:
        """The array's extent, for messages."""
        indices = list(self.parts)
        shown = [", ".join(map(str, index)) for index in (indices[0], indices[-1])]
        if len(indices) == 1:
            return f"one part only, [{shown[0]}]"
        return f"an array of {len(indices)} parts, [{shown[0]}] to [{shown[1]}]"


Member: TypeAlias = Quantity | PortEntry | Pending | PartArray
