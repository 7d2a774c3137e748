"""The lowered program: the contents of each C function of a model, before C is printed.

A kernel is a list of array elements with the nodes assigned to them. The factorisation of the
iteration matrix is planned symbolically: pivots, fill and order of the operations.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

from bgc.algebra.operation import Jump, Watch
from bgc.diagnostics.source import Span
from bgc.ir.graph import Node
from bgc.ir.program import Program
from bgc.record_class import dataclass, field, replace


@dataclass(frozen=True, slots=True)
class Jacobian:
    """The stored entries of df/dx, sorted by row, then column, and df/dt for every row.

    With `inner` unknowns z beside the states, f = g(x, z) and 0 = r(x, z), the entries are those
    of [g_x g_z; r_x r_z], and `slopes` are the places of the entries of df/dx. `pivots` is the
    order in which the unknowns have to be eliminated, on the diagonal; empty where any order is as
    safe.
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    entries: tuple[Node, ...]
    by_time: tuple[Node, ...]
    inner: int = 0
    slopes: tuple[tuple[int, int], ...] = ()
    pivots: tuple[int, ...] = ()

    @property
    def size(self) -> int:
        """The number of unknowns of the linear systems."""
        return len(self.by_time) + self.inner


class Reads(Enum):
    """The arguments from which a kernel computes its nodes.

    PARAMETERS: p only. HOISTED: t, x, u, and h for the nodes of parameter level.
    """

    PARAMETERS = "parameters"
    HOISTED = "hoisted"


SCRATCH = "w"


@dataclass(frozen=True, slots=True)
class Store:
    """`array[index] = node`."""

    array: str
    index: int
    node: Node


@dataclass(frozen=True, slots=True)
class Kernel:
    """A C function `name(inputs, results, w)` that performs the stores.

    The argument names are in the order of the C interface; w is scratch memory. What is stored in
    w, from its start on, is there for a kernel that runs next and finds these nodes there, `found`.
    An `in_place` kernel reads the array that it writes, and performs all stores after all reads.
    """

    name: str
    purpose: str  # the comment above the C function
    inputs: tuple[str, ...]
    results: tuple[str, ...]
    reads: Reads
    stores: tuple[Store, ...]
    in_place: bool = False
    found: tuple[Node, ...] = ()

    @property
    def left(self) -> tuple[Store, ...]:
        """The stores to w, from which the next kernel reads."""
        return tuple(store for store in self.stores if store.array == SCRATCH)

    @property
    def without_left(self) -> Kernel:
        """The same kernel for callers that run none of those which find what is left in w."""
        stores = tuple(store for store in self.stores if store.array != SCRATCH)
        return replace(self, stores=stores)


@dataclass(frozen=True, slots=True)
class LuPlan:
    """The symbolic LU factorisation of `W = c M - J`: pivots and fill.

    Pivot k is in row `rows[k]` and column `columns[k]` of W. Row k of the factors has its entries
    left of the pivot in the columns of the pivots `lower[k]`, those right of it in the columns of
    the pivots `upper[k]` (both ascending). `units` maps places (k, j) of the factors that are
    always 1 or -1 to that number. `operations` counts the multiplications, additions and divisions
    of one numerical factorisation.
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    lower: tuple[tuple[int, ...], ...]
    upper: tuple[tuple[int, ...], ...]
    operations: int
    units: Mapping[tuple[int, int], int] = field(default_factory=dict)

    @property
    def entries(self) -> int:
        """The number of stored entries of both factors, including the pivots."""
        return len(self.rows) + sum(map(len, self.lower)) + sum(map(len, self.upper))


@dataclass(frozen=True, slots=True)
class BlockPlan:
    """The symbolic LU factorisation of `W = c M - J` in blocks of consecutive pivots.

    Pivot k is in row `rows[k]` and column `columns[k]` of W; block t has `sizes[t]` pivots, at most
    8. Its rows have entries in the columns of the blocks `left[t]`, all before it, and in the
    columns of the pivots `right[t]`, all after it (both ascending). Entries that are always zero
    are stored where other rows of the block have one.
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    sizes: tuple[int, ...]
    left: tuple[tuple[int, ...], ...]
    right: tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True)
class Switch:
    """A piecewise operation whose result or piece (its mode) is held constant over a step.

    Mode k is INPUT symbol `program.inputs + k`; where it is NaN, the operation is evaluated.
    """

    operation: Jump
    argument: Node
    timed: bool  # the argument does not depend on states
    jumps: bool  # False if the rates are provably continuous at the switch
    place: Span | None  # of the operation in the source
    owner: str  # the element in whose law it stands; empty outside laws
    states: tuple[str, ...]  # names of the states in the argument
    of_jump: bool = False  # the condition of a jump depends on it
    rate: Node | None = None  # by time, of a timed one whose argument does not jump


@dataclass(frozen=True, slots=True)
class Lowered:
    """A program with its kernels, Jacobian and LU plan; `hoisted[k]` is the node of h[k].

    `blocks` is the plan by which a single instance factorises W, where blocks of rows are faster
    than code or tables of single entries. `ranges` and `timed_ranges` are evaluated in interval
    arithmetic: b[2 k] is term or argument k, b[2 k + 1] its derivative by time; of an argument that
    jumps there is none.
    """

    program: Program
    switches: tuple[Switch, ...]
    jacobian: Jacobian
    plan: LuPlan
    hoisted: tuple[Node, ...]
    kernels: tuple[Kernel, ...]
    watches: tuple[tuple[Watch, Node], ...] = ()  # functions that may hide pulses, and arguments
    ranges: Kernel | None = None  # of the terms of time alone and their derivatives
    timed_ranges: Kernel | None = None  # of the arguments of switches of time alone, the same
    blocks: BlockPlan | None = None

    @property
    def range_kernels(self) -> tuple[Kernel, ...]:
        """The kernels that are evaluated in interval arithmetic."""
        return tuple(k for k in (self.ranges, self.timed_ranges) if k is not None)
