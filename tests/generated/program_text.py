"""Write program trees as text, in many equivalent ways."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeVar

from curves import is_curve
from program_tree import (
    SECOND,
    Apply,
    Assign,
    Bond,
    End,
    Equation,
    Expr,
    For,
    Interface,
    Model,
    Num,
    Own,
    Part,
    Port,
    Program,
    Read,
    Sampled,
    Scene,
    Statement,
    Step,
    Time,
    Unit,
    Value,
)

# Other words for an SI word, with their factors.
WORDS: dict[str, list[tuple[str, Fraction]]] = {
    "N": [("N", Fraction(1)), ("kN", Fraction(1000)), ("mN", Fraction(1, 1000))],
    "m": [("m", Fraction(1)), ("mm", Fraction(1, 1000)), ("cm", Fraction(1, 100))],
    "s": [("s", Fraction(1)), ("ms", Fraction(1, 1000))],
    "kg": [("kg", Fraction(1)), ("g", Fraction(1, 1000)), ("t", Fraction(1000))],
    "V": [("V", Fraction(1)), ("mV", Fraction(1, 1000)), ("kV", Fraction(1000))],
    "A": [("A", Fraction(1)), ("mA", Fraction(1, 1000)), ("uA", Fraction(1, 10**6))],
    "Pa": [("Pa", Fraction(1)), ("kPa", Fraction(1000)), ("bar", Fraction(100000))],
    "rad": [("rad", Fraction(1)), ("mrad", Fraction(1, 1000))],
}

_Item = TypeVar("_Item")


@dataclass(frozen=True)
class Style:
    """A way of writing a program; every choice leaves its numbers as they are.

    `units` draws the words of units from `WORDS`, or leaves them out. `unrolled` writes each
    pass of a loop. `shuffled` changes the order of statements and declarations. `renamed` gives
    every name another one. `turned` turns arrows round that may point either way.
    """

    units: bool = False
    unrolled: bool = False
    shuffled: bool = False
    renamed: bool = False
    turned: bool = False
    seed: int = 0


@dataclass
class Writer:
    """Text of a program in one style."""

    program: Program
    style: Style = field(default_factory=Style)

    def __post_init__(self) -> None:
        self.rng = random.Random(self.style.seed)
        self.names: dict[str, str] = {}
        self.loops: dict[str, int] = {}
        program = self.program
        self._types = {m.name for m in program.models} | {i.name for i in program.interfaces}

    # --- names and numbers --------------------------------------------------------------

    def name(self, name: str) -> str:
        """The name as it is written; types and values of the program have one name each."""
        if not self.style.renamed or name in _FIXED:
            return name
        if name not in self.names:
            taken = set(self.names.values())
            free = [w for w in _OTHER_NAMES if w not in taken]
            if name in self._types:  # those of elements are taken
                free = [w for w in free if w not in _ELEMENTS]
            self.names[name] = self.rng.choice(free) if free else f"other_{len(taken)}"
        return self.names[name]

    def number(self, value: Fraction, unit: Unit, *, bare: bool = False) -> str:
        words, factor = _unit_text(unit), Fraction(1)
        if self.style.units:
            if self.rng.random() < 0.25:
                bare = True
            words, factor = self._other_words(unit)
        if bare or not words:
            return decimal(value)
        return f"{decimal(value / factor)} {words}"

    def _other_words(self, unit: Unit) -> tuple[str, Fraction]:
        powers, factor = [], Fraction(1)
        for word, power in unit.powers:
            other, scale = self.rng.choice(WORDS.get(word, [(word, Fraction(1))]))
            powers.append((other, power))
            factor *= scale**power
        return _unit_text(Unit(tuple(powers))), factor

    # --- expressions --------------------------------------------------------------------

    def text(self, e: Expr) -> str:
        match e:
            case Num(value=value, unit=unit):
                written = self.number(abs(value), unit)
                return f"(-{written})" if value < 0 else written
            case Time():
                return "time"
            case Own(name=name, component=component):
                return name if component is None else f"{name}[{component}]"
            case Read(path=(Step(name=name, index=None),), component=None) if name in self.loops:
                return str(self.loops[name])
            case Read(path=path, component=component):
                inner = "" if component is None else f"[{self.index(component)}]"
                return self.path(path) + inner
            case Apply(op="vector", args=args):
                return f"[{', '.join(self.text(a) for a in args)}]"
            case Apply(op="matrix", args=args):
                return f"[{', '.join(self.text(a) for a in args)}]"
            case Apply(op="neg", args=(a,)):
                return f"(-{self.atom(a)})"
            case Apply(op="if", args=(a, b, c)):
                return f"(if {self.text(a)} then {self.text(b)} else {self.text(c)})"
            case Apply(op="^", args=(a, b)):
                return f"({self.text(a)})^{self.text(b)}"
            case Apply(op=op, args=args) if is_curve(op):
                _, method, outside = op.split()
                data = ", ".join(self.text(a) for a in args)
                return f"interpolate({data}, method = {method}, outside = {outside})"
            case Apply(op=op, args=(a, b)) if not op[0].isalpha():
                return f"{self.atom(a)} {op} {self.atom(b)}"
            case Apply(op=op, args=args):
                return f"{op}({', '.join(self.text(a) for a in args)})"
        raise AssertionError(e)

    def atom(self, e: Expr) -> str:
        binary = isinstance(e, Apply) and not e.op[0].isalpha() and e.op != "^"
        return f"({self.text(e)})" if binary else self.text(e)

    def index(self, e: Expr) -> str:
        """An index, worked out where the loop around it is written pass by pass."""
        try:
            return str(whole(e, self.loops))
        except KeyError:
            return self.text(e)

    def path(self, path: Iterable[Step]) -> str:
        return ".".join(
            self.name(s.name) + ("" if s.index is None else f"[{self.index(s.index)}]")
            for s in path
        )

    # --- statements ---------------------------------------------------------------------

    def statement(self, s: Statement, indent: str) -> list[str]:
        match s:
            case Value():
                return [indent + self.value(s)]
            case Assign(name=name, value=value, component=component, rate=rate):
                target = self.name(name)
                if component is not None:
                    target += f"[{self.index(component)}]"
                target = f"der({target})" if rate else target
                return [f"{indent}{target} = {self.text(value)};"]
            case Equation(left=left, right=right):
                return [f"{indent}equation {self.text(left)} = {self.text(right)};"]
            case Port(name=name, direction=direction, width=width):
                wide = f"[{width}]" if width > 1 else ""
                return [f"{indent}port {self.name(name)}{wide} {direction};"]
            case Part():
                return [indent + self.part(s)]
            case Sampled():
                return [indent + line for line in self.sampled(s)]
            case Bond(tail=tail, head=head):
                a, b = self.end(tail), self.end(head)
                return [f"{indent}{a} -> {b};"]
            case For(variable=variable, first=first, last=last, body=body):
                if self.style.unrolled:
                    return self._passes(s, indent)
                head = f"for {variable} in {self.text(first)}..{self.text(last)} {{"
                inner = [
                    line for b in self.order(body) for line in self.statement(b, indent + "  ")
                ]
                return [indent + head, *inner, indent + "}"]
        raise AssertionError(s)

    def _passes(self, s: For, indent: str) -> list[str]:
        low, high = (whole(e, self.loops | self._constants) for e in (s.first, s.last))
        lines: list[str] = []
        for k in range(low, high + 1):
            self.loops[s.variable] = k
            lines += [line for b in s.body for line in self.statement(b, indent)]
        self.loops.pop(s.variable, None)
        return lines

    def value(self, s: Value) -> str:
        shape = "" if s.shape is None else f"[{s.shape}]"
        text = f"{s.word} {self.name(s.name)}{shape}"
        bare = self.style.units and self.rng.random() < 0.5
        if s.unit is not None and not bare and s.unit.powers:
            text += f" : {_unit_text(s.unit)}"
        if s.value is not None:
            text += f" = {self.text(s.value)}"
        return text + ";"

    def part(self, s: Part) -> str:
        index = "" if s.index is None else f"[{self.index(s.index)}]"
        text = f"{self.name(s.name)}{index} : "
        if s.slot is not None:
            text += f"{self.name(s.slot)} = "
        text += self.type_use(s)
        if s.laws:
            laws = " ".join(self.law(x) for x in s.laws)
            return f"{text} {{ {laws} }}"
        return text + ";"

    def sampled(self, s: Sampled) -> list[str]:
        of = f" : {_unit_text(s.unit)}" if s.unit.powers else ""
        inside = [
            f"state {self.name(s.state)}{of} = {self.text(s.start)};",
            f"next({self.name(s.state)}) = {self.text(s.following)};",
            f"output {self.name(s.name)}{of} = {self.text(s.value)};",
        ]
        head = f"sample {self.number(s.period, SECOND)} {{"
        return [head, *(f"  {line}" for line in self.order(inside)), "}"]

    def type_use(self, s: Part) -> str:
        element = s.type in _ELEMENTS
        text = ("M" if s.varies else "") + s.type if element else self.name(s.type)
        if s.dimension is not None:
            text += f"[{self.text(s.dimension)}]"
        elif element and max(s.width) > 1:
            text += f"[{', '.join(map(str, s.width))}]"
        if s.arguments:
            first, *others = s.arguments
            words = []
            if element and first[0] in _FIRST and self.rng.random() < 0.5:
                words.append(self.text(first[1]))
            else:
                others = [first, *others]
            keep = (lambda n: n) if element else self.name
            words += [f"{keep(name)} = {self.text(value)}" for name, value in others]
            text += f"({', '.join(words)})"
        return text

    def law(self, law: object) -> str:
        place = "" if law.component is None else f"[{law.component}]"  # type: ignore[attr-defined]
        return f"{law.variable}{place} = {self.text(law.value)};"  # type: ignore[attr-defined]

    def end(self, end: End) -> str:
        text = self.path(end.path)
        if end.slice is not None:
            a, b = end.slice
            text += f"[{a}]" if a == b else f"[{a}..{b}]"
        return text if end.place is None else f"{text}[{end.place}]"

    # --- declarations -------------------------------------------------------------------

    def order(self, items: Iterable[_Item]) -> list[_Item]:
        listed = list(items)
        if self.style.shuffled:
            self.rng.shuffle(listed)
        return listed

    def model(self, model: Model) -> str:
        self._constants = dict([model.dimension]) if model.dimension else {}
        for s in model.statements:
            if isinstance(s, Value) and s.word == "const" and isinstance(s.value, Num):
                self._constants[s.name] = int(s.value.value)
        dims = ""
        if model.dimension is not None:
            dims = f"[{self.name(model.dimension[0])} = {model.dimension[1]}]"
        of = f" is {self.name(model.interface)}" if model.interface else ""
        lines = [f"model {self.name(model.name)}{dims}{of} {{"]
        for s in self.order(model.statements):
            lines += self.statement(s, "  ")
        return "\n".join([*lines, "}"])

    def interface(self, interface: Interface) -> str:
        lines = [f"interface {self.name(interface.name)} {{"]
        for s in (*interface.ports, *interface.outputs):
            lines += self.statement(s, "  ")
        return "\n".join([*lines, "}"])

    def scene(self, scene: Scene, name: str = "test") -> str:
        lines = [f"scene {name} of {self.name(self.program.main.name)} {{"]
        for use in scene.uses:
            path = self.path([Step(n) for n in use.name.split(".")])
            lines.append(f"  use {path} = {self.type_use(use)};")
        lines += [f"  set {self.path(path)} = {self.text(value)};" for path, value in scene.sets]
        lines += [f"  drive {self.path(p)} = {self.text(value)};" for p, value in scene.drives]
        for o in scene.observed:
            lines.append(f"  observe {self.text(o.value)} as {o.name};")
        if scene.accounts:
            lines.append("  observe energy.stored, energy.supplied, energy.dissipated;")
        if scene.solver:
            lines.append(f"  solver {scene.solver};")
        run = decimal(scene.duration)
        lines.append(f"  run {run} s every {decimal(scene.duration / scene.rows)} s;")
        return "\n".join([*lines, "}"])

    def whole_text(self) -> str:
        makers: list[Callable[[], str]] = [
            *(lambda i=i: self.interface(i) for i in self.program.interfaces),  # type: ignore[misc]
            *(lambda m=m: self.model(m) for m in self.program.models),  # type: ignore[misc]
            lambda: self.scene(self.program.scene),
        ]
        if self.style.shuffled:
            self.rng.shuffle(makers)
        return "\n\n".join(make() for make in makers) + "\n"


def write(program: Program, style: Style | None = None) -> str:
    return Writer(program, style or Style()).whole_text()


_ELEMENTS = frozenset("Se Sf C I R TF GY J0 J1 IC Mux Demux".split())
_FIRST = frozenset("e f compliance inertia resistance ratio".split())
# Names that are the language's: variables of elements, accounts.
_FIXED = frozenset("e f p q e1 f1 e2 f2 power energy stored supplied dissipated i j pi".split())
# Other names: those of units, of elements, soft words of the language, long and short ones.
_OTHER_NAMES = (
    "R C I J0 J1 Se TF GY m N s V A kg Pa bar t h effort flow main of is out pseudo plot against "
    "keep within every as x y z u v w _a _1 a1 B_2 velocity stiffness compliance resistance ratio "
    "inertia sample when reset start data k K k3 mass Mass MASS observe run solver device drive "
    "step deadline require sinus cosine sin_ length_ maximum e0 f0 q0 p0 e3 left right base tip "
    "lambda_ int double static return struct void auto register M_PI NAN inline restrict"
).split()


def decimal(value: Fraction) -> str:
    """A fraction as a decimal number, which it has to be exactly."""
    for digits in range(40):
        scaled = value * 10**digits
        if scaled.denominator == 1:
            if not digits:
                return str(value.numerator)
            text = str(scaled.numerator).rjust(digits + 1, "0")
            if digits > 6 and value < Fraction(1, 10**4):
                return f"{scaled.numerator}e-{digits}"
            return f"{text[:-digits]}.{text[-digits:]}"
    raise AssertionError(f"{value} is not a decimal number")


def _unit_text(unit: Unit) -> str:
    above = [(w, p) for w, p in unit.powers if p > 0]
    below = [(w, -p) for w, p in unit.powers if p < 0]
    if not above:
        return "*".join(f"{w}^-{p}" for w, p in below)
    text = "*".join(w if p == 1 else f"{w}^{p}" for w, p in above)
    return text + "".join(f"/{w}" if p == 1 else f"/{w}^{p}" for w, p in below)


def whole(e: Expr, loops: dict[str, int]) -> int:
    """The value of an index; KeyError where it holds a name that has none here."""
    match e:
        case Num(value=value):
            return int(value)
        case Read(path=(Step(name=name),)):
            return loops[name]
        case Apply(op=op, args=(a, b)):
            x, y = whole(a, loops), whole(b, loops)
            return {"+": x + y, "-": x - y, "*": x * y}[op]
    raise KeyError(e)
