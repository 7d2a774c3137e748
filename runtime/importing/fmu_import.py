"""An FMU of another tool as a model: a sampled part with its parameters, inputs and outputs."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from bgc.diagnostics.catalogue.imported import not_importable
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source
from bgc.grammar.format import format_source
from bgc.record_class import dataclass
from bgc.runtime.importing.identifiers import Names
from bgc.runtime.importing.layout import call
from bgc.runtime.importing.notes import Notes
from bgc.runtime.running.fmu_folders import allow_fmu
from bgc.values.fmu_files import FmuFault, FmuFile, FmuUnit, FmuVariable, read_fmu
from bgc.values.units import DIMENSIONLESS, Dimension, parse_unit, si_symbol

_COMPONENT = re.compile(r"(.+)\[(\d+)\]")
_STEP = 1e-3  # s, where the FMU proposes none
_LAST = 10.0  # s, of the example
_NEWTON, _VOLT = (1, 1, -2, 0, 0, 0, 0), (1, 2, -3, -1, 0, 0, 0)
_DOMAINS: Mapping[tuple[Dimension, Dimension], tuple[str, str]] = {
    (_NEWTON, (0, 1, -1, 0, 0, 0, 0)): ("Translational", "mechanics.translation"),
    ((1, 2, -2, 0, 0, 0, 0), (0, 0, -1, 0, 0, 0, 0)): ("Rotational", "mechanics.rotation"),
    ((1, -1, -2, 0, 0, 0, 0), (0, 3, -1, 0, 0, 0, 0)): ("Hydraulic", "hydraulics.oil"),
    (_VOLT, (0, 0, 0, 1, 0, 0, 0)): ("Electrical", "electrical.circuits"),
}  # domains of the library by the dimensions of effort and flow


@dataclass(frozen=True, slots=True)
class PowerPort:
    """Two variables of an FMU, one set and one read, whose product is the power into it."""

    name: str
    effort: str
    flow: str


@dataclass(frozen=True, slots=True)
class _Group:
    """A variable, or the components of a vector, with its name in the model."""

    name: str
    members: tuple[FmuVariable, ...]
    is_vector: bool

    @property
    def unit(self) -> str:
        """The unit of the model's quantity, in SI; empty for a number."""
        return _written(self.members[0].unit)

    def declared(self) -> str:
        """Name, size and unit of a declaration."""
        size = f"[{len(self.members)}]" if self.is_vector else ""
        return f"{self.name}{size}{f' : {self.unit}' if self.unit else ''}"

    def given(self) -> Iterator[str]:
        """The name of each variable and the quantity that it is set to, in turn."""
        for k, variable in enumerate(self.members, 1):
            yield f'"{variable.name}"'
            yield f"{self.name}[{k}]" if self.is_vector else self.name


def import_fmu(
    path: Path, folder: Path, ports: Sequence[PowerPort], order: int, notes: Notes
) -> str:
    """Write an FMU as a `.bg` text that is to lie in `folder`, and unpack it for runs.

    With an `order` of 1 its outputs are held over a step. With 2 they are continued by straight
    lines, and it gets the mean of its inputs at both ends of a step.

    Raises
    ------
    BgError
        BG137 where it cannot be read, gives nothing, or a port is no pair of its variables.
    """
    try:
        file = read_fmu(path, str(path))
    except FmuFault as reason:
        what = f"cannot read the FMU {path}: {reason}"
        help = "export it for Co-Simulation, in FMI 2.0 or 3.0"
        raise BgError([not_importable(what, help=help)]) from reason
    if not _is_writable(place := os.path.relpath(path, folder)):
        what = f"the path of {path} has quotes or control characters"
        raise BgError([not_importable(what, help="rename the file or its folder")])
    text = _Writer(file, ports, order, notes).text(place)
    allow_fmu(path, file.digest)
    return format_source(Source(f"{path.stem}.bg", text))


