"""Models of BondGraphTools, in the YAML that its `save` writes (version 0.1).

Conventions of BondGraphTools 0.4: all ports count power into the component, both ends of a bond
have one effort and opposite flows, and a port of a 1-junction has a weight: +1 for a bond that
enters it, -1 for one that leaves it, unless the file names `inverting` or `non_inverting`. The
direction of other bonds means nothing. Where an arrow of our own has to point the other way at a
1-junction, both variables of the element change their sign.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

from bgc.diagnostics.catalogue import did_you_mean, listed
from bgc.diagnostics.catalogue.imported import not_importable, wrong_structure, wrong_value
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar.format import format_source
from bgc.record_class import dataclass, field
from bgc.runtime.importing.identifiers import Names
from bgc.runtime.importing.plain_yaml import Scalar, Value, read_yaml
from bgc.runtime.importing.rotation_text import number

_VERSION = "0.1"
# Parameters of each component, with BondGraphTools' defaults; None is an input.
_KINDS: dict[str, dict[str, float | None]] = {
    "base/0": {},
    "base/1": {},
    "base/R": {"r": 1000.0},
    "base/C": {"C": 1000.0},
    "base/I": {"L": 2000.0},
    "base/Se": {"e": None},
    "base/Sf": {"f": None},
    "base/TF": {"r": 1.0},
    "base/GY": {"R": 1.0},
    "elec/Di": {"Is": 1.0, "n": 1.0, "Vt": 0.0258563},
    "BioChem/Ce": {"k": 1.0, "R": 8.314, "T": 300.0},
}
_SINKS = ("base/R", "base/C", "base/I", "elec/Di", "BioChem/Ce")  # take the arrow
_TWO_PORTS = ("base/TF", "base/GY")


@dataclass(slots=True)
class _Component:
    """A component: `ends` are its bonds as [inward, sign], by port for two-ports."""

    name: str
    title: str
    kind: str
    values: dict[str, float | None]
    span: Span
    ends: dict[int, tuple[bool, int]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _End:
    """One end of a bond; `into` is whether an arrow has to enter here, None where it does not
    matter."""

    component: _Component
    port: int | None
    into: bool | None


def read_bond_graph_tools(source: Source) -> str:
    """Convert a model to the text of a `.bg` file.

    Raises
    ------
    BgError
        BG137 where the file is not of that kind, BG138 for components without a counterpart and
        wrong values, BG270 for bonds of components that do not exist.
    """
    return _Model(source).text()


class _Model:
    def __init__(self, source: Source) -> None:
        self.source = source
        self.names = Names()
        self.components: dict[str, _Component] = {}
        self.faults: list[Diagnostic] = []
        self.lines: list[str] = []
        self.joined = 0

    def text(self) -> str:
        name, model = self._root()
        ports = model.get("ports")
        if ports:
            raise BgError([self._not_flat(_first(ports))])
        for item in _items(model.get("components")):
            self._component(item)
        if not self.components and not self.faults:
            raise BgError([not_importable("the model has no components", _whole(self.source))])
        bonds = []
        for item in _items(model.get("netlist")):
            bond = self._bond(item)
            if bond is not None:
                bonds.append(bond)
        if self.faults:
            raise BgError(self.faults)
        arrows = [line for bond in bonds for line in self._arrows(*bond)]
        return format_source(Source(f"{name}.bg", "\n".join(self._file(name, arrows)) + "\n"))

    def _root(self) -> tuple[str, dict[str, Value]]:
        data = read_yaml(self.source)
        help = "name a file that `BondGraphTools.save` wrote"
        whole = _whole(self.source)
        if not isinstance(data, dict) or not {"version", "models"} <= data.keys():
            what = "this is not a model of BondGraphTools: `version` and `models` are missing"
            raise BgError([not_importable(what, whole, help)])
        version = data["version"]
        if not isinstance(version, Scalar) or version.text != _VERSION:
            what = f"this version of the format is not read: {_VERSION} is"
            raise BgError([not_importable(what, _first(version) or whole, help)])
        models = data["models"]
        root = models.get("/") if isinstance(models, dict) else None
        if not isinstance(root, dict):
            raise BgError([not_importable("there is no model `/`", whole, help)])
        name = data.get("root")
        return (name.text if isinstance(name, Scalar) else Path(self.source.name).stem), root

    def _component(self, item: Scalar) -> None:
        words = item.text.split()
        if len(words) < 2 or words[1].startswith("/"):
            self.faults.append(self._not_flat(item.span))
            return
        title, kind, *arguments = words
        if kind not in _KINDS:
            what = f"`{kind[:40]}` has no counterpart"
            help = did_you_mean(kind, _KINDS) or f"these are read: {listed(list(_KINDS), 20)}"
            self.faults.append(wrong_value(item.span, what, help))
            return
        if title in self.components:
            what = f"two components have the name `{title}`"
            self.faults.append(wrong_structure(item.span, what, "give one of them another name"))
            return
        values = dict(_KINDS[kind])
        for argument in arguments:
            key, _, text = argument.partition("=")
            value = _number(text)
            if key not in values or value is None:
                what = f"`{argument[:40]}` is not a value of {kind}"
                help = f"give {listed([f'{name}=1.5' for name in values])}"
                self.faults.append(wrong_value(item.span, what, help))
                return
            values[key] = value
        if kind in _TWO_PORTS and not values[next(iter(values))]:
            self.faults.append(wrong_value(item.span, "the ratio is zero", "give another ratio"))
            return
        self.components[title] = _Component(self.names.value(title), title, kind, values, item.span)

    def _not_flat(self, span: Span | None) -> Diagnostic:
        what = "models inside models, and ports of a model, are not read"
        return wrong_value(span, what, "build the model in one level, and save it again")

    def _bond(self, item: Scalar) -> tuple[_End, _End] | None:
        words = item.text.split()
        if len(words) != 2:
            what = "a bond names two components"
            self.faults.append(wrong_structure(item.span, what, "write `- tail head`"))
            return None
        try:
            return self._end(words[0], item.span, False), self._end(words[1], item.span, True)
        except BgError as fault:
            self.faults.extend(fault.diagnostics)
            return None

    def _end(self, text: str, span: Span, head: bool) -> _End:
        # A port is the last word behind a dot; names may have dots too.
        title, port = text, ""
        if title not in self.components:
            title, _, port = text.rpartition(".")
        component = self.components.get(title)
        if component is None:
            what = f"the bond names `{text}`, which is not a component"
            if any(fault.code == "BG138" for fault in self.faults):
                raise BgError([])  # the component may be the one that could not be read
            help = did_you_mean(text, self.components) or "name a component of the list"
            raise BgError([wrong_structure(span, what, help)])
        if component.kind == "base/1":
            inverting = {"inverting": True, "non_inverting": False}.get(port, not head)
            return _End(component, None, not inverting)
        if component.kind == "base/0":
            return _End(component, None, None)
        number = int(port) if port in ("0", "1") else None
        if number is None and component.kind in _TWO_PORTS:
            number = 0 if 0 not in component.ends else 1
        number = number or 0
        if number in component.ends or (number == 1 and component.kind not in _TWO_PORTS):
            what = f"port {number} of `{title}` has more than one bond, or does not exist"
            raise BgError([wrong_structure(span, what, "put a junction there")])
        component.ends[number] = (head, 1)
        return _End(component, number, None)

    # --- arrows --------------------------------------------------------------------

    def _arrows(self, tail: _End, head: _End) -> list[str]:
        """Direct a bond; 1-junctions demand a direction, elements prefer one."""
        a, b = tail.component.name, head.component.name
        if tail.into is not None and tail.into == head.into:  # both weights are +1, or both -1
            turned = self.names.value("turned")
            self.lines.append(f"{turned} : TF(-1);")
            return [f"{a} -> {turned} -> {b};"]
        forward = (
            tail.into is False or head.into is True or (tail.into is None and head.into is None)
        )
        wish = self._wish(tail), self._wish(head)
        demanded = tail.into is not None or head.into is not None
        if wish[0] is not None and wish[0] == wish[1]:  # both take the arrow, or both give it
            node = self.names.value("node")
            self.lines.append(f"{node} : J0;")
            return [f"{node} -> {a}, {b};" if wish[0] else f"{a}, {b} -> {node};"]
        direction = forward
        if wish[1] is not None:
            direction = wish[1]
        elif wish[0] is not None:
            direction = not wish[0]
        sign = -1 if demanded and direction != forward else 1
        for end, into in ((tail, not direction), (head, direction)):
            if end.port is not None:
                end.component.ends[end.port] = (into, sign)
        return [f"{a} -> {b};" if direction else f"{b} -> {a};"]

    def _wish(self, end: _End) -> bool | None:
        """Return True where an arrow has to enter, False where it has to leave, None for either."""
        component = end.component
        if component.kind in _SINKS:
            return True
        if component.kind in _TWO_PORTS and end.port is not None:
            return end.port == 0
        return None

    # --- text ----------------------------------------------------------------------

    def _file(self, name: str, arrows: list[str]) -> list[str]:
        model = self.names.type(name)
        inputs: list[str] = []
        parts: list[str] = []
        observed = []
        for component in self.components.values():
            parts.append(self._part(component, inputs))
            if component.kind in ("base/0", "base/1"):
                observed.append(f"{component.name}.{'ef'[int(component.kind[-1])]}")
        if not observed:
            observed = [f"{c.name}.power" for c in self.components.values()]
        observed = observed[:12]
        title = " ".join(name.split())
        file = Path(self.source.name).name
        return [
            f"/// The model {title}, from the file {file} of BondGraphTools.",
            "///",
            "/// BondGraphTools has no units: values are numbers in the model's own units.",
            f"model {model} {{",
            *inputs,
            *parts,
            *self.lines,
            "",
            *arrows,
            "}",
            "",
            "/// The efforts of 0-junctions and the flows of 1-junctions.",
            f"scene {self.names.value(name.lower(), 'scene')} of {model} {{",
            f"observe {', '.join(observed)};",
            "run 10 s every 0.1 s;",
            "}",
        ]

    def _part(self, component: _Component, inputs: list[str]) -> str:
        name, values = component.name, component.values
        given = next(iter(values.values()), None)
        inward, sign = component.ends.get(0, (True, 1))
        match component.kind:
            case "base/0" | "base/1":
                return f"{name} : J{component.kind[-1]};"
            case "base/R" | "base/C" | "base/I":
                return f"{name} : {component.kind[-1]}({number(given or 0)});"
            case "base/Se" | "base/Sf":
                letter = component.kind[-1]
                value = "" if given is None else number(given)
                if given is None:
                    value = self.names.value(f"{name}_{letter}")
                    inputs += [f"/// Given to `{component.title}`.", f"input {value} = 0;"]
                if letter == "f" and inward:
                    value = f"-{value}" if not value.startswith("-") else value[1:]
                return f"{name} : S{letter}({letter} = {value});"
            case "base/TF" | "base/GY":
                return f"{name} : {component.kind[-2:]}({number(self._ratio(component))});"
            case "elec/Di":
                scale = number((values["n"] or 1) * (values["Vt"] or 1))
                current = number((values["Is"] or 0) * sign)
                exponent = "-e" if sign < 0 else "e"
                return f"{name} : R {{ f = {current}*(exp({exponent}/{scale}) - 1); }}"
            case _:  # a chemical species
                scale = number((values["R"] or 1) * (values["T"] or 1) * sign)
                amount = "-q" if sign < 0 else "q"
                start = "-1" if sign < 0 else "1"
                law = f"e = {scale}*log({number(values['k'] or 1)}*{amount});"
                return f"{name} : C(q0 = {start}) {{ {law} }}"

    def _ratio(self, component: _Component) -> float:
        """Ratio of our two-port, which has its first bond at port 0."""
        ratio = next(iter(component.values.values())) or 1.0
        sign = math.prod(sign for _, sign in component.ends.values())
        return sign / ratio if component.kind == "base/TF" else -sign * ratio


def _number(text: str) -> float | None:
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", text):
        return None
    value = float(text)
    return value if abs(value) < 1e18 else None


def _items(value: Value) -> list[Scalar]:
    return [item for item in value if isinstance(item, Scalar)] if isinstance(value, list) else []


def _first(value: Value) -> Span | None:
    if isinstance(value, Scalar):
        return value.span
    return _first(value[0]) if isinstance(value, list) and value else None


def _whole(source: Source) -> Span:
    return Span(source, 0, max(source.line_length(1), 1) if source.text else 0)
