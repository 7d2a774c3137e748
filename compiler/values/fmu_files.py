"""Read the model description of an FMU of FMI 2.0 or 3.0: its variables with their units."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from hashlib import blake2b
from math import prod
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from zipfile import BadZipFile, ZipFile

from bgc.record_class import dataclass
from bgc.values.units import BASE_UNITS, DIMENSIONLESS, Dimension, parse_unit

MAX_BYTES = 256_000_000  # of an FMU
DESCRIPTION = "modelDescription.xml"
_MAX_DESCRIPTION = 64_000_000
_MAX_NUMBERS = 10_000  # of an array
_DECLARATION = re.compile(r"\A\s*<\?xml\s[^>]*\?>")

KINDS2 = ("Real", "Integer", "Boolean", "Enumeration")
KINDS3 = (
    "Float64",
    "Float32",
    "Int8",
    "UInt8",
    "Int16",
    "UInt16",
    "Int32",
    "UInt32",
    "Int64",
    "UInt64",
    "Boolean",
    "Enumeration",
)
"""The types of variables that are numbers; C knows them by their places (`runtime/c/fmus.h`)."""


class FmuFault(Exception):
    """The reason why an FMU cannot be read, as the end of a sentence."""


@dataclass(frozen=True, slots=True)
class FmuUnit:
    """A unit of an FMU: `factor * value + offset` is the value in SI units.

    `dimension` is None where the FMU does not say what the unit is.
    """

    text: str = ""
    dimension: Dimension | None = None
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class FmuVariable:
    """A number of an FMU, or a component of an array of FMI 3.

    `kind` is a name of `KINDS2` or `KINDS3`, empty for what is no number. `place` is that of the
    component in its array of `count` numbers, from 0. `start` is in the unit of the FMU.
    """

    name: str
    reference: int
    kind: str
    causality: str
    variability: str
    unit: FmuUnit
    description: str = ""
    start: float | None = None
    low: float | None = None
    high: float | None = None
    place: int = 0
    count: int = 1

    @property
    def is_set(self) -> bool:
        """Whether an importer gives it a value: an input or a parameter."""
        return self.causality in ("input", "parameter") and bool(self.kind)


@dataclass(frozen=True, slots=True)
class FmuFile:
    """An FMU: its file, a hash of its content, and the model description.

    `identifier` is the name of its binaries, for Co-Simulation; `platforms` are the folders that
    have one. `once` tells that a process may hold a single instance, `step` is the step that the
    FMU proposes, None without one.
    """

    path: Path
    shown: str
    digest: str
    version: int
    name: str
    description: str
    identifier: str
    token: str
    platforms: tuple[str, ...]
    once: bool
    step: float | None
    variables: Mapping[str, FmuVariable]


def read_fmu(path: Path, shown: str) -> FmuFile:
    """Read an FMU; `shown` is its name in messages.

    Raises
    ------
    FmuFault
        It cannot be read, or is none of Co-Simulation of FMI 2.0 or 3.0.
    """
    content = _content(path)
    digest = blake2b(content).hexdigest()
    try:
        with ZipFile(io.BytesIO(content)) as archive:
            names = archive.namelist()
            if DESCRIPTION not in names:
                raise FmuFault(f"it has no `{DESCRIPTION}`")
            if archive.getinfo(DESCRIPTION).file_size > _MAX_DESCRIPTION:
                raise FmuFault(f"its `{DESCRIPTION}` has more than {_MAX_DESCRIPTION:,} bytes")
            text = archive.read(DESCRIPTION)
    except (BadZipFile, NotImplementedError, RuntimeError, OSError, EOFError) as reason:
        raise FmuFault("it is no zip archive that can be read") from reason
    root = _parsed(text)
    version = root.get("fmiVersion", "")
    if root.tag != "fmiModelDescription" or version.partition(".")[0] not in ("2", "3"):
        raise FmuFault(f"it is of FMI {version or 'of no version'}; versions 2.0 and 3.0 are read")
    kind = root.find("CoSimulation")
    if kind is None or not (identifier := kind.get("modelIdentifier", "")):
        raise FmuFault("it has no Co-Simulation: it leaves its states to another solver")
    if not re.fullmatch(r"[\w.-]+", identifier):
        raise FmuFault("the name of its binaries has other characters than letters and digits")
    second = version.startswith("2")
    folders = (name.split("/") for name in names if name.startswith("binaries/"))
    experiment = root.find("DefaultExperiment")
    return FmuFile(
        path,
        shown,
        digest,
        2 if second else 3,
        root.get("modelName", identifier),
        root.get("description", ""),
        identifier,
        root.get("guid" if second else "instantiationToken", ""),
        tuple(sorted({parts[1] for parts in folders if len(parts) > 2 and parts[2]})),
        kind.get("canBeInstantiatedOnlyOncePerProcess") in ("true", "1"),
        None if experiment is None else _number(experiment.get("stepSize", "")),
        {v.name: v for v in (_variables2 if second else _variables3)(root)},
    )


def _content(path: Path) -> bytes:
    try:
        if not path.exists():
            raise FmuFault("there is no such file")
        if not path.is_file():
            raise FmuFault("it is not a file")
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as reason:
        raise FmuFault(getattr(reason, "strerror", None) or str(reason)) from reason
    if len(content) > MAX_BYTES:
        raise FmuFault(f"it has more than {MAX_BYTES:,} bytes")
    return content


def _parsed(content: bytes) -> Element:
    """The root of an XML text without a document type: entities could expand without end."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    if "<!DOCTYPE" in text:
        raise FmuFault(f"its `{DESCRIPTION}` has a document type")
    try:
        return ElementTree.fromstring(_DECLARATION.sub("", text))
    except (ElementTree.ParseError, RecursionError) as reason:
        raise FmuFault(f"its `{DESCRIPTION}` is not well-formed XML: {reason}") from reason