class _Writer:
    """Writes the model of an FMU, and a scene that runs it alone."""

    def __init__(self, file: FmuFile, ports: Sequence[PowerPort], order: int, notes: Notes) -> None:
        self.file = file
        self.lines = order == 2
        self.names = Names(tuple(module for _, module in _DOMAINS.values()), ("time",))
        self.model = self.names.type(file.name)
        self.ports = [(self.names.value(port.name, "port"), port) for port in ports]
        self.step = self.names.value("step")
        self.values = self.names.value("values")
        self.before, self.earlier, self.last, self.taken, self.second = (
            self.names.value(name) if self.lines else ""
            for name in ("before", "earlier", "last", "taken", "second")
        )
        variables = [v for v in file.variables.values() if _is_writable(v.name)]
        self.parameters = self._groups([v for v in variables if v.causality == "parameter"])
        self.inputs = self._groups([v for v in variables if v.causality == "input"])
        self.outputs = self._groups([v for v in variables if v.causality == "output"])
        self._note(notes)
        if not self.outputs:
            what = f"the FMU {file.path} has no outputs"
            help = "export what the scene is to read as outputs"
            raise BgError([not_importable(what, help=help)])

    def _groups(self, variables: Sequence[FmuVariable]) -> list[_Group]:
        """Join components `x[1]`, `x[2]`, .. of one unit that follow each other."""
        found: list[_Group] = []
        waiting = [v for v in variables if v.kind]
        while waiting:
            members = _vector(waiting)
            whole = _COMPONENT.fullmatch(members[0].name) if len(members) > 1 else None
            name = whole[1] if whole else members[0].name
            waiting = waiting[len(members) :]
            found.append(_Group(self.names.value(name, "signal"), members, whole is not None))
        return found

    def _note(self, notes: Notes) -> None:
        """Note what the model cannot use, and units that are not known."""
        for variable in self.file.variables.values():
            if variable.causality not in ("parameter", "input", "output"):
                continue
            if not _is_writable(variable.name):
                cause = "variables are left out whose names have quotes or control characters"
                notes.group(None, cause, "rename them where the FMU is made")
            elif not variable.kind:
                cause = "texts, clocks and arrays of other sizes are left out"
                notes.group(None, cause, "nothing sets or reads them: their starts hold")
            elif variable.unit.text and variable.unit.dimension is None:
                cause = f"the unit `{variable.unit.text}` is not known: its variables are numbers"
                notes.group(None, cause, "multiply by a unit where you read or set them")

    # --- text ---------------------------------------------------------------------------------

    def text(self, path: str) -> str:
        """The whole text; `path` leads from its folder to the FMU."""
        lines = [*(f"import {module};" for module in self._modules()), ""]
        lines += self._head()
        lines += [f"model {self.model} {{", "/// Communication step.", self._step()]
        for group in self.parameters:
            lines += _documented(
                group, f"param {group.declared()} = {_start(group)}{_range(group)}"
            )
        paired = self._paired_inputs()
        for group in self.inputs:
            if group.name not in paired:
                lines += _documented(group, f"input {group.declared()} = {_start(group)}")
        lines += self._outputs()
        lines += self._ports()
        lines += [f"sample {self.step} {{", *self._sampled(path, paired), "}", "}", ""]
        return "\n".join([*lines, *self._scene()]) + "\n"

    def _modules(self) -> list[str]:
        return sorted({domain[1] for _, port in self.ports if (domain := self._domain(port))})

    def _head(self) -> list[str]:
        about = _plain(self.file.description)
        version = f"FMU of FMI {self.file.version}.0 for Co-Simulation"
        return [
            f"/// {_plain(self.file.name)}: {about or 'a model of another tool'}",
            f"/// ({version}).",
        ]

    def _step(self) -> str:
        step = self.file.step or _STEP
        return f"param {self.step} : s = {_number(step)} s;"

    def _outputs(self) -> list[str]:
        lines, place = [], 1
        for group in self.outputs:
            count = len(group.members)
            parts = [self._read(v, k) for k, v in enumerate(group.members, place)]
            value = f"[{', '.join(parts)}]" if group.is_vector else parts[0]
            lines += _documented(group, f"output {group.declared()} = {value}")
            place += count
        return lines

    def _read(self, variable: FmuVariable, place: int) -> str:
        """The value of an output: held, or on the straight line through the last two values."""
        held = f"{self.values}[{place}]"
        if not (self.lines and _is_real(variable)):
            return held
        slope = f"({held} - {self.before}[{place}])/{self.step}"
        return f"{held} + {self.second}*{slope}*(time - {self.last})"

    def _sampled(self, path: str, paired: Mapping[str, str]) -> Iterator[str]:
        """The call of the FMU, and what its straight lines need."""
        read = [v.name for group in self.outputs for v in group.members]
        names = ", ".join(f'"{name}"' for name in read)
        given = [text for group in self.parameters for text in group.given()]
        means: list[str] = []
        for group in self.inputs:
            other = paired.get(group.name)
            pairs = group.given() if other is None else (f'"{group.members[0].name}"', other)
            given += self._means(list(pairs), group.members, means)
        arguments = [f'"{Path(path).as_posix()}"', f"[{names}]", *given]
        yield call(f"signal {self.values}[{len(read)}] = fmu", arguments)
        if self.lines:
            yield from self._line_states(len(read), means)

    def _line_states(self, count: int, means: Sequence[str]) -> Iterator[str]:
        """The states of straight lines through the last values, and of means of the inputs."""
        yield "/// Values one step before, and the time of the last step."
        yield f"state {self.before}[{count}];"
        yield f"next({self.before}) = {self.values};"
        yield f"state {self.last} : s = 0 s;"
        yield f"next({self.last}) = time;"
        yield "/// 1 from the first instant on, and from the second one on."
        yield f"state {self.taken} = 0;"
        yield f"next({self.taken}) = 1;"
        yield f"state {self.second} = 0;"
        yield f"next({self.second}) = {self.taken};"
        if means:
            yield "/// Inputs one step before."
            yield f"state {self.earlier}[{len(means)}];"
            yield f"next({self.earlier}) = [{', '.join(means)}];"

    def _means(
        self, pairs: list[str], members: Sequence[FmuVariable], means: list[str]
    ) -> Iterator[str]:
        """The pairs of an input; a number becomes the mean over the step, and joins `means`."""
        for name, value, variable in zip(pairs[::2], pairs[1::2], members, strict=True):
            if self.lines and _is_real(variable):
                means.append(value)
                value += f" + {self.taken}*({self.earlier}[{len(means)}] - {value})/2"
            yield from (name, value)

    def _scene(self) -> list[str]:
        if self.ports:
            return []
        observed = ", ".join(group.name for group in self.outputs)
        lasts = max(_LAST, 10 * (self.file.step or _STEP))
        return [
            f"scene alone of {self.model} {{",
            f"observe {observed};",
            f"run {_number(lasts)} s;",
            "}",
        ]

    # --- power ports --------------------------------------------------------------------------

    def _ports(self) -> list[str]:
        """Each port leads to a source of what the FMU gives."""
        lines = []
        for name, port in self.ports:
            gives_effort = self._variable(port, port.effort).causality == "output"
            given = port.effort if gives_effort else port.flow
            kind, law = ("MSe", "e") if gives_effort else ("MSf", "f")
            source = f"{name}_source"
            domain = self._domain(port)
            lines += [
                f"/// Its power goes into the FMU: {_plain(port.effort)} * {_plain(port.flow)}.",
                f"port {name} in{f' : {domain[0]}' if domain else ''};",
                f"{source} : {kind}({law} = {self._value_of(given)});",
                f"{name} -> {source};",
            ]
        return lines

    def _paired_inputs(self) -> dict[str, str]:
        """What the inputs of power ports are set to, by their names in the model."""
        found = {}
        for name, port in self.ports:
            effort, flow = (self._variable(port, each) for each in (port.effort, port.flow))
            if {effort.causality, flow.causality} != {"input", "output"}:
                what = f"the port `{port.name}` needs an input and an output of the FMU"
                raise BgError([not_importable(what, help="pair an effort with a flow")])
            given, letter = (effort, "e") if effort.causality == "input" else (flow, "f")
            group = next(g for g in self.inputs if given in g.members)
            if group.is_vector:
                what = f"the port `{port.name}` is of a component: `{given.name}`"
                raise BgError([not_importable(what, help="write the port into the model by hand")])
            found[group.name] = f"{name}_source.{letter}"
        return found

    def _variable(self, port: PowerPort, name: str) -> FmuVariable:
        variable = self.file.variables.get(name)
        if variable is None or not variable.kind:
            what = f"the FMU has no number `{name}`, which the port `{port.name}` names"
            known = ", ".join(sorted(v.name for v in self.file.variables.values() if v.kind)[:20])
            raise BgError([not_importable(what, help=f"its variables are {known}")])
        return variable

    def _value_of(self, name: str) -> str:
        """The held value of an output, in a unit where it has none."""
        read = [v.name for group in self.outputs for v in group.members]
        return self._read(self.file.variables[name], read.index(name) + 1)

    def _domain(self, port: PowerPort) -> tuple[str, str] | None:
        units = [self._variable(port, each).unit.dimension for each in (port.effort, port.flow)]
        effort, flow = (() if unit is None else tuple(unit) for unit in units)
        return _DOMAINS.get((effort, flow))


