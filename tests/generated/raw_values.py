"""The values of a program: parameters, signals, states, and the variables of elements."""

from __future__ import annotations

from fractions import Fraction

from curves import is_curve
from flat_expressions import ZERO, Var, evaluate, variables
from flat_lists import (
    Flat,
    applied,
    items_of,
    mapped,
    own_variables,
    slim,
    sum_of,
)
from program_tree import (
    Apply,
    Equation,
    Expr,
    Num,
    Own,
    Read,
    Sampled,
    Step,
    Time,
)
from raw_bonds import Joining
from raw_instances import Element, Instance, Jump, Unconnected


class Values(Joining):
    """Resolves what expressions read to flat variables."""

    sets: dict[str, Expr]
    drives: dict[str, Expr]
    main: Instance

    def _laws(self, inst: Instance) -> None:
        """Rows of the plain equations of an instance and of its parts."""
        for name, value in inst.values.items():
            if value.word == "held":
                (var,) = items_of(self._value(name, inst))
                self.raw.row(f"held {name}", self.raw.rate[var.index])
            if value.word == "state":
                self._value(name, inst)
                for k, var in enumerate(items_of(inst.known[name])):
                    rate = inst.assigned.get((f"der({name})", k + 1 if value.shape else None))
                    if rate is None and value.shape:
                        whole_rate = inst.assigned.get((f"der({name})", None))
                        if whole_rate is not None:
                            found = items_of(self._resolve(whole_rate, inst, {}))[k]
                            self.raw.row(f"der({name})", self.raw.rate[var.index] - found)
                    elif rate is not None:
                        found = self._scalar(rate, inst, {})
                        self.raw.row(f"der({name})", self.raw.rate[var.index] - found)
        for s in inst.model.statements:
            if isinstance(s, Sampled):
                pairs = ((s.state, s.following), (s.name, s.value))
                values = {inst.known[n]: self._scalar(e, inst, {}) for n, e in pairs}
                self.raw.jumps.append(Jump(float(s.period), values))  # type: ignore[arg-type]
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
        if value.word in ("state", "held"):
            start = ZERO if value.value is None else self._resolve(value.value, inst, {})
            count = value.shape or 1
            starts = items_of(start) * (count if not isinstance(start, list) else 1)
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
        inst.known[name] = mapped(found, lambda e: self._named(path, e))
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
        items = items_of(self._resolve(e, inst, loops, own))
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
            case Apply(op=op, args=(xs, ys, u)) if is_curve(op):
                return Apply(op, (xs, ys, self._scalar(u, inst, loops, own)))
            case Apply(op=op, args=args):
                if op in ("<", ">", "<=", ">=") and Time() in args:
                    other = next(a for a in args if a != Time())
                    at = self._scalar(other, inst, loops, own)
                    self.raw.breaks.add(evaluate(at, {}, 0.0))
                return applied(op, [self._resolve(a, inst, loops, own) for a in args])
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
            return sum_of([self.effort[b] * self.flow[b] for b in bonds])
        return slim([(self.effort if variable == "e" else self.flow)[b] for b in bonds])

    def _variable(self, element: Element, variable: str) -> Flat:
        if element.is_junction:
            width = element.part.width[0]
            table = self.effort if variable == "e" else self.flow
            if not all(element.ends.get(("j", k)) for k in range(width)):
                raise Unconnected(f"{element.path} has a component without bonds")
            return slim([table[element.ends["j", k][0][0]] for k in range(width)])
        if variable == "power":
            if element.part.type in ("TF", "GY"):
                bonds = [element.bond("1", k)[0] for k in range(element.part.width[0])]
                return sum_of([self.effort[b] * self.flow[b] for b in bonds])
            sign = -1 if element.part.type in ("Se", "Sf") else 1
            return self._power(element, sign)
        self._states(element)
        if variable == "q":
            return slim(list(element.q))
        if variable == "p":
            return slim([element.p.get(k, ZERO) for k in range(element.part.width[0])])
        side = variable[1:] or "1"
        width = element.part.width[0 if side == "1" else -1]
        table = self.effort if variable[0] == "e" else self.flow
        return slim([table[element.bond(side, k)[0]] for k in range(width)])

    def _power(self, element: Element, sign: int) -> Expr:
        """The power into an element, times a sign."""
        terms = []
        for k in range(element.part.width[0]):
            bond, direction = element.bond("1", k)
            terms.append(Num(Fraction(sign * direction)) * self.effort[bond] * self.flow[bond])
        return sum_of(terms)

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
                used = [
                    x
                    for law in element.part.laws
                    for x in own_variables(law.value)
                    if x.name == "p"
                ]
                held_set = {(x.component or 1) - 1 for x in used}
                held = [k for k in range(width) if k in held_set]  # type: ignore[assignment]
            for k in held:
                element.p[k] = self.raw.new_x(f"{element.path}.p[{k}]")
