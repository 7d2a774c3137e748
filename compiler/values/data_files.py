"""Read data files: columns of numbers from CSV, values by key from JSON."""

from __future__ import annotations

import io
import json
import math
import re
import stat
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from bgc.diagnostics.catalogue import data as catalogue
from bgc.diagnostics.source import Span
from bgc.record_class import dataclass
from bgc.values.arithmetic import failure
from bgc.values.units import Dimension, parse_unit, suggest_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_BYTES = 256_000_000  # of a file: 1e7 rows of two columns
_HEADER = re.compile(r"(.*?)\s*\[([^\[\]]*)\]", re.DOTALL)
_SUFFIXES = {".csv", ".json"}
_SEPARATORS = "\t;,"


@dataclass(frozen=True, eq=False)
class Numbers:
    """A column, vector or matrix of finite numbers in SI units, with its name for messages.

    `unit` is None where the file gives none: such numbers fit any unit.
    """

    name: str
    array: NDArray[Any]
    unit: Dimension | None


Entries: TypeAlias = "dict[str, Numbers | Entries]"


@dataclass(frozen=True, eq=False)
class DataFile:
    """The contents of a file by name, and what identifies it."""

    path: Path
    shown: str
    digest: str
    entries: Entries


def read_data(path: Path, shown: str, span: Span) -> DataFile:
    """Read a `.csv` or `.json` file; `shown` is its name in messages, `span` where it is asked for.

    Raises
    ------
    BgError
        BG250 where it cannot be read, BG251 where its contents are not a table of numbers, BG252
        where a unit is unknown.
    """
    if len(suffixes := {path.suffix, _target(path).suffix}) > 1 or not suffixes <= _SUFFIXES:
        raise failure(
            catalogue.data_unreadable(span, shown, "its name ends in neither `.csv` nor `.json`")
        )
    content = _content(path, shown, span)
    digest = blake2b(content).hexdigest()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as reason:
        why = f"it is not UTF-8: byte {reason.start + 1} is 0x{content[reason.start]:02X}"
        raise failure(catalogue.data_unreadable(span, shown, why)) from None
    read = _csv if path.suffix == ".csv" else _json
    return DataFile(path, shown, digest, read(text, shown, span))


def _target(path: Path) -> Path:
    """The file that a link leads to."""
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):
        return path


def _content(path: Path, shown: str, span: Span) -> bytes:
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise failure(catalogue.data_unreadable(span, shown, "it is not a file"))
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise failure(catalogue.data_unreadable(span, shown, "there is no such file")) from None
    except (OSError, ValueError) as reason:
        why = getattr(reason, "strerror", None) or str(reason)
        raise failure(catalogue.data_unreadable(span, shown, why)) from None
    if len(content) > MAX_BYTES:
        why = f"it has more than {MAX_BYTES:,} bytes"
        raise failure(catalogue.data_unreadable(span, shown, why))
    return content


# --- CSV ----------------------------------------------------------------------------------------


def _csv(text: str, shown: str, span: Span) -> Entries:
    """Columns of a table with a header; separated by tabs, `;` or `,`, by what it has."""
    import numpy as np  # takes longer to load than most models to compile

    header, _, body = text.partition("\n")
    separator = next((s for s in _SEPARATORS if s in header), ",")
    titles = [title.strip().strip('"').strip() for title in header.strip("\r").split(separator)]
    columns = [_titled(title, shown, span) for title in titles]
    names = [name for name, _, _ in columns]
    for k, name in enumerate(names):
        if not name or name in names[:k]:
            problem = f"column {k + 1} has " + (
                "no name" if not name else f"the name `{name}` again"
            )
            raise failure(catalogue.data_malformed(span, shown, f"{problem} in line 1"))
    if not body.strip():
        raise failure(catalogue.data_malformed(span, shown, "it has no rows of numbers"))
    try:
        rows = np.loadtxt(io.StringIO(body), delimiter=separator, comments=None, ndmin=2)
        sound = rows.shape[1] == len(names) and bool(np.isfinite(rows).all())
    except ValueError:
        sound = False
    if not sound:
        raise failure(catalogue.data_malformed(span, shown, _fault(body, separator, names)))
    return {
        name: Numbers(name, np.ascontiguousarray(rows[:, k]) * factor, unit)
        for k, (name, unit, factor) in enumerate(columns)
    }


def _titled(title: str, shown: str, span: Span) -> tuple[str, Dimension | None, float]:
    """Name, unit and factor to SI of a title such as `z [mm]`."""
    if not title.isprintable():
        raise failure(catalogue.data_malformed(span, shown, "a title has control characters"))
    match = _HEADER.fullmatch(title)
    if match is None:
        return title, None, 1.0
    name, text = match[1].strip(), match[2].strip()
    unit = parse_unit(text)
    if unit is None:
        raise failure(catalogue.data_unit(span, shown, title, text, suggest_unit(text)))
    return name, unit.dimension, float(unit.factor)


def _fault(body: str, separator: str, names: list[str]) -> str:
    """The first line that is wrong, and why."""
    for number, line in enumerate(body.split("\n"), 2):
        if not line.strip():
            continue
        cells = line.strip("\r").split(separator)
        if len(cells) != len(names):
            have = "1 value" if len(cells) == 1 else f"{len(cells)} values"
            return f"line {number} has {have}, the header {len(names)}"
        for name, cell in zip(names, cells, strict=True):
            if not cell.strip():
                return f"line {number} has nothing in column `{name}`"
            if not _is_finite(cell):
                return f"line {number} has no finite number in column `{name}`"
    return "it is not a table of numbers"


def _is_finite(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False


# --- JSON ---------------------------------------------------------------------------------------


def _json(text: str, shown: str, span: Span) -> Entries:
    def malformed(problem: str) -> Exception:
        return failure(catalogue.data_malformed(span, shown, problem))

    try:
        found = json.loads(text)
    except json.JSONDecodeError as reason:
        raise malformed(f"line {reason.lineno}, column {reason.colno}: {reason.msg}") from None
    except (RecursionError, ValueError):
        raise malformed("its values are nested too deeply or are too long") from None
    if not isinstance(found, dict):
        raise malformed('it is not an object, as `{"mass": 3}` is')
    return _entries(found, "", shown, span)


def _entries(found: dict[str, Any], within: str, shown: str, span: Span) -> Entries:
    made: Entries = {}
    for title, value in found.items():
        name, unit, factor = _titled(title, shown, span)
        path = f"{within}.{name}" if within else name
        if name in made:
            raise failure(catalogue.data_malformed(span, shown, f"`{path}` is there twice"))
        if isinstance(value, dict):
            made[name] = _entries(value, path, shown, span)
        elif not isinstance(value, str) and value is not None:
            made[name] = _numbers(value, path, shown, span, unit, factor)
    return made


def _numbers(
    value: Any, name: str, shown: str, span: Span, unit: Dimension | None, factor: float
) -> Numbers:
    """A number, a list of numbers or a list of equal lists; texts are comments and not read."""
    import numpy as np

    try:
        array = np.array(value, float)
    except (ValueError, TypeError, OverflowError):
        array = np.full(1, math.nan)
    if array.ndim > 2 or not array.size or not np.isfinite(array).all():
        problem = f"`{name}` is neither a number nor a vector or matrix of numbers"
        raise failure(catalogue.data_malformed(span, shown, problem))
    return Numbers(name, array * factor, unit)
