"""The syntax tree of a `.bg` text.

Plain data: every node has the `span` it was read from; names are not resolved, units not
interpreted, widths not evaluated.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from fractions import Fraction
from itertools import chain, product
from typing import TypeAlias

from bgc.diagnostics.source import Source, Span
from bgc.record_class import dataclass

# --- expressions -----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Number:
    """`2`, `1.5e3`, or with a unit `8 t`: the value as written, the unit's text or None."""

    value: Fraction
    unit: str | None
    span: Span


@dataclass(frozen=True, slots=True)
class Name:
    """A plain name, including `time`."""

    name: str
    span: Span


@dataclass(frozen=True, slots=True)
class Member:
    """`base.name`."""

    base: Expr
    name: str
    span: Span


@dataclass(frozen=True, slots=True)
class Range:
    """`first..last` within an index, both inclusive, from 1."""

    first: Expr
    last: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Index:
    """`base[i]`, `base[i, j]`, `base[1..3]`."""

    base: Expr
    indices: tuple[Expr | Range, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Call:
    """`function(arguments)`, including `der(x)`. `function` is a plain name.

    `named` are the options of `interpolate`, `method = spline`.
    """

    function: str
    arguments: tuple[Expr, ...]
    span: Span
    named: tuple[tuple[str, Expr], ...] = ()


@dataclass(frozen=True, slots=True)
class Unary:
    """`-x`, `+x` or `not x`."""

    operator: str
    operand: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Binary:
    """`left operator right`, operator one of `+ - * / ^ < <= > >= == != and or`."""

    operator: str
    left: Expr
    right: Expr
    span: Span

    def links(self) -> list[Binary]:
        """The operations of a chain that nests to the left, the innermost first, this one last.

        `a - b + c` has the links `a - b` and `a - b + c`. A chain may be too long for recursion.
        """
        found = [self]
        while isinstance(found[-1].left, Binary):
            found.append(found[-1].left)
        found.reverse()
        return found

    def operands(self) -> list[Expr]:
        """The operands of a chain that nests to the left, in their order."""
        links = self.links()
        return [links[0].left, *(link.right for link in links)]


@dataclass(frozen=True, slots=True)
class Conditional:
    """`if condition then yes else no`; a condition on states or time switches at an event."""

    condition: Expr
    yes: Expr
    no: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Vector:
    """`[a, b, c]`; a matrix is a vector of vectors, by rows."""

    elements: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Text:
    """`"up_down_up.csv"`: an argument of a device; or a word that a statement chooses."""

    value: str
    span: Span


@dataclass(frozen=True, slots=True)
class Argument:
    """`name = value`, or positional where name is None."""

    name: str | None
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class TypeUse:
    """`Type[n, m](arguments)`: the use of a type, with its dimensions and arguments.

    As an expression it is the value of an argument that fills a slot. There `Rigid`,
    `Rigid[5]` and `Rigid()` are parsed as Name, Index and Call: only the name of the argument
    shows that a type is meant.

    `Type(.., arguments)` in a `use` has `keeps`: it takes the dimensions and arguments of what it
    replaces, as far as it has them. `replaced` is the type of a `use` that this one replaces.
    """

    name: str
    dims: tuple[Expr, ...]
    arguments: tuple[Argument, ...]
    span: Span
    name_span: Span
    keeps: bool = False
    replaced: TypeUse | None = None


Expr: TypeAlias = (
    Number | Name | Member | Index | Call | Unary | Binary | Conditional | Vector | Text | TypeUse
)

# --- parts of declarations --------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class LawEquation:
    """`left = right;` inside a law block: `left` is `e`, `f2`, `H`, or one of them indexed."""

    left: Expr
    right: Expr
    span: Span


class Direction(Enum):
    """The direction of the half arrow at a port."""

    IN = "in"
    OUT = "out"


# --- items of a model -------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Value:
    """`param`, `const`, `let`, `signal`, `input`, `output`, `state` or `unknown`.

    `dims` are its dimensions (`r[3]`, `A[3, 3]`), `unit` as written after the colon,
    `value` its default, definition, initial or start value, `range` the two ends after `in`.
    """

    kind: str
    name: str
    dims: tuple[Expr, ...]
    unit: str | None
    value: Expr | None
    range: tuple[Expr, Expr] | None
    doc: str
    span: Span
    name_span: Span


@dataclass(frozen=True, slots=True)
class Port:
    """`port tip[6] out : Frame main;`, or `port tip[3] out sampled 1 ms { stiffness = k; }`."""

    name: str
    dims: tuple[Expr, ...]
    direction: Direction | None
    domain: str | None
    main: bool
    doc: str
    span: Span
    name_span: Span
    period: Expr | None = None  # of a sampled port
    law: tuple[LawEquation, ...] | None = None


@dataclass(frozen=True, slots=True)
class Part:
    """`name[index] : Type[dims](arguments) { law }`, or a slot `name : Interface = Type(..);`.

    `law` is None without a law block. `default` is the slot's default, None otherwise.
    """

    name: str
    index: tuple[Expr, ...]
    type: TypeUse
    default: TypeUse | None
    law: tuple[LawEquation, ...] | None
    doc: str
    span: Span
    name_span: Span


@dataclass(frozen=True, slots=True)
class Chain:
    """`a, b -> c -> d, e;`: the ends at each stop; only the first and last may be lists."""

    stops: tuple[tuple[Expr, ...], ...]
    span: Span

    @property
    def links(self) -> Iterator[tuple[Expr, Expr]]:
        """The tail and the head of each bond."""
        return chain.from_iterable(map(product, self.stops, self.stops[1:]))


@dataclass(frozen=True, slots=True)
class Assign:
    """`tip.r = ...;`: gives a port's carried signal, or an output declared without a value."""

    target: Expr
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Derivative:
    """`der(x) = ...;` of a state, or of one component of it."""

    target: Expr
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Equation:
    """`equation left = right;`, where either side may hold `der(x)`."""

    left: Expr
    right: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Project:
    """`project x = ...;`: after each completed step the state x is set to the value."""

    target: Expr
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Assert:
    """`assert condition, "message";`: where it fails, the run ends with the message."""

    condition: Expr
    message: str
    span: Span


@dataclass(frozen=True, slots=True)
class Shape:
    """`shape cylinder(r) from a.tip to b colour "red";`: how a part is drawn.

    `ends` are the two frames of `from .. to`, `at` a frame or an offset, `axes` a rotation matrix,
    `colour` a name or `#rrggbb`; each None where it is absent.
    """

    kind: str
    kind_span: Span
    arguments: tuple[Argument, ...]
    ends: tuple[Expr, Expr] | None
    at: Expr | None
    axes: Expr | None
    colour: str | None
    colour_span: Span
    span: Span


@dataclass(frozen=True, slots=True)
class Reset:
    """`reset x = ...;` in a `when`: the state, displacement or momentum takes the value."""

    target: Expr
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class When:
    """`when condition { resets }`: they apply at the instant at which it becomes true."""

    condition: Expr
    resets: tuple[Reset, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Next:
    """`next(x) = ...;` in a sampled part: the value of a state from this instant on."""

    target: Expr
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Sample:
    """`sample period offset time { items }`: evaluated at offset + k period, held in between."""

    period: Expr
    offset: Expr | None
    items: tuple[Item, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class For:
    """`for i in first..last { items }`, unrolled at compile time."""

    variable: str
    first: Expr
    last: Expr
    items: tuple[Item, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class If:
    """`if condition { items } else { items }`, decided at compile time."""

    condition: Expr
    yes: tuple[Item, ...]
    no: tuple[Item, ...]
    span: Span


Item: TypeAlias = (
    Value
    | Port
    | Part
    | Chain
    | Assign
    | Derivative
    | Equation
    | Project
    | Assert
    | Shape
    | When
    | Sample
    | Next
    | For
    | If
)

# --- items of a scene -------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Use:
    """`use crane.elbow.lock = Rigid[5];`: fills a slot."""

    slot: Expr
    type: TypeUse
    span: Span


@dataclass(frozen=True, slots=True)
class Set:
    """`set crane.boom.mass = 7 t;`: gives a parameter another value."""

    target: Expr
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Device:
    """`device hand = trace(file = "up_down_up.csv");`."""

    name: str
    driver: str
    arguments: tuple[Argument, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Drive:
    """`drive handle.x = hand.position;` or, to a device, `drive hand.force = handle.force;`."""

    target: Expr
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Observe:
    """`observe tip.z as height in mm, boom.f;`: one Observe for each value.

    `alias` is None without `as`, `unit` without `in`; `unit_span` is the unit's place, or the
    statement's.
    """

    value: Expr
    alias: str | None
    unit: str | None
    unit_span: Span
    span: Span


@dataclass(frozen=True, slots=True)
class Plot:
    """`plot tip.z, handle;` or `plot force against elevation;`: a panel of observed names."""

    columns: tuple[Expr, ...]
    against: Expr | None
    span: Span


@dataclass(frozen=True, slots=True)
class Require:
    """`require tip.z within 5 mm;`, or without a tolerance `require tension < 300 kN;`."""

    value: Expr
    tolerance: Expr | None
    span: Span


@dataclass(frozen=True, slots=True)
class Keep:
    """`keep x;`: x is kept even where no output depends on it."""

    target: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Solver:
    """`solver rodas5p(rtol = 1e-8);`."""

    name: str
    arguments: tuple[Argument, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Fact:
    """`step 1 ms;`, `run 60 s every 10 ms;`, `deadline 1 ms, hold;`: facts of the run.

    `values` are named by the fields of the record of a run that they state (see
    `scene_statements.py`); a word that is chosen, such as `hold`, is a `Text`.
    """

    word: str
    values: tuple[Argument, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Start:
    """`start rest hold crane.elbow.angle vary drive.torque;`."""

    hold: tuple[Expr, ...]
    vary: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Proof:
    """`proof "3f2a91c04d7e";`: the scene that this one extends, when both were compared."""

    digest: str
    span: Span


SceneItem: TypeAlias = (
    Use | Set | Device | Drive | Observe | Plot | Require | Keep | Solver | Fact | Start | Proof
)

# --- declarations -----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ImportFile:
    """`import "joints.bg";`: a file, by its path relative to the importing file."""

    path: str
    span: Span


@dataclass(frozen=True, slots=True)
class ImportModule:
    """`import crane.joints;`: a module of the installed library."""

    path: tuple[str, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Formal:
    """A dimension of a model (`n`, `n = 6`) or an argument of a function (`v`)."""

    name: str
    default: Expr | None
    span: Span


@dataclass(frozen=True, slots=True)
class Function:
    """`function skew(v) = [...];`."""

    name: str
    formals: tuple[Formal, ...]
    body: Expr
    doc: str
    span: Span
    name_span: Span


@dataclass(frozen=True, slots=True)
class DomainVariable:
    """One line of a domain: `effort F[3] : N;`, `flow v[3] : m/s;`, `signal r[3] : m;`.

    `kind` is `effort`, `flow` or `signal`. Efforts and flows stack in the order written.
    """

    kind: str
    name: str
    dims: tuple[Expr, ...]
    unit: str | None
    span: Span


@dataclass(frozen=True, slots=True)
class Domain:
    """`domain Frame { .. }`, or `pseudo domain`, whose effort times flow is not a power."""

    name: str
    pseudo: bool
    variables: tuple[DomainVariable, ...]
    doc: str
    span: Span
    name_span: Span


@dataclass(frozen=True, slots=True)
class Model:
    """`model Name[n] is Base[n](..) { items }`; `interface` is True for an interface."""

    name: str
    interface: bool
    formals: tuple[Formal, ...]
    base: TypeUse | None
    items: tuple[Item, ...]
    doc: str
    span: Span
    name_span: Span


@dataclass(frozen=True, slots=True)
class Scene:
    """`scene name of Model(args) { items }`, or `scene name is other { items }`.

    The first has a `model`, the second a `base`; the other of the two is None.
    """

    name: str
    model: TypeUse | None
    base: Name | None
    items: tuple[SceneItem, ...]
    doc: str
    span: Span
    name_span: Span


Import: TypeAlias = ImportFile | ImportModule
Declaration: TypeAlias = Value | Function | Domain | Model | Scene


@dataclass(frozen=True, slots=True)
class File:
    """One parsed `.bg` file; a `Value` at this level is a `const` or a `param`."""

    source: Source
    imports: tuple[Import, ...]
    declarations: tuple[Declaration, ...]
