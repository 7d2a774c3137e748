"""Systems of FMUs: an archive of SSP 1.0 (System Structure and Parameterization).

The archive has `SystemStructure.ssd` with the parts, their connectors and connections, and for
each part its FMU (FMI 2.0) and its parameter set in `resources/`. Connectors of the system itself
are only the inputs that were asked for: libcosim refuses a system that has any.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path

from bgc.algebra.dag import Level
from bgc.building.platforms import Platform
from bgc.diagnostics.catalogue.systems import (
    connected_twice,
    connection_mismatch,
    malformed_connection,
    malformed_part,
    no_such_part,
    no_such_signal,
    part_named_twice,
)
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.record_class import dataclass, replace
from bgc.runtime.documents.templates import render_template
from bgc.runtime.fmi.export import archived, fmu_archive
from bgc.runtime.fmi.fmu_model import FmuModel, identifier_of, prepare_model
from bgc.runtime.fmi.fmu_units import unit_definitions, unit_name
from bgc.runtime.fmi.fmu_variables import Variable
from bgc.values.units import parse_unit

_PART = re.compile(r"([A-Za-z]\w*)=(.*)", re.DOTALL)
_SCENE = re.compile(r"(.*):([A-Za-z_]\w*)", re.DOTALL)
_CONNECTION = re.compile(r"\s*([A-Za-z]\w*)\.(\S+)\s*->\s*([A-Za-z]\w*)\.(\S+)\s*")
_SUFFIX = re.compile(r"\.(?:input|output|account|command)(?=\[|$)")
_PORT = re.compile(r"\.[ef](?=\[|$)")
_OUTPUTS = ("output", "account", "command")


@dataclass(frozen=True, slots=True)
class PartFile:
    """A part of a system: its name, its file and the options with its scene."""

    name: str
    file: Path
    options: Options


@dataclass(frozen=True, slots=True)
class Wire:
    """A connection: an output of one part and an input of another; a vector or a component."""

    source: str
    output: str
    sink: str
    input: str

    def __str__(self) -> str:
        return f"{self.source}.{self.output} -> {self.sink}.{self.input}"


@dataclass(frozen=True)
class Part:
    """A part that is ready for export."""

    name: str
    model: FmuModel
    outer: tuple[str, ...] = ()  # inputs that are connectors of the system too

    @cached_property
    def outputs(self) -> Mapping[str, tuple[Variable, ...]]:
        """Outputs by name, the components of a vector by its name too."""
        listed = self.model.table.listed
        return _by_name([v for v in listed if v.causality == "output" and v.kind in _OUTPUTS])

    @cached_property
    def inputs(self) -> Mapping[str, tuple[Variable, ...]]:
        """Inputs by name, the components of a vector by its name too."""
        return _by_name(list(self.model.table.of("input")))


@dataclass(frozen=True, slots=True)
class System:
    """Parts and the pairs of scalar variables that are connected, each with its part's name."""

    name: str
    parts: tuple[Part, ...]
    connections: tuple[tuple[str, Variable, str, Variable], ...]


@dataclass(frozen=True, slots=True)
class _Connector:
    name: str
    kind: str
    unit: str


def read_part(text: str, file: Path) -> PartFile:
    """Read `NAME=FILE:SCENE`; without FILE another scene of `file`, without SCENE the first one."""
    match = _PART.fullmatch(text)
    if match is None or not match[2].strip():
        raise BgError([malformed_part(text)])
    name, place = match.groups()
    with_scene = None if Path(place).is_file() else _SCENE.fullmatch(place)
    path, scene = (place, None) if with_scene is None else with_scene.groups()
    return PartFile(name, Path(path) if path else file, Options(scene))


def read_wire(text: str) -> Wire:
    """Read a connection `plant.angle -> loop.measured`."""
    match = _CONNECTION.fullmatch(text)
    if match is None:
        raise BgError([malformed_connection(text)])
    return Wire(*match.groups())


def first_part(file: Path, options: Options) -> PartFile:
    """Return the part of the file of the command, which has the name of its FMU."""
    return PartFile(identifier_of(file, options.scene), file, options)


def prepare_system(
    parts: Sequence[PartFile], wires: Sequence[Wire], inputs: Sequence[str] = ()
) -> System:
    """Compile the parts of a system, and compare its connections with them.

    An input that something is connected to is one of its FMU. `inputs` are more of these, in a
    system of several parts each as PART.NAME.

    Raises BgError: BG635-BG641 for a fault in the system, and whatever a part raises.
    """
    names = [part.name for part in parts]
    for k, name in enumerate(names):
        if name in names[:k]:
            raise BgError([part_named_twice(name)])
    for wire in wires:
        for name in (wire.source, wire.sink):
            if name not in names:
                raise BgError([no_such_part(str(wire), name, names)])
    outer: dict[str, list[str]] = {name: [] for name in names}
    for text in inputs:
        name, dot, rest = text.partition(".")
        if len(parts) == 1:
            outer[names[0]].append(text)
        elif dot and name in outer:
            outer[name].append(rest)
        else:
            raise BgError([no_such_part(text, name, names)])
    ready = tuple(_ready(part, wires, outer[part.name]) for part in parts)
    return System(names[0], ready, tuple(_connections(ready, wires)))


def _ready(part: PartFile, wires: Sequence[Wire], outer: Sequence[str]) -> Part:
    """Compile a part, with the inputs that connections lead to and those asked for."""
    connected = [wire.input for wire in wires if wire.sink == part.name]
    model = prepare_model(part.file, part.options, 2, [*connected, *outer])
    return Part(part.name, model, tuple(outer))


