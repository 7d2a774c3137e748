"""The lowered program: what each C function of a model has to compute, before any C is written.

Pure data between the passes over the graph and the printer. A kernel is a list of array
elements and the nodes they get; the iteration matrix of the stiff methods is a plan of which
entries to compute in which order.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from bgc.algebra.operation import Jump
from bgc.diagnostics.source import Span
from bgc.ir.graph import Node
from bgc.ir.program import Program


@dataclass(frozen=True, slots=True)
class Jacobian:
    """Stored entries of df/dx, by rows then columns, and df/dt of every row."""

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    entries: tuple[Node, ...]
    by_time: tuple[Node, ...]


class Reads(Enum):
    """What a kernel may refer to, which settles the nodes it finds ready.

    PARAMETERS: p alone. HOISTED: everything of parameter level is in h, next to t, x and u.
    """

    PARAMETERS = "parameters"
    HOISTED = "hoisted"


@dataclass(frozen=True, slots=True)
class Store:
    """`array[index] = node`."""

    array: str
    index: int
    node: Node


@dataclass(frozen=True, slots=True)
class Kernel:
    """One C function `name(inputs, results, w)` that makes all its stores.

    The names of its arguments are in the order of the C interface; w is scratch. One that is
    `in_place` reads the array it writes, and makes all stores after all reads.
    """

    name: str
    purpose: str  # the comment above it
    inputs: tuple[str, ...]
    results: tuple[str, ...]
    reads: Reads
    stores: tuple[Store, ...]
    in_place: bool = False


@dataclass(frozen=True, slots=True)
class LuPlan:
    """Pivots and fill of the LU factors of `W = c M - J`, symbolically.

    Pivot k is in row `rows[k]` and column `columns[k]` of W. `lower[k]` and `upper[k]` are the
    pivots (ascending) whose columns hold the entries of row k left and right of its pivot.
    `operations` counts the multiplications, additions and divisions of one factorisation.
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    lower: tuple[tuple[int, ...], ...]
    upper: tuple[tuple[int, ...], ...]
    operations: int

    @property
    def entries(self) -> int:
        """Stored entries of both factors, the pivots among them."""
        return len(self.rows) + sum(map(len, self.lower)) + sum(map(len, self.upper))


@dataclass(frozen=True, slots=True)
class Switch:
    """A discontinuous operation whose result, its mode, is held over a step.

    Mode k is INPUT symbol `program.inputs + k`; where it is a NaN, the operation is made instead.
    """

    operation: Jump
    argument: Node
    timed: bool  # no state is in the argument
    jumps: bool  # False: what it switches is continuous there, for certain
    place: Span | None  # in the source
    states: tuple[str, ...]  # names of those in the argument


@dataclass(frozen=True, slots=True)
class Lowered:
    """All that the printer needs. `hoisted[k]` is the node that h[k] holds."""

    program: Program
    switches: tuple[Switch, ...]
    jacobian: Jacobian
    plan: LuPlan
    hoisted: tuple[Node, ...]
    kernels: tuple[Kernel, ...]
