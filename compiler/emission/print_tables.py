"""Print tables of data as C: a unit of their own, with long arrays as binary files.

A C compiler takes 7 s for a million pairs of numbers as text, 1.2 s for their bytes as a string,
and 0.1 s where the assembler includes a file. A shared object therefore includes the file; a C
file that has to stand alone has the string.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from bgc.algebra.dag import Dag
from bgc.algebra.table import AnyTable, Grid, Method, Outside, Table
from bgc.record_class import dataclass, field

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LITERAL = 256  # numbers of an array that is printed as text
_BLOCK = 64  # BGC_BLOCK of bgc_table_ranges.h
_PER_LINE = 8
_STRING = 4096  # bytes of a string in one line
_INCLUDED = """\
#if defined(__APPLE__)
#define INCLUDED(name, file) \\
    __asm__(".const\\n.balign 8\\n_" name ": .incbin \\"" file "\\"\\n.text\\n")
#else
#define INCLUDED(name, file) \\
    __asm__(".section .rodata\\n.balign 8\\n" name ": .incbin \\"" file "\\"\\n.text\\n")
#endif
"""


@dataclass(slots=True)
class PrintedTables:
    """The C text of the tables, and the files that it includes by the assembler."""

    text: str = ""
    files: list[tuple[str, bytes]] = field(default_factory=list)


def table_name(dag: Dag, number: int) -> str:
    """The C name of a table."""
    return f"bgc_model_table_{list(dag.tables).index(number)}"


def table_prototypes(dag: Dag, header: str = "bgc_tables.h") -> list[str]:
    """The declarations that a unit needs which looks tables up."""
    if not dag.tables:
        return []
    lines = [
        f"extern const bgc_{'grid' if isinstance(table, Grid) else 'table'} {table_name(dag, k)};\n"
        for k, table in dag.tables.items()
    ]
    return ["".join((f'#include "{header}"\n', *lines))]


def print_tables(dag: Dag, alone: bool) -> PrintedTables:
    """Print the tables of a graph; `alone` without files."""
    printer = _Printer(alone)
    bodies = [printer.table(table_name(dag, number), table) for number, table in dag.tables.items()]
    arrays = "".join(printer.arrays)
    included = _INCLUDED if printer.files and not alone else ""
    head = "" if alone else '#include "bgc.h"\n#include "bgc_tables.h"\n\n'
    return PrintedTables(f"{head}{included}{arrays}{''.join(bodies)}", printer.files)


class _Printer:
    def __init__(self, alone: bool) -> None:
        self.alone = alone
        self.arrays: list[str] = []
        self.files: list[tuple[str, bytes]] = []
        self._names: dict[tuple[str, bytes], str] = {}

    def table(self, name: str, table: AnyTable) -> str:
        """The definition of a table; equal arrays of several are shared."""
        if isinstance(table, Grid):
            fields = [self.doubles(each) for each in table.fields] or ["NULL"] * 3
            lines = [
                f".x = {self.knots(table.x)}",
                f".y = {self.knots(table.y)}",
                f".z = {self.doubles(table.z)}",
                f".by = {{{', '.join(fields)}}}",
            ]
            return _definition("bgc_grid", name, lines)
        low, high = _blocks(table)
        lines = [
            f".method = BGC_{table.method.name}",
            f".outside = BGC_{table.outside.name}",
            f".n_break = {table.break_count}",
            f".knots = {self.knots(table.x)}",
            f".y = {self.doubles(table.y)}",
            f".d = {self.doubles(table.d)}",
            f".low = {self.doubles(low)}",
            f".high = {self.doubles(high)}",
            f".breaks = {self.breaks(table)}",
        ]
        return _definition("bgc_table", name, lines)

    def breaks(self, table: Table) -> str:
        """The breaks; one that is not there where the table has none, for NULL means all."""
        if table.breaks is None:
            return "NULL"
        return self.integers(table.breaks or array("i", [0]))

    def knots(self, x: array[float]) -> str:
        rate = (len(x) - 1) / (x[-1] - x[0])
        guess = self.integers(_guesses(x, rate))
        return f"{{{len(x)}, {rate!r}, {self.doubles(x)}, {guess}}}"

    def doubles(self, values: array[float]) -> str:
        return self._array("double", "number", values, [repr(x) for x in values[:_LITERAL]])

    def integers(self, values: array[int]) -> str:
        return self._array("int", "whole", values, [str(x) for x in values[:_LITERAL]])

    def _array(self, kind: str, label: str, values: array[Any], texts: Sequence[str]) -> str:
        """The name of an array of these values, NULL without any."""
        if not values:
            return "NULL"
        content = values.tobytes()
        known = self._names.get((kind, content))
        if known is not None:
            return known
        name = f"data_{len(self._names)}"
        if len(values) <= _LITERAL:
            rows = [texts[k : k + _PER_LINE] for k in range(0, len(texts), _PER_LINE)]
            body = "".join(f"    {', '.join(row)},\n" for row in rows)
            self.arrays.append(f"static const {kind} {name}[] = {{\n{body}}};\n\n")
        elif self.alone:
            self.arrays.append(_as_string(kind, label, name, len(values), content))
            name = f"{name}.{label}"
        else:
            file = f"{name}.bin"
            self.files.append((file, content))
            self.arrays.append(
                f'INCLUDED("{name}", "{file}");\n'
                f'extern const {kind} {name}[] __attribute__((visibility("hidden")));\n\n'
            )
        self._names[kind, content] = name
        return name


def _definition(kind: str, name: str, lines: Sequence[str]) -> str:
    body = "".join(f"    {line},\n" for line in lines)
    return f"extern const {kind} {name};\nconst {kind} {name} = {{\n{body}}};\n\n"


def _as_string(kind: str, label: str, name: str, count: int, content: bytes) -> str:
    """An array as the bytes of a string, in the byte order of this machine."""
    import numpy as np  # takes longer to load than most models to compile

    escapes = np.array([list(b"\\%03o" % k) for k in range(256)], np.uint8)
    text = escapes[np.frombuffer(content, np.uint8)].tobytes().decode("ascii")
    width = 4 * _STRING
    rows = "".join(f'    "{text[k : k + width]}"\n' for k in range(0, len(text), width))
    return (
        f"static const union {{\n    char text[{len(content)}];\n    {kind} {label}[{count}];\n"
        f"}} {name} = {{\n{rows}}};\n\n"
    )


def _guesses(x: array[float], rate: float) -> array[int]:
    """The interval at the start of each of n - 1 equal parts; none for knots that are even."""
    import numpy as np

    knots = np.frombuffer(x, float)
    count = len(knots)
    parts = knots[0] + np.arange(count) / rate
    if np.all(np.abs(knots - parts) * rate < 0.25):
        return array("i")
    found = np.clip(np.searchsorted(knots, parts, side="right") - 1, 0, count - 2)
    return array("i", found.astype(np.intc).tobytes())


def _blocks(table: Table) -> tuple[array[float], array[float]]:
    """Bounds of the values, and behind them of the slopes, over blocks of pieces; none of few."""
    import numpy as np

    if len(table.x) <= 2 * _LITERAL:
        return array("d"), array("d")
    points = [_bernstein(table, order) for order in (0, 1)]
    outside = table.method in (Method.LINEAR, Method.CUBIC) and table.outside is not Outside.REPEAT
    bounds: list[array[float]] = []
    for extreme, neutral in ((np.minimum, np.inf), (np.maximum, -np.inf)):
        parts = []
        for each in points:
            of_piece = extreme.reduce(each, axis=0)
            if outside:
                of_piece = np.concatenate(([neutral], of_piece, [neutral]))
            missing = -len(of_piece) % _BLOCK
            padded = np.concatenate((of_piece, np.full(missing, neutral)))
            parts.append(extreme.reduce(padded.reshape(-1, _BLOCK), axis=1))
        whole = np.concatenate(parts)
        bounds.append(array("d", np.where(np.isfinite(whole), whole, 0.0).tobytes()))
    return bounds[0], bounds[1]


def _bernstein(table: Table, order: int) -> list[NDArray[Any]]:
    """The Bernstein coefficients of all pieces inside, or of their slopes."""
    import numpy as np

    x, y = np.frombuffer(table.x, float), np.frombuffer(table.y, float)
    match table.method:
        case Method.NEAREST | Method.STEP:
            values = y if table.method is Method.NEAREST else y[:-1]
            return [values if order == 0 else np.zeros(len(values))]
        case Method.LINEAR:
            return [y[:-1], y[1:]] if order == 0 else [np.diff(y) / np.diff(x)]
    d, h = np.frombuffer(table.d, float), np.diff(x)
    inner = y[:-1] + h * d[:-1] / 3, y[1:] - h * d[1:] / 3
    if order == 0:
        return [y[:-1], *inner, y[1:]]
    return [d[:-1], 3 * (inner[1] - inner[0]) / h, d[1:]]
