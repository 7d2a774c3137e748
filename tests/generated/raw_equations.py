"""The raw equations of a program tree: every bond variable, junction and element law.

This is the reference's own elaboration. Models are opened, loops unrolled, wide bonds split, and
each element and junction gives its equations as they stand in a textbook, residual = 0. No
causality is assigned, nothing is solved or simplified.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flat_expressions import ZERO, Var, derivative, evaluate, variables
from program_text import whole
from program_tree import (
    Apply,
    Assign,
    Bond,
    End,
    Equation,
    Expr,
    For,
    Model,
    Num,
    Own,
    Part,
    Port,
    Program,
    Read,
    Statement,
    Step,
    Time,
    Value,
    read,
)

Flat: TypeAlias = "Expr | list[Flat]"
Point: TypeAlias = tuple[str, str, int]  # an element or port by its path, its side, a component


@dataclass
class Storage:
    """A state of an element with the derivative of the energy by it, a function of such states."""

    var: Var
    slope: Expr


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


class Elaboration:
    """Opens a program; `raw` holds the result."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.raw = Raw()
        self.elements: list[Element] = []
        self.segments: list[tuple[Point, Point]] = []  # scalar pieces of bonds, tail and head
        self.sets = {".".join(_named(s) for s in p): v for p, v in program.scene.sets}
        self.drives = {".".join(_named(s) for s in p): v for p, v in program.scene.drives}
        self.uses = {u.name: u for u in program.scene.uses}
        self.main = self._open(program.main, "", None, {}, None)
        self._join()
        self._laws(self.main)
        for element in self.elements:
            self._equations(element)
        for o in program.scene.observed:
            value = self._scalar(o.value, self.main, {})
            self.raw.observed.append((o.name, value, o.scale))

    # --- instances ----------------------------------------------------------------------

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
                    inst.assigned[key] = _substituted(value, loops)
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
        arguments = {n: _substituted(v, loops) for n, v in s.arguments}
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

    # --- bonds --------------------------------------------------------------------------

    def _points(self, end: End, inst: Instance, loops: dict[str, int], sign: int) -> list[Point]:
        """The scalar ends of one end of a bond."""
        first, *more = end.path
        index = None if first.index is None else self._index(first.index, inst, loops)
        if not more and index is None and first.name in inst.ports:
            width = inst.ports[first.name].width
            return [(f"{inst.path}:{first.name}", "in", k) for k in _chosen(end, width)]
        part = inst.parts[first.name, index]
        if isinstance(part, Instance):
            if more:
                port = part.ports[more[0].name]
            else:
                direction = "in" if sign > 0 else "out"
                (port,) = (p for p in part.ports.values() if p.direction == direction)
            return [(f"{part.path}:{port.name}", "out", k) for k in _chosen(end, port.width)]
        widths = part.part.width
        if part.is_junction:
            return [(part.path, "j", k) for k in _chosen(end, widths[0])]
        if end.place is not None:
            return [(part.path, "1", end.place - 1)]
        if part.part.type in ("TF", "GY") and len(widths) == 2:
            side = "1" if sign > 0 else "2"
            return [(part.path, side, k) for k in range(widths[0 if sign > 0 else -1])]
        if part.part.type in ("Mux", "Demux"):
            wide = (part.part.type == "Mux") == (sign < 0)
            if wide:
                return [(part.path, "wide", k) for k in range(sum(widths))]
            count = part.taken.get("narrow", 0)
            part.taken["narrow"] = count + 1
            start = sum(widths[:count])
            return [(part.path, "narrow", k) for k in range(start, start + widths[count])]
        return [(part.path, "1", k) for k in range(widths[0])]

    def _join(self) -> None:
        """Join pieces of bonds at ports and muxes, and give each whole bond its variables."""
        by_path = {e.path: e for e in self.elements}
        onward: dict[Point, int] = {}

        def passes(point: Point) -> bool:
            found = by_path.get(point[0])
            return found is None or found.part.type in ("Mux", "Demux")

        for n, (tail, _) in enumerate(self.segments):
            if passes(tail):
                assert tail not in onward, tail
                onward[tail] = n
        inside: dict[Point, Point] = {}
        self._port_bond: dict[Point, int] = {}
        for n, (tail, head) in enumerate(self.segments):
            if passes(tail):
                continue
            gone = [n]
            while passes(head):
                path, side, k = head
                other = {"in": "out", "out": "in", "wide": "narrow", "narrow": "wide"}[side]
                piece = onward.pop((path, other, k))
                gone.append(piece)
                head = self.segments[piece][1]
            bond = len(self.bonds)
            self.bonds.append((tail, head))
            for piece in gone:
                for point in self.segments[piece]:
                    self._port_bond[point] = bond
            for (path, side, k), sign in ((tail, -1), (head, 1)):
                by_path[path].ends.setdefault((side, k), []).append((bond, sign))
        assert not onward and not inside, onward
        for k in range(len(self.bonds)):
            self.effort.append(self.raw.new_z(f"e{k} {self.bonds[k]}"))
            self.flow.append(self.raw.new_z(f"f{k} {self.bonds[k]}"))

    @property
    def bonds(self) -> list[tuple[Point, Point]]:
        return self.__dict__.setdefault("_bonds", [])

    @property
    def effort(self) -> list[Var]:
        return self.__dict__.setdefault("_effort", [])

    @property
    def flow(self) -> list[Var]:
        return self.__dict__.setdefault("_flow", [])

    # --- values -------------------------------------------------------------------------

    def _laws(self, inst: Instance) -> None:
        """Rows of the plain equations of an instance and of its parts."""
        for name, value in inst.values.items():
            if value.word == "state":
                self._value(name, inst)
                for k, var in enumerate(_items(inst.known[name])):
                    rate = inst.assigned.get((f"der({name})", k + 1 if value.shape else None))
                    if rate is None and value.shape:
                        whole_rate = inst.assigned.get((f"der({name})", None))
                        if whole_rate is not None:
                            found = _items(self._resolve(whole_rate, inst, {}))[k]
                            self.raw.row(f"der({name})", self.raw.rate[var.index] - found)
                    elif rate is not None:
                        found = self._scalar(rate, inst, {})
                        self.raw.row(f"der({name})", self.raw.rate[var.index] - found)
        for s in inst.model.statements:
            if isinstance(s, Equation):
                left, right = (self._scalar(e, inst, {}) for e in (s.left, s.right))
                self.raw.row("equation", left - right)
        for part in inst.parts.values():
            if isinstance(part, Instance):
                self._laws(part)

    def _value(self, name: str, inst: Instance) -> Flat:
        if name in inst.known:
            return inst.known[name]
        value = inst.values[name]
        path = f"{inst.path}.{name}" if inst.path else name
        found: Flat
        if value.word == "state":
            start = ZERO if value.value is None else self._resolve(value.value, inst, {})
            count = value.shape or 1
            starts = _items(start) * (count if not isinstance(start, list) else 1)
            states = [self.raw.new_x(f"{path}[{k}]") for k in range(count)]
            inst.known[name] = states if value.shape else states[0]
            for var, at in zip(states, starts, strict=True):
                self.raw.given[var.index] = evaluate(at, {}, 0.0)
            return inst.known[name]
        if value.word == "unknown":
            var = self.raw.new_z(path)
            guess = ZERO if value.value is None else self._scalar(value.value, inst, {})
            self.raw.guesses[var.index] = evaluate(guess, {}, 0.0)
            inst.known[name] = var
            return var
        if path in self.sets:
            found = self._resolve(self.sets[path], self.main, {})
        elif path in self.drives:
            found = self._resolve(self.drives[path], self.main, {})
        elif name in inst.arguments:
            assert inst.outer is not None
            found = self._resolve(inst.arguments[name], inst.outer, {})
        elif value.value is not None:
            found = self._resolve(value.value, inst, {})
        else:
            # Assigned by component; reserved first, for a signal may follow itself through bonds.
            count = value.shape or 1
            held = [self.raw.new_z(f"{path}[{k}]") for k in range(count)]
            inst.known[name] = held if value.shape else held[0]
            for k, var in enumerate(held):
                given = inst.assigned[name, k + 1 if value.shape else None]
                self.raw.row(path, var - self._scalar(given, inst, {}))
            return inst.known[name]
        if value.shape and not isinstance(found, list):
            found = [found] * value.shape
        inst.known[name] = _mapped(found, lambda e: self._named(path, e))
        return inst.known[name]

    def _named(self, path: str, e: Expr) -> Expr:
        """A variable for an expression that varies; what is fixed as a number."""
        if isinstance(e, Num | Var):
            return e
        if not variables(e):
            return Num(Fraction(evaluate(e, {}, 0.0)))
        var = self.raw.new_z(path)
        self.raw.row(path, var - e)
        return var

    def _scalar(
        self, e: Expr, inst: Instance, loops: dict[str, int], own: dict[str, Flat] | None = None
    ) -> Expr:
        items = _items(self._resolve(e, inst, loops, own))
        assert len(items) == 1, e
        return items[0]

    def _resolve(
        self, e: Expr, inst: Instance, loops: dict[str, int], own: dict[str, Flat] | None = None
    ) -> Flat:
        """The expression in flat variables; vectors and matrices as lists."""
        match e:
            case Num() | Time() | Var():
                return e
            case Own(name=name, component=component):
                assert own is not None
                found = own[name]
                if component is not None:
                    assert isinstance(found, list)
                    return found[component - 1]
                return found[0] if isinstance(found, list) and len(found) == 1 else found
            case Read(path=path, component=component):
                whole_value = self._read(path, inst, loops)
                if component is None:
                    return whole_value
                if not isinstance(whole_value, list):
                    whole_value = [whole_value]
                return whole_value[self._index(component, inst, loops) - 1]
            case Apply(op="vector" | "matrix", args=args):
                return [self._resolve(a, inst, loops, own) for a in args]
            case Apply(op=op, args=args):
                if op in ("<", ">", "<=", ">=") and Time() in args:
                    other = next(a for a in args if a != Time())
                    at = self._scalar(other, inst, loops, own)
                    self.raw.breaks.add(evaluate(at, {}, 0.0))
                return _applied(op, [self._resolve(a, inst, loops, own) for a in args])
        raise AssertionError(e)

    def _read(self, path: tuple[Step, ...], inst: Instance, loops: dict[str, int]) -> Flat:
        first, *more = path
        index = None if first.index is None else self._index(first.index, inst, loops)
        if not more and first.name in loops:
            return Num(Fraction(loops[first.name]))
        if inst.model.dimension is not None and first.name == inst.model.dimension[0]:
            return Num(Fraction(inst.dimension or inst.model.dimension[1]))
        if first.name in inst.values:
            return self._value(first.name, inst)
        if first.name in inst.ports:
            return self._port_value(f"{inst.path}:{first.name}", more[0].name)
        part = inst.parts[first.name, index]
        if isinstance(part, Element):
            return self._variable(part, more[0].name)
        if more[0].name in part.ports and len(more) == 2:
            return self._port_value(f"{part.path}:{more[0].name}", more[1].name)
        return self._read(tuple(more), part, loops)

    def _port_value(self, port: str, variable: str) -> Flat:
        bonds = [b for (name, side, _), b in sorted(self._port_bond.items()) if name == port]
        bonds = list(dict.fromkeys(bonds))
        if variable == "power":
            return _sum([self.effort[b] * self.flow[b] for b in bonds])
        return _slim([(self.effort if variable == "e" else self.flow)[b] for b in bonds])

    def _variable(self, element: Element, variable: str) -> Flat:
        if element.is_junction:
            width = element.part.width[0]
            table = self.effort if variable == "e" else self.flow
            return _slim([table[element.ends["j", k][0][0]] for k in range(width)])
        if variable == "power":
            if element.part.type in ("TF", "GY"):
                bonds = [element.bond("1", k)[0] for k in range(element.part.width[0])]
                return _sum([self.effort[b] * self.flow[b] for b in bonds])
            sign = -1 if element.part.type in ("Se", "Sf") else 1
            return self._power(element, sign)
        self._states(element)
        if variable == "q":
            return _slim(list(element.q))
        if variable == "p":
            return _slim([element.p.get(k, ZERO) for k in range(element.part.width[0])])
        side = variable[1:] or "1"
        width = element.part.width[0 if side == "1" else -1]
        table = self.effort if variable[0] == "e" else self.flow
        return _slim([table[element.bond(side, k)[0]] for k in range(width)])

    def _power(self, element: Element, sign: int) -> Expr:
        """The power into an element, times a sign."""
        terms = []
        for k in range(element.part.width[0]):
            bond, direction = element.bond("1", k)
            terms.append(Num(Fraction(sign * direction)) * self.effort[bond] * self.flow[bond])
        return _sum(terms)

    def _states(self, element: Element) -> None:
        """The states of a storage element, made when first asked for."""
        kind, width = element.part.type, element.part.width[0]
        if element.q or element.p or kind not in ("C", "I", "IC"):
            return
        if kind in ("C", "IC"):
            element.q = [self.raw.new_x(f"{element.path}.q[{k}]") for k in range(width)]
        if kind in ("I", "IC"):
            held = range(width)
            if kind == "IC":
                used = [x for law in element.part.laws for x in _owns(law.value) if x.name == "p"]
                held_set = {(x.component or 1) - 1 for x in used}
                held = [k for k in range(width) if k in held_set]  # type: ignore[assignment]
            for k in held:
                element.p[k] = self.raw.new_x(f"{element.path}.p[{k}]")

    # --- equations of elements ----------------------------------------------------------

    def _equations(self, element: Element) -> None:
        part, raw = element.part, self.raw
        own = dict(part.arguments)

        def value(e: Expr, names: dict[str, Flat] | None = None) -> Flat:
            return self._resolve(e, element.home, element.loops, names)

        if part.type in ("Mux", "Demux"):
            return
        if element.is_junction:
            same, summed = (
                (self.effort, self.flow) if part.type == "J0" else (self.flow, self.effort)
            )
            for k in range(part.width[0]):
                ends = element.ends["j", k]
                for bond, _ in ends[1:]:
                    raw.row(element.path, same[bond] - same[ends[0][0]])
                raw.row(element.path, _sum([Num(Fraction(sign)) * summed[b] for b, sign in ends]))
            return
        width = part.width[0]
        if part.type in ("TF", "GY") and len(part.width) == 2:
            self._two_port(element, value)
            return
        ports = [element.bond("1", k) for k in range(width)]
        e = [self.effort[b] for b, _ in ports]
        f = [self.flow[b] for b, _ in ports]
        names: dict[str, Flat] = {"e": list(e), "f": list(f)}
        if part.type in ("Se", "Sf"):
            letter = part.type[1]
            given = own.get(letter)
            found = self._law_items(part, letter, value, names) if given is None else value(given)
            items = _items(found) if isinstance(found, list) else [found] * width
            for k in range(width):
                raw.row(element.path, (e if letter == "e" else f)[k] - items[k])
            raw.supplied.append(self._power(element, -1))
        elif part.type == "GY":
            items = _items(value(part.laws[0].value, names))
            for k in range(width):
                raw.row(element.path, e[k] - items[k])
        elif part.type == "R":
            raw.dissipated.append(self._power(element, 1))
            if own:
                ((argument, given),) = own.items()
                left, right = (e, f) if argument == "resistance" else (f, e)
                m = _matrix(value(given), width)
                for k in range(width):
                    raw.row(
                        element.path, left[k] - _sum([m[k][j] * right[j] for j in range(width)])
                    )
            else:
                letter = part.laws[0].variable
                items = _items(self._law_items(part, letter, value, names))
                for k in range(width):
                    raw.row(element.path, (e if letter == "e" else f)[k] - items[k])
        else:
            raw.stored.append(self._power(element, 1))
            self._storage(element, e, f, value)

    def _law_items(self, part: Part, letter: str, value, names: dict[str, Flat]) -> Flat:  # type: ignore[no-untyped-def]
        laws = [law for law in part.laws if law.variable == letter]
        if laws[0].component is None:
            return value(laws[0].value, names)
        by_place = {law.component: law for law in laws}
        return [_one(value(by_place[k + 1].value, names)) for k in range(part.width[0])]

    def _storage(self, element: Element, e: list[Var], f: list[Var], value) -> None:  # type: ignore[no-untyped-def]
        part, raw, width = element.part, self.raw, element.part.width[0]
        self._states(element)
        own = dict(part.arguments)
        q, p = element.q, element.p
        momenta: Flat = [p.get(k, ZERO) for k in range(width)]
        names: dict[str, Flat] = {"q": list(q), "p": momenta}
        by_charge: list[Expr] = []
        by_momentum: list[Expr] = []
        energy = [law for law in part.laws if law.variable == "H"]
        if energy:
            h = _one(value(energy[0].value, names))
            by_charge = [derivative(h, x) for x in q]
            by_momentum = [derivative(h, p[k]) if k in p else ZERO for k in range(width)]
        elif part.laws:
            letter = part.laws[0].variable  # e of q, or f of p
            items = _items(self._law_items(part, letter, value, names))
            by_charge, by_momentum = (items, []) if letter == "e" else ([], items)
        else:
            argument = next(a for a in own if a in ("compliance", "stiffness", "inertia"))
            m = _matrix(value(own[argument]), width)
            if argument != "stiffness":
                m = _inverse(m)
            held = q if part.type == "C" else [p[k] for k in range(width)]
            items = [_sum([m[k][j] * held[j] for j in range(width)]) for k in range(width)]
            by_charge, by_momentum = (items, []) if part.type == "C" else ([], items)
        for k in range(width):
            if q:
                raw.row(element.path, raw.rate[q[k].index] - f[k])
                raw.storage.append(Storage(q[k], by_charge[k]))
            if k in p:
                back = by_charge[k] if q else ZERO
                raw.row(element.path, raw.rate[p[k].index] - (e[k] - back))
                raw.row(element.path, f[k] - by_momentum[k])
                raw.storage.append(Storage(p[k], by_momentum[k]))
            else:
                raw.row(element.path, e[k] - by_charge[k])
        for letter in ("q0", "p0", "e0", "f0"):
            if letter not in own:
                continue
            given = value(own[letter])
            items = _items(given) if isinstance(given, list) else [given] * width
            for k in range(width):
                if letter == "q0":
                    raw.given[q[k].index] = evaluate(items[k], {}, 0.0)
                elif letter == "p0":
                    raw.given[p[k].index] = evaluate(items[k], {}, 0.0)
                else:
                    law = by_charge[k] if letter == "e0" else by_momentum[k]
                    raw.conditions.append(law - items[k])

    def _two_port(self, element: Element, value) -> None:  # type: ignore[no-untyped-def]
        part, raw = element.part, self.raw
        n1, n2 = part.width[0], part.width[-1]
        one = [element.bond("1", k)[0] for k in range(n1)]
        two = [element.bond("2", k)[0] for k in range(n2)]
        own = dict(part.arguments)
        e1, f1 = [self.effort[b] for b in one], [self.flow[b] for b in one]
        e2, f2 = [self.effort[b] for b in two], [self.flow[b] for b in two]
        left, given = "f2" if part.type == "TF" else "e2", own.get("ratio")
        if given is None:
            law = part.laws[0]
            left = law.variable
            # A law is `left = M*right`: the generator writes M as the first factor.
            assert isinstance(law.value, Apply) and law.value.op == "*"
            given = law.value.args[0]
        sides = {"e1": e1, "f1": f1, "e2": e2, "f2": f2}
        other = {"TF": {"f2": "f1", "e1": "e2", "f1": "f2", "e2": "e1"}}.get(
            part.type, {"e2": "f1", "e1": "f2", "f1": "e2", "f2": "e1"}
        )
        right = other[left]
        m = _matrix(value(given), len(sides[left]), len(sides[right]))
        dual = {"e": "f", "f": "e"}
        dual_left = dual[right[0]] + right[1]
        dual_right = dual[left[0]] + left[1]
        for i, x in enumerate(sides[left]):
            raw.row(element.path, x - _sum([m[i][j] * y for j, y in enumerate(sides[right])]))
        for j, x in enumerate(sides[dual_left]):
            raw.row(element.path, x - _sum([m[i][j] * y for i, y in enumerate(sides[dual_right])]))


