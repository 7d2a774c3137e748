"""Values of expressions: scalars, vectors and matrices of DAG nodes, with their units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import prod
from typing import TypeAlias

from bgc.diagnostics.catalogue import with_article
from bgc.record_class import dataclass
from bgc.values.units import Dimension

Shape: TypeAlias = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Value:
    """A scalar `()`, vector `(n,)` or matrix `(m, n)` of nodes, row after row.

    `units[k]` is the dimension of `nodes[k]`, whose value is in SI units. It is None if unknown, as
    for a literal without a unit, which fits any unit. Components may differ in unit, as those of a
    twist do.
    """

    shape: Shape
    nodes: tuple[int, ...]
    units: tuple[Dimension | None, ...]

    def __post_init__(self) -> None:
        assert len(self.shape) <= 2, self.shape
        assert len(self.nodes) == len(self.units) == prod(self.shape)

    @staticmethod
    def scalar(node: int, unit: Dimension | None = None) -> Value:
        """Make a scalar."""
        return Value((), (node,), (unit,))

    @staticmethod
    def vector(nodes: Iterable[int], unit: Dimension | None = None) -> Value:
        """Make a vector of one unit."""
        nodes = tuple(nodes)
        return Value((len(nodes),), nodes, (unit,) * len(nodes))

    @staticmethod
    def uniform(shape: Shape, nodes: Iterable[int], unit: Dimension | None = None) -> Value:
        """Make a value of any shape and one unit."""
        nodes = tuple(nodes)
        return Value(shape, nodes, (unit,) * len(nodes))

    @staticmethod
    def matrix(rows: Sequence[Sequence[int]], unit: Dimension | None = None) -> Value:
        """Make a matrix of one unit from its rows."""
        nodes = tuple(node for row in rows for node in row)
        return Value((len(rows), len(rows[0])), nodes, (unit,) * len(nodes))

    @property
    def node(self) -> int:
        """The node of a scalar, or of a vector or matrix of one component."""
        assert len(self.nodes) == 1, self.shape
        return self.nodes[0]

    @property
    def unit(self) -> Dimension | None:
        """The dimension that all components share; None if it is unknown or they differ."""
        first = self.units[0] if self.units else None
        return first if all(unit == first for unit in self.units) else None

    @property
    def is_scalar(self) -> bool:
        """True for a scalar, of shape `()`."""
        return not self.shape

    @property
    def rows(self) -> tuple[tuple[int, ...], ...]:
        """The nodes row by row; a vector is one column, a scalar 1 x 1."""
        columns = self.shape[1] if len(self.shape) == 2 else 1
        return tuple(
            self.nodes[start : start + columns] for start in range(0, len(self.nodes), columns)
        )

    @property
    def components(self) -> tuple[Value, ...]:
        """The scalars in order, a matrix row after row."""
        return tuple(
            Value.scalar(node, unit) for node, unit in zip(self.nodes, self.units, strict=True)
        )

    def components_at(self, places: Iterable[int]) -> Iterator[tuple[int, Dimension | None]]:
        """Nodes and units at places in row-major order, counted from 0."""
        return ((self.nodes[place], self.units[place]) for place in places)

    def with_unit(self, unit: Dimension | None) -> Value:
        """Return the same nodes, all with a given unit."""
        return Value(self.shape, self.nodes, (unit,) * len(self.nodes))


def describe_shape(shape: Shape) -> str:
    """Describe a shape in messages: `a scalar`, `a vector of 3`, `a 3 x 2 matrix`."""
    match shape:
        case ():
            return "a scalar"
        case (size,):
            return f"a vector of {size}"
        case _:
            return with_article(f"{shape[0]} x {shape[1]} matrix")