def _connections(
    parts: Sequence[Part], wires: Sequence[Wire]
) -> list[tuple[str, Variable, str, Variable]]:
    """The pairs of scalar variables that the connections join."""
    by_name = {part.name: part for part in parts}
    found: list[tuple[str, Variable, str, Variable]] = []
    taken: dict[tuple[str, int], Wire] = {}
    for wire in wires:
        outputs, inputs = by_name[wire.source].outputs, by_name[wire.sink].inputs
        if wire.output not in outputs:
            raise BgError([no_such_signal(str(wire), wire.source, wire.output, "output", outputs)])
        if wire.input not in inputs:
            raise BgError([no_such_signal(str(wire), wire.sink, wire.input, "input", inputs)])
        sources, sinks = outputs[wire.output], inputs[wire.input]
        if len(sources) != len(sinks):
            raise BgError(
                [connection_mismatch(str(wire), f"{len(sources)} wide", f"{len(sinks)} wide")]
            )
        for source, sink in zip(sources, sinks, strict=True):
            if _dimension(source.unit) != _dimension(sink.unit):
                raise BgError(
                    [connection_mismatch(str(wire), f"in {source.unit}", f"in {sink.unit}")]
                )
            key = (wire.sink, sink.reference)
            if key in taken:
                raise BgError([connected_twice(f"{wire.sink}.{sink.name}", str(taken[key]))])
            taken[key] = wire
            found.append((wire.source, source, wire.sink, sink))
    return found


def _dimension(text: str) -> object:
    unit = parse_unit(text) if text not in ("", "1") else None
    return None if unit is None or not any(unit.dimension) else (unit.dimension, unit.factor)


def _by_name(variables: Sequence[Variable]) -> Mapping[str, tuple[Variable, ...]]:
    """Variables by the names of the scene: components, vectors, and sources without `.e` or `.f`.

    A variable whose name a parameter has too, `gain.input`, has that of the parameter as well.
    """
    found: dict[str, tuple[Variable, ...]] = {}
    for variable in variables:
        found[variable.name] = (variable,)
    for variable in variables:
        names = {variable.name, _SUFFIX.sub("", variable.name)}
        names |= {name.partition("[")[0] for name in names}
        names |= {_PORT.sub("", name) for name in names}
        for name in names - {v.name for v in variables}:
            found[name] = (*found.get(name, ()), variable)
    return found


# --- writing ----------------------------------------------------------------------------------


def system_archive(system: System, platforms: Sequence[Platform]) -> bytes:
    """Pack the archive of a system; raises BgError BG751, BG752 where a platform does not build."""
    entries = {"SystemStructure.ssd": system_structure(system).encode()}
    for part in system.parts:
        entries[f"resources/{part.name}.fmu"] = fmu_archive(part.model, platforms)
        entries[f"resources/{part.name}.ssv"] = parameter_set(part).encode()
    return archived(entries)


def system_structure(system: System) -> str:
    """Write `SystemStructure.ssd`."""
    parts = system.parts
    taken = {(sink, to.reference) for _, _, sink, to in system.connections}
    outer: list[_Connector] = []
    joined: list[list[tuple[str, str]]] = []
    for part in parts:
        for variable in part.model.table.of("input"):
            asked = any(variable in part.inputs.get(name, ()) for name in part.outer)
            if asked and (part.name, variable.reference) not in taken:
                name = variable.name if len(parts) == 1 else f"{part.name}_{variable.name}"
                outer.append(replace(_connector(variable), name=name))
                joined.append(_connection(("", name), (part.name, variable.name)))
    joined += [
        _connection((source, output.name), (sink, to.name))
        for source, output, sink, to in system.connections
    ]
    descriptions = [part.model.description for part in parts]
    ends = [d.duration for d in descriptions if d.duration is not None]
    steps = [d.interval for d in descriptions if d.interval is not None]
    return render_template(
        "ssd.xml.j2",
        name=system.name,
        tool=descriptions[0].tool,
        outer=outer,
        parts=[
            {"name": part.name, "connectors": [_connector(v) for v in _signals(part)]}
            for part in parts
        ],
        connections=joined,
        units=unit_definitions((v.unit, None) for part in parts for v in _signals(part)),
        duration=repr(max(ends)) if ends else None,
        step=repr(min(steps)) if steps else None,
    )


def parameter_set(part: Part) -> str:
    """Write the parameters of a part as they are set at the start of its FMU, an `.ssv` file.

    Parameters whose defaults follow from others are left out: they would no longer follow.
    """
    program = part.model.stages.optimised
    listed = [
        v
        for v in part.model.table.listed
        if v.kind == "parameter"
        and program.dag.level[program.parameters[v.index].value] < Level.PARAM
    ]
    return render_template(
        "ssv.xml.j2",
        name=part.name,
        tool=part.model.description.tool,
        parameters=[
            {
                "name": v.name,
                "description": v.description,
                "value": repr(v.start),
                "unit": unit_name(v.unit),
            }
            for v in listed
        ],
        units=unit_definitions((v.unit, None) for v in listed),
    )


def _signals(part: Part) -> list[Variable]:
    """Inputs, then outputs."""
    outputs = {v.reference: v for found in part.outputs.values() for v in found}
    return [*part.model.table.of("input"), *outputs.values()]


def _connector(variable: Variable) -> _Connector:
    return _Connector(variable.name, variable.causality, unit_name(variable.unit))


def _connection(source: tuple[str, str], sink: tuple[str, str]) -> list[tuple[str, str]]:
    """The attributes of a connection; the system's own connectors have no element."""
    keys = ("startElement", "startConnector", "endElement", "endConnector")
    return [(k, v) for k, v in zip(keys, (*source, *sink), strict=True) if v]