_ELEMENTS = frozenset("Se Sf C I R TF GY J0 J1 IC Mux Demux".split())


def raw_equations(program: Program) -> Raw:
    return Elaboration(program).raw


def _named(step: Step) -> str:
    if step.index is None:
        return step.name
    return f"{step.name}[{whole(step.index, {})}]"


def _chosen(end: End, width: int) -> range:
    first, last = end.slice or (1, width)
    return range(first - 1, last)


def _items(found: Flat) -> list[Expr]:
    return [found] if isinstance(found, Expr) else list(found)  # type: ignore[arg-type]


def _slim(items: list[Expr]) -> Flat:
    """A vector of one component counts as a scalar."""
    return items[0] if len(items) == 1 else list(items)


def _one(found: Flat) -> Expr:
    (only,) = _items(found)
    return only


def _mapped(found: Flat, function) -> Flat:  # type: ignore[no-untyped-def]
    if isinstance(found, list):
        return [_mapped(x, function) for x in found]
    return function(found)


def _sum(terms: Sequence[Expr]) -> Expr:
    total: Expr = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


def _owns(e: Expr) -> list[Own]:
    if isinstance(e, Own):
        return [e]
    return [x for a in e.args for x in _owns(a)] if isinstance(e, Apply) else []


def _substituted(e: Expr, loops: dict[str, int]) -> Expr:
    """The expression with the numbers of loops, for it is read outside of them."""
    match e:
        case Read(path=(Step(name=name, index=None),), component=None) if name in loops:
            return Num(Fraction(loops[name]))
        case Read(path=path, component=component):
            steps = tuple(
                Step(s.name, None if s.index is None else _substituted(s.index, loops))
                for s in path
            )
            inner = None if component is None else _substituted(component, loops)
            return read(*steps, component=inner)
        case Apply(op=op, args=args):
            return Apply(op, tuple(_substituted(a, loops) for a in args))
    return e


