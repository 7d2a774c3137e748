"""The model description of an FMU as XML."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from typing import Any

from bgc.record_class import dataclass, replace
from bgc.runtime.documents.templates import render_template
from bgc.runtime.fmi.fmu_units import unit_definitions, unit_name
from bgc.runtime.fmi.fmu_variables import Array, Table, Variable, arrays_of
from bgc.runtime.fmi.structure import Structure, Unknown

Attributes = list[tuple[str, str]]

_NAME = r"[A-Za-z_][A-Za-z_0-9]*(?:\[\d+(?:,\d+)*\])?"
_STRUCTURED = re.compile(rf"(?:der\()?{_NAME}(?:\.{_NAME})*\)?")


@dataclass(frozen=True, slots=True)
class Description:
    """Contents of a model description besides its variables.

    `duration`, `tolerance` and `interval` are the default experiment; None where the scene has
    none. `indicators` counts the event indicators.
    """

    name: str
    identifier: str
    token: str
    text: str
    tool: str
    duration: float | None
    tolerance: float | None
    interval: float | None
    indicators: int
    derivatives: bool

    def common(self, table: Table) -> dict[str, Any]:
        """The values of the template that both versions share."""
        experiment = (
            ("stopTime", self.duration),
            ("tolerance", self.tolerance),
            ("stepSize", self.interval),
        )
        listed = table.listed
        structured = all(_STRUCTURED.fullmatch(v.name) for v in listed)
        return {
            "name": self.name,
            "identifier": self.identifier,
            "token": self.token,
            "description": self.text,
            "tool": self.tool,
            "naming": "structured" if structured else "flat",
            "derivatives": str(self.derivatives).lower(),
            "indicators": self.indicators,
            "units": unit_definitions((v.unit, v.shown) for v in listed),
            "experiment": [(key, repr(value)) for key, value in experiment if value is not None],
        }


def number_attributes(variable: Variable) -> Attributes:
    """The attributes of a real variable: unit, range, nominal value, and whether events set it."""
    unit = unit_name(variable.unit)
    shown = variable.shown.unit if unit and variable.shown is not None else unit
    found = {
        "unit": unit,
        "displayUnit": shown if shown != unit else "",
        "min": _number(variable.low),
        "max": _number(variable.high),
        "nominal": _number(variable.nominal),
        "reinit": "true" if variable.reinit else "",
    }
    return [(key, text) for key, text in found.items() if text]


def _number(value: float | None) -> str:
    return "" if value is None or math.isinf(value) else repr(value)


def word_attributes(variable: Variable) -> Attributes:
    """The attributes of a variable that are words of the standard, and its description."""
    found = ("causality", "variability", "initial", "description")
    return [(key, text) for key in found if (text := getattr(variable, key))]


def fmi2_description(description: Description, table: Table, structure: Structure) -> str:
    """Write `modelDescription.xml` of FMI 2.0."""
    index = {v.reference: k for k, v in enumerate(table.listed, 1)}
    return render_template(
        "fmi2.xml.j2",
        **description.common(table),
        source=f"{description.identifier}.c",
        variables=[_scalar(v, index) for v in table.listed],
        structure=[
            ("Outputs", _indexed(structure.outputs, index)),
            ("Derivatives", _indexed(structure.derivatives, index)),
            ("InitialUnknowns", _indexed(structure.initial, index)),
        ],
    )


def _scalar(variable: Variable, index: dict[int, int]) -> dict[str, Any]:
    real = number_attributes(variable)
    if variable.start is not None:
        real.append(("start", repr(variable.start)))
    if variable.derivative_of is not None:
        real.append(("derivative", str(index[variable.derivative_of])))
    return {
        "name": variable.name,
        "reference": variable.reference,
        "attributes": word_attributes(variable),
        "real": real,
    }


def _indexed(unknowns: Sequence[Unknown], index: dict[int, int]) -> list[tuple[int, str | None]]:
    return [
        (index[u.reference], None if u.dependencies is None else _joined(u.dependencies, index))
        for u in unknowns
    ]


def _joined(references: Iterable[int], index: dict[int, int]) -> str:
    return " ".join(str(k) for k in sorted(index[r] for r in references if r in index))


# --- FMI 3 ------------------------------------------------------------------------------------


def fmi3_description(description: Description, table: Table, structure: Structure) -> str:
    """Write `modelDescription.xml` of FMI 3.0."""
    arrays = arrays_of(table)
    head = {c.reference: a.variable.reference for a in arrays for c in a.components}
    indicators = [
        Unknown(v.reference, dependencies)
        for v, dependencies in zip(table.of("indicator"), structure.indicators, strict=True)
    ]
    return render_template(
        "fmi3.xml.j2",
        **description.common(table),
        variables=[_array(array) for array in arrays],
        structure=[
            ("Output", _by_array(structure.outputs, head)),
            ("ContinuousStateDerivative", _by_array(structure.derivatives, head)),
            ("InitialUnknown", _by_array(structure.initial, head)),
            ("EventIndicator", _by_array(indicators, head)),
        ],
    )


def _array(array: Array) -> dict[str, Any]:
    first = array.variable
    attributes = word_attributes(first)
    nominals = [c.nominal for c in array.components if c.nominal is not None]
    widest = replace(first, nominal=max(nominals)) if nominals else first
    attributes += number_attributes(widest)
    starts = [repr(c.start) for c in array.components if c.start is not None]
    if starts:
        attributes.append(("start", " ".join(starts)))
    if first.derivative_of is not None:
        attributes.append(("derivative", str(first.derivative_of)))
    return {
        "name": first.name,
        "reference": first.reference,
        "attributes": attributes,
        "shape": array.shape,
    }


def _by_array(unknowns: Iterable[Unknown], head: dict[int, int]) -> list[tuple[int, str | None]]:
    """Merge the dependencies of the components of each array."""
    merged: dict[int, set[int] | None] = {}
    for unknown in unknowns:
        first = head[unknown.reference]
        before = merged.setdefault(first, set())
        if unknown.dependencies is None or before is None:
            merged[first] = None
        else:
            before |= {head[r] for r in unknown.dependencies}
    return [
        (first, None if found is None else " ".join(map(str, sorted(found))))
        for first, found in merged.items()
    ]


def build_description(description: Description) -> str:
    """Write `sources/buildDescription.xml` of FMI 3.0."""
    return render_template("fmi3_build.xml.j2", identifier=description.identifier)


def terminals_and_icons(table: Table, devices: Iterable[str]) -> str:
    """Write `terminalsAndIcons.xml` of FMI 3.0: a terminal for the channels of each device."""
    arrays = [a for a in arrays_of(table) if a.variable.kind in ("input", "command")]
    terminals = []
    for device in devices:
        start = f"{device}."
        members = [a.variable.name for a in arrays if a.variable.name.startswith(start)]
        terminals.append((device, [(name, name.removeprefix(start)) for name in members]))
    return render_template("fmi3_terminals.xml.j2", terminals=terminals)