def _number(text: str) -> float | None:
    """The finite number of an attribute, 0 or 1 for a truth value; None for another text."""
    try:
        value = float(text)
    except ValueError:
        return {"true": 1.0, "false": 0.0}.get(text)
    return value if math.isfinite(value) else None


# --- units ------------------------------------------------------------------------------------


def _units(root: Element) -> dict[str, FmuUnit]:
    """The units by name. Angles are numbers in this language, so that `rad` is left out."""
    return {each.get("name", ""): _unit(each) for each in root.iterfind("UnitDefinitions/Unit")}


def _unit(element: Element) -> FmuUnit:
    name, base = element.get("name", ""), element.find("BaseUnit")
    if base is None:
        return _named(name)
    try:
        dimension = tuple(int(base.get(key, "0")) for key in BASE_UNITS)
        factor, offset = float(base.get("factor", "1")), float(base.get("offset", "0"))
    except ValueError:
        return _named(name)
    sound = 0.0 < factor < math.inf and math.isfinite(offset)
    return FmuUnit(name, dimension, factor, offset) if sound else _named(name)


def _named(text: str) -> FmuUnit:
    """A unit that the FMU does not define, by its name: `N.m` is `N*m`."""
    if text in ("", "1"):
        return FmuUnit(text, DIMENSIONLESS if text else None)
    known = parse_unit(text.replace(".", "*"))
    if known is None:
        return FmuUnit(text)
    return FmuUnit(text, known.dimension, float(known.factor))


# --- variables --------------------------------------------------------------------------------


def _variables2(root: Element) -> Iterator[FmuVariable]:
    units = _units(root)
    types = {each.get("name", ""): each for each in root.iterfind("TypeDefinitions/SimpleType")}
    for element in root.iterfind("ModelVariables/ScalarVariable"):
        own = next((child for child in element if child.tag in (*KINDS2, "String")), None)
        if own is None or (reference := _reference(element)) is None:
            continue
        declared = types.get(own.get("declaredType", ""))
        inherited = None if declared is None else declared.find(own.tag)
        kind = own.tag if own.tag in KINDS2 else ""
        facts = [each for each in (own, inherited) if each is not None]
        starts = [_number(own.get("start", ""))]
        yield from _made(element, element.get("name", ""), reference, kind, facts, units, starts)


def _variables3(root: Element) -> Iterator[FmuVariable]:
    units = _units(root)
    types = {each.get("name", ""): each for each in root.iterfind("TypeDefinitions/*")}
    for element in root.iterfind("ModelVariables/*"):
        if (reference := _reference(element)) is None:
            continue
        inherited = types.get(element.get("declaredType", ""))
        facts = [each for each in (element, inherited) if each is not None]
        sizes = [_number(each.get("start", "")) for each in element.iterfind("Dimension")]
        known = all(size is not None and 0 < size <= _MAX_NUMBERS for size in sizes)
        shape = [int(size or 0) for size in sizes]
        kind = element.tag if known and prod(shape) <= _MAX_NUMBERS else ""
        starts = [_number(text) for text in element.get("start", "").split()] if kind else []
        yield from _made(
            element,
            element.get("name", ""),
            reference,
            kind if kind in KINDS3 else "",
            facts,
            units,
            starts,
            shape if kind in KINDS3 else (),
        )


def _made(
    element: Element,
    name: str,
    reference: int,
    kind: str,
    facts: Iterable[Element],
    units: Mapping[str, FmuUnit],
    starts: Iterable[float | None],
    shape: Iterable[int] = (),
) -> Iterator[FmuVariable]:
    """A variable, or the components of an array as `name[i]` and `name[i,j]`."""

    def first(attribute: str) -> str:
        return next((found for f in facts if (found := f.get(attribute)) is not None), "")

    unit = first("unit")
    sizes, given = tuple(shape), list(starts)
    count = prod(sizes)
    for place in range(count):
        start = given[place if len(given) == count else 0] if given else None
        yield FmuVariable(
            name + _index(place, sizes),
            reference,
            kind,
            element.get("causality", "local"),
            element.get("variability", "continuous"),
            units.get(unit) or _named(unit),
            element.get("description", ""),
            start,
            _number(first("min")),
            _number(first("max")),
            place,
            count,
        )


def _index(place: int, sizes: tuple[int, ...]) -> str:
    """The index of a component in brackets, row by row from 1; empty for a scalar."""
    found: list[str] = []
    for size in reversed(sizes):
        place, k = divmod(place, size)
        found.insert(0, str(k + 1))
    return f"[{','.join(found)}]" if found else ""


def _reference(element: Element) -> int | None:
    text = element.get("valueReference", "")
    return int(text) if text.isdigit() and int(text) < 2**32 else None