def _is_writable(name: str) -> bool:
    """Return whether a text of the language can hold a name."""
    return name.isprintable() and '"' not in name


def _is_real(variable: FmuVariable) -> bool:
    return variable.kind in ("Real", "Float64", "Float32")


def _vector(waiting: Sequence[FmuVariable]) -> tuple[FmuVariable, ...]:
    """The first variable, or the components of the vector that begins there."""
    first = _COMPONENT.fullmatch(waiting[0].name)
    if first is None or first[2] != "1":
        return (waiting[0],)
    members = []
    for k, variable in enumerate(waiting, 1):
        same = variable.unit == waiting[0].unit
        if variable.name != f"{first[1]}[{k}]" or not same:
            break
        members.append(variable)
    return tuple(members)


def _written(unit: FmuUnit) -> str:
    """An SI unit for the dimension of an FMU's unit, in its words where they are known."""
    if unit.dimension is None:
        return ""
    known = parse_unit(unit.text.replace(".", "*"))
    if known is not None and known.dimension == unit.dimension:
        return "" if known.symbol == "1" else known.symbol
    return "" if unit.dimension == DIMENSIONLESS else si_symbol(unit.dimension)


def _documented(group: _Group, text: str) -> list[str]:
    """A declaration with the description of its variable."""
    about, first = _plain(group.members[0].description), group.members[0].name
    whole = first.removesuffix("[1]") if group.is_vector else first
    name = "" if group.name == whole else _plain(whole)
    doc = f"{about} ({name})" if about and name else about or name
    return [f"/// {doc}", f"{text};"] if doc else [f"{text};"]


def _start(group: _Group) -> str:
    """The starts in SI units."""
    numbers = [_si(v.unit, v.start or 0.0) for v in group.members]
    texts = [_quantity(each, group.unit) for each in numbers]
    return f"[{', '.join(texts)}]" if group.is_vector else texts[0]


def _range(group: _Group) -> str:
    """The range of a parameter; none where an end is open or the starts are not within."""
    low, high = group.members[0].low, group.members[0].high
    if low is None or high is None or group.is_vector or not low < high:
        return ""
    if (
        not all(math.isfinite(x) for x in (low, high))
        or not low <= (group.members[0].start or 0) <= high
    ):
        return ""
    ends = (_quantity(_si(group.members[0].unit, x), group.unit) for x in (low, high))
    return f" in {'..'.join(ends)}"


def _si(unit: FmuUnit, value: float) -> float:
    return unit.factor * value + unit.offset if unit.dimension is not None else value


def _quantity(value: float, unit: str) -> str:
    """A number with its unit, which one that begins with `1/` does not have behind it."""
    return f"{_number(value)} {unit}" if unit and not unit.startswith("1/") else _number(value)


def _number(value: float) -> str:
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def _plain(text: str) -> str:
    """A text of an FMU in one line of a comment."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())
