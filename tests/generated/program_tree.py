"""Programs of the language as trees: models with their statements, expressions, scenes.

The tree is what the generator draws. `program_text.py` writes it as text, `raw_equations.py`
makes raw equations of it. Neither uses anything of the compiler.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypeAlias

Index: TypeAlias = "Expr | int"


class Expr:
    """An expression; scalars, vectors and matrices alike."""

    def __add__(self, other: Operand) -> Expr:
        return Apply("+", (self, expr(other)))

    def __sub__(self, other: Operand) -> Expr:
        return Apply("-", (self, expr(other)))

    def __mul__(self, other: Operand) -> Expr:
        return Apply("*", (self, expr(other)))

    def __rmul__(self, other: Operand) -> Expr:
        return Apply("*", (expr(other), self))

    def __truediv__(self, other: Operand) -> Expr:
        return Apply("/", (self, expr(other)))

    def __rtruediv__(self, other: Operand) -> Expr:
        return Apply("/", (expr(other), self))

    def __radd__(self, other: Operand) -> Expr:
        return Apply("+", (expr(other), self))

    def __rsub__(self, other: Operand) -> Expr:
        return Apply("-", (expr(other), self))

    def __pow__(self, other: int) -> Expr:
        return Apply("^", (self, Num(Fraction(other))))

    def __neg__(self) -> Expr:
        return Apply("neg", (self,))


Operand: TypeAlias = "Expr | int | Fraction"


@dataclass(frozen=True)
class Unit:
    """A product of powers of SI words, as `N*s/m`."""

    powers: tuple[tuple[str, int], ...] = ()

    def __mul__(self, other: Unit) -> Unit:
        total = dict(self.powers)
        for word, power in other.powers:
            total[word] = total.get(word, 0) + power
        return Unit(tuple((w, p) for w, p in total.items() if p))

    def __pow__(self, power: int) -> Unit:
        return Unit(tuple((w, p * power) for w, p in self.powers))

    def __truediv__(self, other: Unit) -> Unit:
        return self * other**-1


def unit(**powers: int) -> Unit:
    return Unit(tuple(powers.items()))


PLAIN = Unit()
SECOND = unit(s=1)


@dataclass(frozen=True)
class Num(Expr):
    """A literal: its value in SI, and the unit of its kind."""

    value: Fraction
    unit: Unit = PLAIN


@dataclass(frozen=True)
class Time(Expr):
    pass


@dataclass(frozen=True)
class Own(Expr):
    """A law's own variable, as `e` or `q[2]`."""

    name: str
    component: int | None = None


@dataclass(frozen=True)
class Step:
    """One name of a path, with its index where it is one of many."""

    name: str
    index: Expr | None = None


@dataclass(frozen=True)
class Read(Expr):
    """A value by its path: `k`, `body.f`, `cell[i].spring.q`, `hub.f[2]`.

    Paths begin in the model that holds the expression. `component` is the number of a component
    of a wide value. A loop's variable is a path of one name.
    """

    path: tuple[Step, ...]
    component: Expr | None = None


@dataclass(frozen=True)
class Apply(Expr):
    """An operator or a function of the language; `vector` and `matrix` make lists."""

    op: str
    args: tuple[Expr, ...]


def expr(value: Operand) -> Expr:
    return value if isinstance(value, Expr) else Num(Fraction(value))


def call(name: str, *args: Operand) -> Expr:
    return Apply(name, tuple(expr(a) for a in args))


def choose(condition: Expr, yes: Operand, no: Operand) -> Expr:
    return Apply("if", (condition, expr(yes), expr(no)))


def vector(*items: Operand) -> Expr:
    return Apply("vector", tuple(expr(a) for a in items))


def matrix(rows: list[list[Expr]]) -> Expr:
    return Apply("matrix", tuple(vector(*row) for row in rows))


def read(*names: str | Step, component: Operand | None = None) -> Read:
    path = tuple(n if isinstance(n, Step) else Step(n) for n in names)
    return Read(path, None if component is None else expr(component))


