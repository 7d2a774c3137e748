"""A reduced part as a model of the language, made of a junction, stores, a gyristor and a resistor.

Its states and ports lie on one wide junction of common flow. The inertias have the states as
momenta, with an inertia of one; the gyristor has the matrix [[-J, -G], [G', N]] and the resistor
[[R, P], [P', S]]. A port whose input is its effort lies behind a gyrator of ratio one.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from bgc.record_class import dataclass
from bgc.runtime.reduced_parts.port_hamiltonian import PortHamiltonian
from bgc.runtime.results.arrays import Array

_WIDTH = 96


@dataclass(frozen=True, slots=True)
class TextPort:
    """A port of the model: its declaration without the semicolon, and its scalar ports."""

    name: str
    declaration: str
    is_out: bool
    by_effort: tuple[bool, ...]
    flow_units: tuple[str, ...]

    @property
    def width(self) -> int:
        """The number of its scalar ports."""
        return len(self.by_effort)


@dataclass(frozen=True, slots=True)
class TextOutput:
    """An output of the model: its declaration up to `=`, and its shape."""

    declaration: str
    shape: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class PartText:
    """What a model of a reduced part says.

    `base` is the interface that it meets, empty for none; `values` are statements of its
    parameters. Rows of the system's outputs belong to the components of `outputs` in their order.
    """

    name: str
    doc: str
    base: str
    ports: tuple[TextPort, ...]
    values: tuple[str, ...]
    outputs: tuple[TextOutput, ...]
    system: PortHamiltonian

    def text(self) -> str:
        """The model."""
        lines = [f"/// {line}" for line in textwrap.wrap(self.doc, _WIDTH)]
        lines.append(f"model {self.name}{f' is {self.base}' if self.base else ''} {{")
        lines += [f"  {line}".rstrip() for line in self._items()]
        return "\n".join([*lines, "}"]) + "\n"

    def _items(self) -> Iterator[str]:
        for port in self.ports:
            yield f"{port.declaration};"
        yield from self.values
        n, m = self.system.states, self.system.ports
        yield from ["", f"flows : J1[{n + m}];"]
        yield from self._stores(n)
        sense = np.concatenate([np.ones(n), self._senses()])
        exchanged = np.outer(sense, sense) * -self.system.interconnection
        lost = np.outer(sense, sense) * self.system.dissipation
        if exchanged.any():
            yield from _matrix("exchanged", exchanged)
            yield f"links : MGY[{n + m}] {{ e = exchanged*f; }}"
            yield "flows -> links;"
        among = n if not lost[n:].any() else n + m
        if lost.any():
            yield from _matrix("lost", lost[:among, :among])
            yield f"losses : R[{among}](resistance = lost);"
            yield f"flows[1..{among}] -> losses;"
        if self.system.constant.any():
            signs = np.concatenate([np.ones(n), -self._senses()])
            yield f"constant : Se(e = {_vector(signs * self.system.constant)});"
            yield "constant -> flows;"
        yield from self._port_bonds(n)
        yield from self._outputs(sense)

    def _stores(self, n: int) -> Iterator[str]:
        start = f", p0 = {_vector(self.system.start)}" if self.system.start.any() else ""
        if n:
            yield f"stores : I[{n}](1{start});"
            yield f"flows[1..{n}] -> stores;"

    def _senses(self) -> Array:
        """The sign of each input on the junction: flows out of the part count along the arrow."""
        found = [
            -1.0 if port.is_out and not by_effort else 1.0
            for port in self.ports
            for by_effort in port.by_effort
        ]
        return np.array(found)

    def _port_bonds(self, place: int) -> Iterator[str]:
        """Bonds of the ports, in runs of equal inputs; `place` components come before them."""
        for port in self.ports:
            runs = [(key, len(list(run))) for key, run in groupby(port.by_effort)]
            first = 1
            for by_effort, width in runs:
                own = port.name if len(runs) == 1 else f"{port.name}{_slice(first, width)}"
                chain = [own, f"flows{_slice(place + 1, width)}"]
                if by_effort:
                    turn = f"turn_{port.name}" + (f"_{first}" if len(runs) > 1 else "")
                    yield f"{turn} : GY(ratio = 1);"
                    chain.insert(1, turn)
                yield f"{' -> '.join(reversed(chain) if port.is_out else chain)};"
                first, place = first + width, place + width

    def _outputs(self, sense: Array) -> Iterator[str]:
        rows = iter(self.system.outputs)
        units = [unit for port in self.ports for unit in port.flow_units]
        by_effort = [turned for port in self.ports for turned in port.by_effort]
        for output in self.outputs:
            count = int(np.prod(output.shape, dtype=int))
            found = [self._row(next(rows), sense, units, by_effort) for _ in range(count)]
            yield f"{output.declaration} = {_nested(found, output.shape)};"

    def _row(
        self, row: Array, sense: Array, units: Sequence[str], by_effort: Sequence[bool]
    ) -> str:
        """One number of the states, the inputs and 1, without units."""
        n = self.system.states
        terms = [f"dot({_vector(row[:n])}, stores.p)"] if row[:n].any() else []
        for k, value in enumerate(row[n:-1] * sense[n:]):
            if value:
                unit = f"/(1 {units[k]})" if units[k] and not by_effort[k] else ""
                terms.append(f"{_number(value)}*flows.f[{n + k + 1}]{unit}")
        if row[-1] or not terms:
            terms.append(_number(row[-1]))
        return " + ".join(terms)


def _matrix(name: str, matrix: Array) -> Iterator[str]:
    yield f"const {name} = ["
    for k, row in enumerate(matrix):
        yield f"  {_vector(row)}{',' if k + 1 < len(matrix) else ''}"
    yield "];"


def _vector(values: Array) -> str:
    return f"[{', '.join(map(_number, values))}]"


def _number(value: float) -> str:
    """The number in full, as the language writes it."""
    text = repr(float(value) + 0.0)
    return text.removesuffix(".0").replace("e+", "e")


def _slice(first: int, width: int) -> str:
    return f"[{first}]" if width == 1 else f"[{first}..{first + width - 1}]"


def _nested(texts: Sequence[str], shape: tuple[int, ...]) -> str:
    if not shape:
        return texts[0]
    step = len(texts) // shape[0]
    rows = [texts[k : k + step] for k in range(0, len(texts), step)]
    return f"[{', '.join(_nested(row, shape[1:]) for row in rows)}]"
