"""The models, elements and variables of a program, each model opened where it is used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from flat_expressions import Var
from flat_lists import (
    Flat,
    with_loop_numbers,
)
from program_text import whole
from program_tree import (
    Assign,
    Bond,
    Expr,
    For,
    Model,
    Num,
    Part,
    Port,
    Program,
    Sampled,
    Statement,
    Value,
)

Point: TypeAlias = tuple[str, str, int]  # an element or port by its path, its side, a component


class Unconnected(Exception):
    """The effort or flow of a junction without bonds is read, which no equation gives."""


@dataclass
class Storage:
    """A state of an element with the derivative of the energy by it, a function of such states."""

    var: Var
    slope: Expr


@dataclass
class Jump:
    """Held values, differential variables that stand still, and what each becomes at instants."""

    period: float
    values: dict[Var, Expr]


@dataclass
class Raw:
    """All equations of a program: rows are residuals, `rate[k]` is the z that is x[k]'."""

    x_names: list[str] = field(default_factory=list)
    z_names: list[str] = field(default_factory=list)
    rows: list[Expr] = field(default_factory=list)
    row_names: list[str] = field(default_factory=list)
    rate: list[Var] = field(default_factory=list)
    given: dict[int, float] = field(default_factory=dict)  # of x, at the start
    conditions: list[Expr] = field(default_factory=list)  # at the start, residuals
    storage: list[Storage] = field(default_factory=list)
    supplied: list[Expr] = field(default_factory=list)  # powers
    dissipated: list[Expr] = field(default_factory=list)
    stored: list[Expr] = field(default_factory=list)
    observed: list[tuple[str, Expr, float]] = field(default_factory=list)
    guesses: dict[int, float] = field(default_factory=dict)  # of z
    breaks: set[float] = field(default_factory=set)
    jumps: list[Jump] = field(default_factory=list)

    @property
    def held(self) -> set[Var]:
        return {var for jump in self.jumps for var in jump.values}

    def new_z(self, name: str) -> Var:
        self.z_names.append(name)
        return Var("z", len(self.z_names) - 1)

    def new_x(self, name: str) -> Var:
        self.x_names.append(name)
        self.rate.append(self.new_z(f"{name}'"))
        return Var("x", len(self.x_names) - 1)

    def row(self, name: str, residual: Expr) -> None:
        self.rows.append(residual)
        self.row_names.append(name)


@dataclass
class Instance:
    """A model in use: what its names mean."""

    model: Model
    path: str
    outer: Instance | None
    values: dict[str, Value] = field(default_factory=dict)
    arguments: dict[str, Expr] = field(default_factory=dict)  # written in the outer model
    dimension: int | None = None
    parts: dict[tuple[str, int | None], Element | Instance] = field(default_factory=dict)
    assigned: dict[tuple[str, int | None], Expr] = field(default_factory=dict)
    known: dict[str, Flat] = field(default_factory=dict)
    ports: dict[str, Port] = field(default_factory=dict)


@dataclass
class Element:
    part: Part
    path: str
    home: Instance
    loops: dict[str, int]
    ends: dict[tuple[str, int], list[tuple[int, int]]] = field(default_factory=dict)
    taken: dict[str, int] = field(default_factory=dict)
    q: list[Var] = field(default_factory=list)
    p: dict[int, Var] = field(default_factory=dict)

    @property
    def is_junction(self) -> bool:
        return self.part.type in ("J0", "J1")

    def bond(self, side: str, k: int) -> tuple[int, int]:
        """Bond and sign of a port: 1 where the arrow comes in."""
        (only,) = self.ends[side, k]
        return only


_ELEMENTS = frozenset("Se Sf C I R TF GY J0 J1 IC Mux Demux".split())


class Opening:
    """Opens models and unrolls loops."""

    program: Program
    raw: Raw
    elements: list[Element]
    segments: list[tuple[Point, Point]]
    uses: dict[str, Part]

    def _open(
        self,
        model: Model,
        path: str,
        outer: Instance | None,
        arguments: dict[str, Expr],
        dimension: int | None,
    ) -> Instance:
        inst = Instance(model, path, outer, arguments=arguments, dimension=dimension)
        self._declare(model.statements, inst, {})
        self._build(model.statements, inst, {})
        return inst

    def _declare(
        self, statements: Sequence[Statement], inst: Instance, loops: dict[str, int]
    ) -> None:
        for s in statements:
            match s:
                case Value(name=name):
                    inst.values[name] = s
                case Port(name=name):
                    inst.ports[name] = s
                case Sampled():
                    inst.values[s.state] = Value("held", s.state, s.unit, s.start)
                    inst.values[s.name] = Value("held", s.name, s.unit)

    def _build(
        self, statements: Sequence[Statement], inst: Instance, loops: dict[str, int]
    ) -> None:
        parts = [s for s in statements if not isinstance(s, Bond)]
        for s in [*parts, *(s for s in statements if isinstance(s, Bond))]:
            match s:
                case Part():
                    self._part(s, inst, loops)
                case Assign(name=name, component=component, value=value, rate=rate):
                    k = None if component is None else self._index(component, inst, loops)
                    key = (f"der({name})" if rate else name, k)
                    inst.assigned[key] = with_loop_numbers(value, loops)
                case Bond(tail=tail, head=head):
                    a, b = self._points(tail, inst, loops, -1), self._points(head, inst, loops, 1)
                    assert len(a) == len(b), (inst.path, s)
                    self.segments += zip(a, b, strict=True)
                case For(variable=variable, first=first, last=last, body=body):
                    low, high = (self._index(e, inst, loops) for e in (first, last))
                    passes = [loops | {variable: k} for k in range(low, high + 1)]
                    inner = [b for b in body if not isinstance(b, Bond)]
                    for now in passes:
                        self._build(inner, inst, now)
                    for now in passes:
                        self._build([b for b in body if isinstance(b, Bond)], inst, now)

    def _part(self, s: Part, inst: Instance, loops: dict[str, int]) -> None:
        index = None if s.index is None else self._index(s.index, inst, loops)
        name = s.name if index is None else f"{s.name}[{index}]"
        path = f"{inst.path}.{name}" if inst.path else name
        used = self.uses.get(path)
        arguments = {n: with_loop_numbers(v, loops) for n, v in s.arguments}
        kind, home = s.type, inst
        if used is not None:
            kind = used.type
            arguments = dict(used.arguments)
        if kind in _ELEMENTS:
            element = Element(s, path, inst, loops)
            inst.parts[s.name, index] = element
            self.elements.append(element)
            return
        model = self.program.model(kind)
        dimension = None
        if model.dimension is not None:
            given = s.dimension
            dimension = model.dimension[1] if given is None else self._index(given, inst, loops)
        inst.parts[s.name, index] = self._open(model, path, home, arguments, dimension)

    def _index(self, e: Expr, inst: Instance, loops: dict[str, int]) -> int:
        names = dict(loops)
        if inst.model.dimension is not None:
            names[inst.model.dimension[0]] = inst.dimension or inst.model.dimension[1]
        for name, value in inst.values.items():
            if value.word == "const" and isinstance(value.value, Num):
                names.setdefault(name, int(value.value.value))
        return whole(e, names)