def _matrix(found: Flat, rows: int, columns: int | None = None) -> list[list[Expr]]:
    """A scalar or vector as a diagonal matrix."""
    columns = rows if columns is None else columns
    if not isinstance(found, list):
        found = [found] * rows
    if not isinstance(found[0], list):
        return [[found[i] if i == j else ZERO for j in range(columns)] for i in range(rows)]  # type: ignore[misc]
    return found  # type: ignore[return-value]


def _inverse(m: list[list[Expr]]) -> list[list[Expr]]:
    numbers = np.array([[evaluate(x, {}, 0.0) for x in row] for row in m])
    return [[Num(Fraction(float(x))) for x in row] for row in np.linalg.inv(numbers)]


def _applied(op: str, args: list[Flat]) -> Flat:
    """An operator on scalars, vectors and matrices."""
    if not any(isinstance(a, list) for a in args):
        return Apply(op, tuple(args))  # type: ignore[arg-type]
    if op == "*":
        a, b = args
        if isinstance(a, list) and isinstance(b, list):
            assert isinstance(a[0], list), "product of two vectors"
            if isinstance(b[0], list):
                columns = list(zip(*b, strict=True))
                return [
                    [_sum([x * y for x, y in zip(r, c, strict=True)]) for c in columns] for r in a
                ]  # type: ignore[union-attr,operator,misc]
            return [_sum([x * y for x, y in zip(r, b, strict=True)]) for r in a]  # type: ignore[union-attr,operator,misc]
        if isinstance(a, list):
            return [_applied(op, [x, b]) for x in a]
        return [_applied(op, [a, x]) for x in b]  # type: ignore[union-attr]
    if op in ("+", "-"):
        a, b = args
        return [_applied(op, [x, y]) for x, y in zip(a, b, strict=True)]  # type: ignore[arg-type]
    if op == "/":
        return [_applied(op, [x, args[1]]) for x in args[0]]  # type: ignore[union-attr]
    return [_applied(op, [x]) for x in args[0]]  # type: ignore[union-attr]
