"""The type of a row of `operations`: everything the compiler knows about one operation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum, IntEnum
from fractions import Fraction
from typing import Protocol, TypeAlias

from bgc.algebra.intervals import UNKNOWN, Bounds, Limits
from bgc.algebra.nodes import Node
from bgc.record_class import dataclass, field


class Builder(Protocol):
    """The methods of a `Dag` that rules for derivatives and inverses build nodes with."""

    zero: Node
    one: Node

    def const(self, value: int | float | Fraction) -> Node:
        """The node of an exact constant."""

    def add(self, a: Node, b: Node) -> Node:
        """A + b."""

    def sub(self, a: Node, b: Node) -> Node:
        """A - b."""

    def mul(self, a: Node, b: Node) -> Node:
        """A * b."""

    def div(self, a: Node, b: Node) -> Node:
        """A / b."""

    def neg(self, a: Node) -> Node:
        """The opposite of a."""

    def pow(self, a: Node, b: Node) -> Node:
        """A ^ b."""

    def select(self, condition: Node, yes: Node, no: Node) -> Node:
        """`yes` where the condition is not zero, else `no`."""

    def call(self, op: int, *operands: Node) -> Node:
        """Any other operation."""

    def value(self, node: Node) -> Fraction | None:
        """The exact value of a constant, None for any other node."""


Partials: TypeAlias = Callable[..., tuple[Node, ...]]
"""(builder, result, *operands) -> the derivatives by the operands, in order."""

Choice: TypeAlias = Callable[..., tuple[Node, Node, Node]]
"""(builder, *operands) -> the condition, the result where it holds, the result elsewhere."""


Pieces: TypeAlias = Callable[..., tuple[Node, Node]]
"""(builder, mode, *operands) -> the argument that determines the mode, the result in that mode."""


class Parity(Enum):
    """Symmetry of a function of one operand."""

    ODD = "odd"  # f(-x) = -f(x)
    EVEN = "even"  # f(-x) = f(x)
    NONE = "none"


class Jump(IntEnum):
    """A piecewise operation on one argument z, numbered as `bgc_operation` in `bgc.h`."""

    ABOVE = 0  # z > 0
    NOT_BELOW = 1  # z >= 0
    SIGN = 2  # -1, 0, 1
    FLOOR = 3
    CEIL = 4
    TRUNC = 5


class Conic(IntEnum):
    """A curve with a rational parameter t. Functions on one curve share t for an equal operand."""

    CIRCLE = 101
    HYPERBOLA = 102


@dataclass(frozen=True, slots=True)
class Curve:
    """A function as a quotient of polynomials in the parameter of a conic.

    `point(t)` gives dividend and divisor. t is an odd function of the operand, so that fingerprints
    satisfy the identities between the functions of one conic, as sin^2 + cos^2 = 1.
    """

    conic: Conic
    point: Callable[[int], tuple[int, int]]


class Lanes(Enum):
    """Source of the function on a vector register of `bgc_lanes.h`.

    Vector functions of glibc (libmvec) have errors of at most 4 units in the last place.
    """

    LOOP = "loop"  # the scalar function, lane by lane
    LIBMVEC = "libmvec"  # glibc's vector function, in every libmvec
    LIBMVEC_2_35 = "libmvec_2_35"  # glibc's vector function, since glibc 2.35
    FORMULA = "formula"  # `lane_formula`, compiled into each model that uses it
    HEADER = "header"  # `bgc_lanes.h`, since the C runtime uses it too


class Watch(IntEnum):
    """A function that a step may jump over a pulse of, numbered as `bgc_watch` in `bgc.h`."""

    EXPONENTIAL = 0  # the pulse is where the argument is largest
    SATURATING = 1  # where it comes near zero and returns
    RECIPROCAL = 2  # the same, for a divisor


@dataclass(frozen=True, slots=True)
class Infix:
    """An operator as text: its symbol, and how tightly it binds (1 loosest, 8 tightest).

    An operand of equal binding needs parentheses on a `strict` side.
    """

    symbol: str
    binding: int
    strict_left: bool = False
    strict_right: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Operation:
    """One operation of the expression graph.

    Attributes
    ----------
    name
        Name of the function in the language; empty for operators.
    doc
        One line for users: meaning, unit of the argument, unit of the result.
    arguments
        Names of the operands, for documentation; their number is the arity.
    variadic
        Whether the language takes any number of arguments (`max(a, b, c)`).
    plain
        Whether the language requires dimensionless arguments. Otherwise any unit will do, the same
        for all arguments.
    unit_power
        Power of the argument's unit that is the unit of the result; 0 for a dimensionless result.
    evaluate
        The operation on doubles, with the results of C at the edges (overflow, poles, NaN).
    points
        Exact values at exact operands of a function of one operand.
    exact
        Exact value at exact operands; None where it is not rational. Replaces `points`.
    root
        Value at an exact operand as (s, n), for s sqrt(n); None where it is not a root.
    partials
        Derivatives by the operands; shorter than `arguments` where the last ones are constant.
        Empty for a piecewise constant operation; None for a choice and for leaves.
    choice
        The operation as `if condition then yes else no`; its derivative is that of the branch.
    inverse
        (builder, y) -> the only x with f(x) = y, which is NaN where there is none. None for
        functions that are not one to one.
    parity
        Symmetry of a function of one operand.
    symmetric
        Whether the two operands may be exchanged.
    bounds
        The rule for the interval of the result.
    domain
        The operands at which a monotone function is a number; it is NaN elsewhere.
    image
        Limits of the result for all operands.
    curve
        The function on a conic, for fingerprints.
    jump
        The mode that a piecewise operation switches at run time; None for a smooth operation.
    pieces
        (builder, mode, *operands) -> the argument z of `jump`, and the result in a mode. The
        argument is at the edge of a mode where the operation jumps or has a kink.
    kink
        Whether the result is continuous where the mode changes, and only its slope jumps.
    watch
        How a step may jump over a pulse of this function of states; None if it hardly can.
    infix
        The operator as text; None for functions.
    latex
        A LaTeX command that is applied to the arguments (`\\sin`), or a notation with `#` for each
        operand (`\\sqrt{#}`, `# < #`); by default the name, upright. Empty for arithmetic, which
        the printer lays out itself.
    c
        Name of the C function, of `math.h` (by default `name`) or made from `c_formula`. Empty for
        operators of C.
    c_formula
        The value as a C expression in `a` (and `b`), for a function that `math.h` lacks. A NaN
        operand must not become a plausible number.
    c_header
        The header of the runtime that defines `c`, for a function of several statements.
    smooth
        Whether it has a formula, with derivatives: not a hash, nor a table.
    lanes
        Where the function on vector registers comes from.
    lane_formula
        The value as an expression on `lane` values, for `Lanes.FORMULA`.
    """

    name: str = ""
    doc: str = ""
    arguments: tuple[str, ...] = ("x",)
    variadic: bool = False
    plain: bool = True
    unit_power: Fraction = Fraction(0)
    evaluate: Callable[..., float]
    points: Mapping[int, int] = field(default_factory=dict)
    exact: Callable[..., int | Fraction | None] | None = None
    root: Callable[[Fraction], tuple[Fraction, int] | None] | None = None
    partials: Partials | None
    choice: Choice | None = None
    inverse: Callable[[Builder, Node], Node] | None = None
    parity: Parity = Parity.NONE
    symmetric: bool = False
    bounds: Bounds = UNKNOWN
    domain: Limits = (None, None)
    image: Limits = (None, None)
    curve: Curve | None = None
    jump: Jump | None = None
    pieces: Pieces | None = None
    kink: bool = False
    watch: Watch | None = None
    infix: Infix | None = None
    latex: str = ""
    c: str = ""
    c_formula: str = ""
    c_header: str = ""
    smooth: bool = True
    lanes: Lanes = Lanes.LOOP
    lane_formula: str = ""

    def __post_init__(self) -> None:
        if self.name:
            assert self.doc, f"`{self.name}` is not documented"
            object.__setattr__(self, "c", self.c or self.name)
            object.__setattr__(self, "latex", self.latex or rf"\operatorname{{{self.name}}}")
        assert (self.lane_formula != "") == (self.lanes is Lanes.FORMULA), self.c
        assert not (self.partials and self.choice), self.c
        assert (self.jump is None) == (self.pieces is None), self.c

    @property
    def arity(self) -> int:
        """The number of operands."""
        return len(self.arguments)

    def folded(self, operands: list[Fraction]) -> int | Fraction | None:
        """The exact value at exact operands; None where it is not known to be rational."""
        if self.exact is not None:
            return self.exact(*operands)
        (x,) = operands[:1]
        return self.points.get(x.numerator) if x.denominator == 1 and self.arity == 1 else None