# --- statements ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Value:
    """`word name[shape] : unit = value`; a signal without a value gets it from `Assign`."""

    word: str
    name: str
    unit: Unit | None
    value: Expr | None = None
    shape: int | None = None


@dataclass(frozen=True)
class Assign:
    """`name[component] = value;`, or `der(name[component]) = value;`"""

    name: str
    value: Expr
    component: Expr | None = None
    rate: bool = False


@dataclass(frozen=True)
class Equation:
    left: Expr
    right: Expr


@dataclass(frozen=True)
class Law:
    """`variable[component] = value` within the braces of an element."""

    variable: str
    value: Expr
    component: int | None = None


@dataclass(frozen=True)
class Part:
    """An element or a part of a model's type; `index` where it is one of many.

    `width` is the number of ports, or the components of a wide port; of TF and GY the
    widths of both sides. `slot` is the interface of a slot.
    """

    name: str
    type: str
    width: tuple[int, ...] = (1,)
    arguments: tuple[tuple[str, Expr], ...] = ()
    laws: tuple[Law, ...] = ()
    index: Expr | None = None
    slot: str | None = None
    varies: bool = False  # M of MTF, MR ..
    dimension: Expr | None = None  # of a part whose model has one


@dataclass(frozen=True)
class End:
    """An end of a bond: a part, a port of a part or of the own model, and which components.

    `slice` are the first and last component that the bond takes, counted from 1. `place` is
    the port of a field of scalar ports.
    """

    path: tuple[Step, ...]
    slice: tuple[int, int] | None = None
    place: int | None = None


@dataclass(frozen=True)
class Bond:
    tail: End
    head: End


@dataclass(frozen=True)
class For:
    variable: str
    first: Expr
    last: Expr
    body: tuple[Statement, ...]


@dataclass(frozen=True)
class Sampled:
    """A sampled part: at multiples of the period, in s, `next(state) = following` and an output."""

    name: str  # of the output
    unit: Unit
    value: Expr
    state: str
    start: Expr
    following: Expr
    period: Fraction


@dataclass(frozen=True)
class Port:
    name: str
    direction: str  # in, out
    width: int


Statement: TypeAlias = Value | Assign | Equation | Part | Bond | For | Port | Sampled


@dataclass(frozen=True)
class Model:
    name: str
    statements: tuple[Statement, ...]
    interface: str | None = None
    dimension: tuple[str, int] | None = None

    @property
    def ports(self) -> list[Port]:
        return [s for s in self.statements if isinstance(s, Port)]


@dataclass(frozen=True)
class Interface:
    name: str
    ports: tuple[Port, ...]
    outputs: tuple[Value, ...]


@dataclass(frozen=True)
class Observed:
    """A column; `scale` is the size that such a value has in the program."""

    name: str
    value: Expr
    scale: float


@dataclass(frozen=True)
class Scene:
    uses: tuple[Part, ...] = ()  # the part that fills the slot of its name
    sets: tuple[tuple[tuple[Step, ...], Expr], ...] = ()
    drives: tuple[tuple[tuple[Step, ...], Expr], ...] = ()
    observed: tuple[Observed, ...] = ()
    duration: Fraction = Fraction(1)
    rows: int = 50
    solver: str | None = None
    accounts: bool = False  # whether the energies are observed


@dataclass(frozen=True)
class Program:
    """All models; the last is the one of the scene."""

    models: tuple[Model, ...]
    interfaces: tuple[Interface, ...]
    scene: Scene
    seed: int = 0
    notes: tuple[str, ...] = field(default=(), compare=False)

    def model(self, name: str) -> Model:
        return next(m for m in self.models if m.name == name)

    @property
    def main(self) -> Model:
        return self.models[-1]

    def with_scene(self, **changes: object) -> Program:
        return replace(self, scene=replace(self.scene, **changes))  # type: ignore[arg-type]


def children(e: Expr) -> tuple[Expr, ...]:
    return e.args if isinstance(e, Apply) else ()
