"""The raw equations of a program tree: every bond variable, junction and element law.

This is the reference's own elaboration. Models are opened, loops unrolled, wide bonds split, and
each element and junction gives its equations as they stand in a textbook, residual = 0. No
causality is assigned, nothing is solved or simplified.
"""

from __future__ import annotations

from fractions import Fraction

from flat_expressions import ZERO, Var, derivative, evaluate
from flat_lists import (
    Flat,
    as_matrix,
    inverse,
    items_of,
    only,
    step_name,
    sum_of,
)
from program_tree import (
    Apply,
    Expr,
    Num,
    Part,
    Program,
)
from raw_instances import Element, Instance, Point, Raw, Storage
from raw_values import Values


class Elaboration(Values):
    """Opens a program; `raw` holds the result."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.raw = Raw()
        self.elements: list[Element] = []
        self.segments: list[tuple[Point, Point]] = []  # scalar pieces of bonds, tail and head
        self.sets = {".".join(step_name(s) for s in p): v for p, v in program.scene.sets}
        self.drives = {".".join(step_name(s) for s in p): v for p, v in program.scene.drives}
        self.uses = {u.name: u for u in program.scene.uses}
        self.main = self._open(program.main, "", None, {}, None)
        self._join()
        self._laws(self.main)
        for element in self.elements:
            self._equations(element)
        for o in program.scene.observed:
            value = self._scalar(o.value, self.main, {})
            self.raw.observed.append((o.name, value, o.scale))

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
                ends = element.ends.get(("j", k), [])
                if not ends:
                    continue
                for bond, _ in ends[1:]:
                    raw.row(element.path, same[bond] - same[ends[0][0]])
                raw.row(element.path, sum_of([Num(Fraction(sign)) * summed[b] for b, sign in ends]))
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
            items = items_of(found) if isinstance(found, list) else [found] * width
            for k in range(width):
                raw.row(element.path, (e if letter == "e" else f)[k] - items[k])
            raw.supplied.append(self._power(element, -1))
        elif part.type == "GY":
            items = items_of(value(part.laws[0].value, names))
            for k in range(width):
                raw.row(element.path, e[k] - items[k])
        elif part.type == "R":
            raw.dissipated.append(self._power(element, 1))
            if own:
                ((argument, given),) = own.items()
                left, right = (e, f) if argument == "resistance" else (f, e)
                m = as_matrix(value(given), width)
                for k in range(width):
                    raw.row(
                        element.path, left[k] - sum_of([m[k][j] * right[j] for j in range(width)])
                    )
            else:
                letter = part.laws[0].variable
                items = items_of(self._law_items(part, letter, value, names))
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
        return [only(value(by_place[k + 1].value, names)) for k in range(part.width[0])]

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
            h = only(value(energy[0].value, names))
            by_charge = [derivative(h, x) for x in q]
            by_momentum = [derivative(h, p[k]) if k in p else ZERO for k in range(width)]
        elif part.laws:
            letter = part.laws[0].variable  # e of q, or f of p
            items = items_of(self._law_items(part, letter, value, names))
            by_charge, by_momentum = (items, []) if letter == "e" else ([], items)
        else:
            argument = next(a for a in own if a in ("compliance", "stiffness", "inertia"))
            m = as_matrix(value(own[argument]), width)
            if argument != "stiffness":
                m = inverse(m)
            held = q if part.type == "C" else [p[k] for k in range(width)]
            items = [sum_of([m[k][j] * held[j] for j in range(width)]) for k in range(width)]
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
            items = items_of(given) if isinstance(given, list) else [given] * width
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
        m = as_matrix(value(given), len(sides[left]), len(sides[right]))
        dual = {"e": "f", "f": "e"}
        dual_left = dual[right[0]] + right[1]
        dual_right = dual[left[0]] + left[1]
        for i, x in enumerate(sides[left]):
            raw.row(element.path, x - sum_of([m[i][j] * y for j, y in enumerate(sides[right])]))
        for j, x in enumerate(sides[dual_left]):
            raw.row(
                element.path, x - sum_of([m[i][j] * y for i, y in enumerate(sides[dual_right])])
            )


def raw_equations(program: Program) -> Raw:
    return Elaboration(program).raw


__all__ = ["Elaboration", "Element", "Instance", "Raw", "raw_equations"]
