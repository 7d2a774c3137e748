"""The operations of the expression graph, one row each.

A function of the language is added here and nowhere else: its name, documentation, Python and C,
derivative, exact values, symmetry and LaTeX are the fields of its row. All passes read the rows,
and `tests/unit/test_operations.py` checks every row against independent answers.
"""

from __future__ import annotations

import math
from enum import IntEnum
from fractions import Fraction

from bgc.algebra import doubles, intervals
from bgc.algebra.angles import PI, cosine_of, sine_of, tangent_of
from bgc.algebra.intervals import Bounds
from bgc.algebra.nodes import Node
from bgc.algebra.operation import (
    Builder,
    Conic,
    Curve,
    Infix,
    Jump,
    Lanes,
    Operation,
    Parity,
    Watch,
)
from bgc.algebra.random import random
from bgc.algebra.table import derivative_of

_TWO_OVER_SQRT_PI = Fraction("1.128379167095512573896158903121545171688101258657997")
_ONE_OVER_LN_10 = Fraction("0.4342944819032518276511289189166050822943970058036665")
_RIGHT_ANGLE = Fraction("1.5707963267949")  # not below pi/2
_TRUTH = (0, 1)
_LIMITED, _OVERFLOW = doubles.with_limits, doubles.outwards

# --- rules shared by several rows ---------------------------------------------------------------


def _guarded(d: Builder, divisor: Node, dividend: Node) -> Node:
    """`dividend / divisor`, and 0 where the divisor is 0 (a NaN is not)."""
    return d.select(divisor, d.div(dividend, divisor), d.zero)


def _one_over_root(d: Builder, a: Node, b: Node) -> Node:
    """`1 / sqrt(a - b)`; 0 at the end of the domain, where it is infinite."""
    return _guarded(d, d.call(Op.SQRT, d.sub(a, b)), d.one)


def _quotient_partials(d: Builder, y: Node, a: Node, b: Node) -> tuple[Node, ...]:
    reciprocal = d.div(d.one, b)
    return reciprocal, d.neg(d.mul(y, reciprocal))


def _power_partials(d: Builder, y: Node, a: Node, b: Node) -> tuple[Node, ...]:
    """By a: `b a^(b-1)`, and 0 where that is infinite at a = 0; by b: `a^b log a`, 0 at a = 0."""
    by_base = d.mul(b, d.pow(a, d.sub(b, d.one)))
    exponent = d.value(b)
    if exponent is not None:
        rooted = 0 < exponent < 1
        return (d.select(a, by_base, d.zero) if rooted else by_base,)
    at_zero = d.call(Op.EQ, b, d.one)
    logarithm = d.select(a, d.call(Op.LOG, a), d.zero)
    return d.select(a, by_base, at_zero), d.mul(y, logarithm)


def _angle_partials(d: Builder, angle: Node, y: Node, x: Node) -> tuple[Node, ...]:
    inverse_square = _guarded(d, d.add(d.mul(y, y), d.mul(x, x)), d.one)
    return d.mul(x, inverse_square), d.neg(d.mul(y, inverse_square))


def _hypotenuse_partials(d: Builder, y: Node, a: Node, b: Node) -> tuple[Node, ...]:
    reciprocal = _guarded(d, y, d.one)
    return d.mul(a, reciprocal), d.mul(b, reciprocal)


def _error_function_slope(d: Builder, x: Node) -> Node:
    """`2 / sqrt(pi) exp(-x^2)`."""
    return d.mul(d.const(_TWO_OVER_SQRT_PI), d.call(Op.EXP, d.neg(d.mul(x, x))))


def _no_partials(d: Builder, y: Node, *operands: Node) -> tuple[Node, ...]:
    """The derivatives of a piecewise constant operation, which are zero."""
    return ()


def _mode_of(d: Builder, mode: Node, x: Node) -> tuple[Node, Node]:
    """The operand determines the mode, which is the result."""
    return x, mode


def _mode_of_difference(d: Builder, mode: Node, a: Node, b: Node) -> tuple[Node, Node]:
    """The mode of `b - a` is the result."""
    return d.sub(b, a), mode


def _remainder_in_mode(d: Builder, mode: Node, a: Node, b: Node) -> tuple[Node, Node]:
    """The mode is the whole part of the quotient."""
    return d.div(a, b), d.sub(a, d.mul(b, mode))


def _within_right_angle(d: Builder, value: Node, angle: Node) -> Node:
    """A value where `abs(angle) < pi/2`, NaN elsewhere."""
    margin = d.sub(d.const(PI / 2), d.call(Op.ABS, angle))
    return d.select(d.call(Op.LT, d.zero, margin), value, d.call(Op.SQRT, margin))


def _root_of_square(x: Fraction) -> Fraction | None:
    """The square root of a fraction, if it is one itself."""
    if x < 0:
        return None
    root = Fraction(math.isqrt(x.numerator), math.isqrt(x.denominator))
    return root if root * root == x else None


def _table_slope(d: Builder, op: int, argument: int, table: Node, *rest: Node) -> Node:
    """A table's derivative by one of its arguments: the same table of higher order."""
    number = d.value(table)
    assert number is not None
    found = derivative_of(int(number), argument)
    return d.zero if found is None else d.call(op, d.const(found), *rest)


def _not_computed(*operands: float) -> float:
    raise AssertionError("a leaf has no operation")


# --- the table ----------------------------------------------------------------------------------


class Op(IntEnum):
    """The operation of a node. Members are equal to small ints; `row` holds what is known of each.

    The arithmetic of CONST to SELECT is folded by methods of `Dag`.
    """

    row: Operation

    def __new__(cls, row: Operation | int) -> Op:
        """Number the members in the order of their definition; an int looks a member up."""
        assert isinstance(row, Operation)
        number = len(cls.__members__)
        member = int.__new__(cls, number)
        member._value_ = number
        member.row = row
        return member

    # --- leaves ---------------------------------------------------------------------------------

    CONST = Operation(arguments=(), evaluate=_not_computed, partials=None)
    SYMBOL = Operation(arguments=(), evaluate=_not_computed, partials=None)

    # --- arithmetic and choices -----------------------------------------------------------------

    ADD = Operation(
        arguments=("a", "b"),
        evaluate=lambda a, b: a + b,
        partials=lambda d, y, a, b: (d.one, d.one),
        symmetric=True,
        infix=Infix("+", 5),
        bounds=Bounds("sum", intervals.total),
    )
    SUB = Operation(
        arguments=("a", "b"),
        evaluate=lambda a, b: a - b,
        partials=lambda d, y, a, b: (d.one, d.const(-1)),
        infix=Infix("-", 5, strict_right=True),
        bounds=Bounds("difference", intervals.difference),
    )
    MUL = Operation(
        arguments=("a", "b"),
        evaluate=lambda a, b: a * b,
        partials=lambda d, y, a, b: (b, a),
        symmetric=True,
        infix=Infix("*", 6),
        bounds=Bounds("product", intervals.product),
    )
    DIV = Operation(
        arguments=("a", "b"),
        evaluate=doubles.divide,
        partials=_quotient_partials,
        watch=Watch.RECIPROCAL,
        infix=Infix("/", 6, strict_right=True),
        bounds=Bounds("quotient", intervals.quotient),
    )
    NEG = Operation(
        arguments=("a",),
        evaluate=lambda a: -a,
        partials=lambda d, y, a: (d.const(-1),),
        inverse=lambda d, y: d.neg(y),
        parity=Parity.ODD,
        infix=Infix("-", 7),
        bounds=Bounds("opposite", intervals.opposite),
    )
    POW = Operation(
        arguments=("a", "b"),
        evaluate=doubles.power,
        partials=_power_partials,
        infix=Infix("^", 8, strict_left=True),
        c="pow",
        lanes=Lanes.LIBMVEC,
        bounds=Bounds("power", intervals.power),
    )
    SELECT = Operation(  # a if nonzero then b else c
        arguments=("condition", "yes", "no"),
        evaluate=doubles.choose,
        partials=None,
        choice=lambda d, condition, yes, no: (condition, yes, no),
        bounds=Bounds("choice", intervals.choice),
    )
    MAX = Operation(
        name="max",
        doc="Largest argument by component, or largest component of one vector; all of one unit.",
        arguments=("a", "b"),
        variadic=True,
        plain=False,
        unit_power=Fraction(1),
        evaluate=doubles.larger,
        exact=max,
        partials=None,
        choice=lambda d, a, b: (d.call(Op.LE, b, a), a, b),
        symmetric=True,
        jump=Jump.NOT_BELOW,
        pieces=lambda d, mode, a, b: (d.sub(a, b), d.select(mode, a, b)),
        kink=True,
        latex=r"\max",
        c="model_max",
        c_formula="a > b || a != a ? a : b",
        lanes=Lanes.HEADER,
        bounds=Bounds("max", intervals.largest),
    )
    MIN = Operation(
        name="min",
        doc="Smallest argument by component, or smallest component of one vector; all of one unit.",
        arguments=("a", "b"),
        variadic=True,
        plain=False,
        unit_power=Fraction(1),
        evaluate=doubles.smaller,
        exact=min,
        partials=None,
        choice=lambda d, a, b: (d.call(Op.LE, a, b), a, b),
        symmetric=True,
        jump=Jump.NOT_BELOW,
        pieces=lambda d, mode, a, b: (d.sub(b, a), d.select(mode, a, b)),
        kink=True,
        latex=r"\min",
        c="model_min",
        c_formula="a < b || a != a ? a : b",
        lanes=Lanes.HEADER,
        bounds=Bounds("min", intervals.smallest),
    )

    # --- signs, comparisons, logic: piecewise constant ------------------------------------------

    SIGN = Operation(
        name="sign",
        doc="Sign of a number of any unit: -1, 0 or 1. It jumps: a run ends a step at the jump.",
        plain=False,
        evaluate=doubles.sign,
        exact=lambda x: (x > 0) - (x < 0),
        partials=_no_partials,
        parity=Parity.ODD,
        jump=Jump.SIGN,
        pieces=_mode_of,
        latex=r"\operatorname{sgn}",
        c="model_sign",
        c_formula="a > 0.0 ? 1.0 : a < 0.0 ? -1.0 : a",
        lanes=Lanes.HEADER,
        bounds=intervals.RISING,
        image=(-1, 1),
    )
    LT = Operation(
        arguments=("a", "b"),
        evaluate=lambda a, b: doubles.truth(a < b, a, b),
        exact=lambda a, b: int(a < b),
        partials=_no_partials,
        jump=Jump.ABOVE,
        pieces=_mode_of_difference,
        infix=Infix("<", 4, strict_left=True, strict_right=True),
        latex="# < #",
        c="model_less",
        c_formula="a < b ? 1.0 : a >= b ? 0.0 : (double)NAN",
        lanes=Lanes.FORMULA,
        lane_formula="lane_truth(a < b, a >= b)",
        bounds=Bounds("less", intervals.corners),
        image=_TRUTH,
    )
    LE = Operation(
        arguments=("a", "b"),
        evaluate=lambda a, b: doubles.truth(a <= b, a, b),
        exact=lambda a, b: int(a <= b),
        partials=_no_partials,
        jump=Jump.NOT_BELOW,
        pieces=_mode_of_difference,
        infix=Infix("<=", 4, strict_left=True, strict_right=True),
        latex=r"# \leq #",
        c="model_at_most",
        c_formula="a <= b ? 1.0 : a > b ? 0.0 : (double)NAN",
        lanes=Lanes.FORMULA,
        lane_formula="lane_truth(a <= b, a > b)",
        bounds=Bounds("at_most", intervals.corners),
        image=_TRUTH,
    )
    EQ = Operation(
        arguments=("a", "b"),
        evaluate=doubles.equal,
        exact=lambda a, b: int(a == b),
        partials=_no_partials,
        symmetric=True,
        infix=Infix("==", 4, strict_left=True, strict_right=True),
        latex="# = #",
        c="model_equal",
        c_formula="a == b ? 1.0 : a == a && b == b ? 0.0 : (double)NAN",
        lanes=Lanes.FORMULA,
        lane_formula="lane_truth(a == b, (a < b) | (a > b))",
        bounds=Bounds("equal", intervals.unknown),
        image=_TRUTH,
    )
    AND = Operation(  # an undefined side does not matter where the other decides
        arguments=("a", "b"),
        evaluate=doubles.both,
        exact=lambda a, b: int(a != 0 and b != 0),
        partials=_no_partials,
        symmetric=True,
        infix=Infix("and", 2),
        latex=r"# \wedge #",
        c="model_both",
        c_formula="a == 0.0 || b == 0.0 ? 0.0 : a == a && b == b ? 1.0 : (double)NAN",
        lanes=Lanes.FORMULA,
        lane_formula="lane_truth(lane_is(a) & lane_is(b), "
        "(a == lane_of(0.0)) | (b == lane_of(0.0)))",
        bounds=Bounds("both", intervals.unknown),
        image=_TRUTH,
    )
    OR = Operation(
        arguments=("a", "b"),
        evaluate=doubles.either,
        exact=lambda a, b: int(a != 0 or b != 0),
        partials=_no_partials,
        symmetric=True,
        infix=Infix("or", 1),
        latex=r"# \vee #",
        c="model_either",
        c_formula="a < 0.0 || a > 0.0 || b < 0.0 || b > 0.0 ? 1.0 : a + b",
        lanes=Lanes.FORMULA,
        lane_formula="lane_truth(lane_is(a) | lane_is(b), "
        "(a == lane_of(0.0)) & (b == lane_of(0.0)))",
        bounds=Bounds("either", intervals.unknown),
        image=_TRUTH,
    )
    NOT = Operation(
        arguments=("a",),
        evaluate=lambda a: doubles.truth(a == 0, a),
        exact=lambda a: int(a == 0),
        partials=_no_partials,
        parity=Parity.EVEN,
        infix=Infix("not ", 3),
        latex=r"\neg #",
        c="model_negation",
        c_formula="a == 0.0 ? 1.0 : a == a ? 0.0 : a",
        lanes=Lanes.FORMULA,
        lane_formula="lane_truth(a == lane_of(0.0), lane_is(a))",
        bounds=Bounds("negation", intervals.unknown),
        image=_TRUTH,
    )

    # --- trigonometric functions ----------------------------------------------------------------

    SIN = Operation(
        name="sin",
        doc="Sine of an angle in rad (`sin(30 deg)` is 0.5); result without unit.",
        evaluate=_LIMITED(math.sin, _OVERFLOW),
        points={0: 0},
        root=sine_of,
        partials=lambda d, y, x: (d.call(Op.COS, x),),
        parity=Parity.ODD,
        curve=Curve(Conic.CIRCLE, lambda t: (2 * t, 1 + t * t)),
        latex=r"\sin",
        lanes=Lanes.LIBMVEC,
        bounds=Bounds("sin", intervals.wave(math.pi / 2)),
        image=(-1, 1),
    )
    COS = Operation(
        name="cos",
        doc="Cosine of an angle in rad; result without unit.",
        evaluate=_LIMITED(math.cos, _OVERFLOW),
        points={0: 1},
        root=cosine_of,
        partials=lambda d, y, x: (d.neg(d.call(Op.SIN, x)),),
        parity=Parity.EVEN,
        curve=Curve(Conic.CIRCLE, lambda t: (1 - t * t, 1 + t * t)),
        latex=r"\cos",
        lanes=Lanes.LIBMVEC,
        bounds=Bounds("cos", intervals.wave(0.0)),
        image=(-1, 1),
    )
    TAN = Operation(
        name="tan",
        doc="Tangent of an angle in rad; result without unit.",
        evaluate=_LIMITED(math.tan, _OVERFLOW),
        points={0: 0},
        root=tangent_of,
        partials=lambda d, y, x: (d.add(d.one, d.mul(y, y)),),
        parity=Parity.ODD,
        curve=Curve(Conic.CIRCLE, lambda t: (2 * t, 1 - t * t)),
        latex=r"\tan",
        lanes=Lanes.LIBMVEC_2_35,
        bounds=Bounds("tan", intervals.tangent),
    )
    ASIN = Operation(
        name="asin",
        doc="Inverse sine of a number from -1 to 1; an angle in rad from -pi/2 to pi/2.",
        evaluate=_LIMITED(math.asin, _OVERFLOW),
        points={0: 0},
        partials=lambda d, y, x: (_one_over_root(d, d.one, d.mul(x, x)),),
        inverse=lambda d, y: _within_right_angle(d, d.call(Op.SIN, y), y),
        parity=Parity.ODD,
        latex=r"\arcsin",
        lanes=Lanes.LIBMVEC_2_35,
        bounds=intervals.RISING,
        domain=(-1, 1),
        image=(-_RIGHT_ANGLE, _RIGHT_ANGLE),
    )
    ACOS = Operation(
        name="acos",
        doc="Inverse cosine of a number from -1 to 1; an angle in rad from 0 to pi.",
        evaluate=_LIMITED(math.acos, _OVERFLOW),
        points={1: 0},
        partials=lambda d, y, x: (d.neg(_one_over_root(d, d.one, d.mul(x, x))),),
        latex=r"\arccos",
        lanes=Lanes.LIBMVEC_2_35,
        bounds=intervals.FALLING,
        domain=(-1, 1),
        image=(0, 2 * _RIGHT_ANGLE),
    )
    ATAN = Operation(
        name="atan",
        doc="Inverse tangent of a number without unit; an angle in rad between -pi/2 and pi/2.",
        evaluate=math.atan,
        points={0: 0},
        partials=lambda d, y, x: (d.div(d.one, d.add(d.one, d.mul(x, x))),),
        inverse=lambda d, y: _within_right_angle(d, d.call(Op.TAN, y), y),
        parity=Parity.ODD,
        latex=r"\arctan",
        lanes=Lanes.LIBMVEC_2_35,
        watch=Watch.SATURATING,
        bounds=intervals.RISING,
        image=(-_RIGHT_ANGLE, _RIGHT_ANGLE),
    )
    ATAN2 = Operation(
        name="atan2",
        doc="Angle in rad, from -pi to pi, of the point (x, y), whose coordinates have one unit.",
        arguments=("y", "x"),
        plain=False,
        evaluate=math.atan2,
        partials=_angle_partials,
        lanes=Lanes.LIBMVEC_2_35,
        bounds=Bounds("atan2", intervals.unknown),
        image=(-2 * _RIGHT_ANGLE, 2 * _RIGHT_ANGLE),
    )

    # --- hyperbolic functions, exponentials, logarithms -----------------------------------------

    SINH = Operation(
        name="sinh",
        doc="Hyperbolic sine; argument and result without unit.",
        evaluate=_LIMITED(math.sinh, _OVERFLOW),
        points={0: 0},
        partials=lambda d, y, x: (d.call(Op.COSH, x),),
        inverse=lambda d, y: d.call(Op.ASINH, y),
        parity=Parity.ODD,
        curve=Curve(Conic.HYPERBOLA, lambda t: (2 * t, 1 - t * t)),
        latex=r"\sinh",
        lanes=Lanes.LIBMVEC_2_35,
        bounds=intervals.RISING,
    )
    COSH = Operation(
        name="cosh",
        doc="Hyperbolic cosine; argument and result without unit.",
        evaluate=_LIMITED(math.cosh, doubles.upwards),
        points={0: 1},
        partials=lambda d, y, x: (d.call(Op.SINH, x),),
        parity=Parity.EVEN,
        curve=Curve(Conic.HYPERBOLA, lambda t: (1 + t * t, 1 - t * t)),
        latex=r"\cosh",
        lanes=Lanes.LIBMVEC_2_35,
        bounds=Bounds("cosh", intervals.even),
        image=(1, None),
    )
    TANH = Operation(
        name="tanh",
        doc="Hyperbolic tangent; argument and result without unit.",
        evaluate=math.tanh,
        points={0: 0},
        partials=lambda d, y, x: (d.sub(d.one, d.mul(y, y)),),
        inverse=lambda d, y: d.call(Op.ATANH, y),
        parity=Parity.ODD,
        curve=Curve(Conic.HYPERBOLA, lambda t: (2 * t, 1 + t * t)),
        latex=r"\tanh",
        lanes=Lanes.LIBMVEC_2_35,
        watch=Watch.SATURATING,
        bounds=intervals.RISING,
        image=(-1, 1),
    )
    ASINH = Operation(
        name="asinh",
        doc="Inverse hyperbolic sine; argument and result without unit.",
        evaluate=math.asinh,
        points={0: 0},
        partials=lambda d, y, x: (d.div(d.one, d.call(Op.SQRT, d.add(d.mul(x, x), d.one))),),
        inverse=lambda d, y: d.call(Op.SINH, y),
        parity=Parity.ODD,
        lanes=Lanes.LIBMVEC_2_35,
        bounds=intervals.RISING,
    )
    ACOSH = Operation(
        name="acosh",
        doc="Inverse hyperbolic cosine of a number from 1 on, not negative; both without unit.",
        evaluate=_LIMITED(math.acosh, doubles.upwards),
        points={1: 0},
        partials=lambda d, y, x: (_one_over_root(d, d.mul(x, x), d.one),),
        lanes=Lanes.LIBMVEC_2_35,
        bounds=intervals.RISING,
        domain=(1, None),
        image=(0, None),
    )
    ATANH = Operation(
        name="atanh",
        doc="Inverse hyperbolic tangent of a number between -1 and 1; both without unit.",
        evaluate=_LIMITED(math.atanh, _OVERFLOW, -1.0, 1.0),
        points={0: 0},
        partials=lambda d, y, x: (d.div(d.one, d.sub(d.one, d.mul(x, x))),),
        inverse=lambda d, y: d.call(Op.TANH, y),
        parity=Parity.ODD,
        lanes=Lanes.LIBMVEC_2_35,
        bounds=intervals.RISING,
        domain=(-1, 1),
    )
    EXP = Operation(
        name="exp",
        doc="Exponential function e^x; argument and result without unit.",
        evaluate=_LIMITED(math.exp, doubles.upwards),
        points={0: 1},
        partials=lambda d, y, x: (y,),
        inverse=lambda d, y: d.call(Op.LOG, y),
        curve=Curve(Conic.HYPERBOLA, lambda t: (1 + t, 1 - t)),
        latex=r"\exp",
        lanes=Lanes.LIBMVEC,
        watch=Watch.EXPONENTIAL,
        bounds=intervals.RISING,
        image=(0, None),
    )
    EXPM1 = Operation(
        name="expm1",
        doc="e^x - 1, accurate for small x too; argument and result without unit.",
        evaluate=_LIMITED(math.expm1, doubles.upwards),
        points={0: 0},
        partials=lambda d, y, x: (d.add(y, d.one),),
        inverse=lambda d, y: d.call(Op.LOG1P, y),
        curve=Curve(Conic.HYPERBOLA, lambda t: (2 * t, 1 - t)),
        lanes=Lanes.LIBMVEC_2_35,
        watch=Watch.EXPONENTIAL,
        bounds=intervals.RISING,
        image=(-1, None),
    )
    LOG = Operation(
        name="log",
        doc="Natural logarithm of a positive number; argument and result without unit.",
        evaluate=_LIMITED(math.log, doubles.downwards, 0.0),
        points={1: 0},
        partials=lambda d, y, x: (d.div(d.one, x),),
        inverse=lambda d, y: d.call(Op.EXP, y),
        latex=r"\ln",
        lanes=Lanes.LIBMVEC,
        bounds=intervals.RISING,
        domain=(0, None),
    )
    LOG10 = Operation(
        name="log10",
        doc="Logarithm to base 10 of a positive number; argument and result without unit.",
        evaluate=_LIMITED(math.log10, doubles.downwards, 0.0),
        points={1: 0},
        partials=lambda d, y, x: (d.mul(d.const(_ONE_OVER_LN_10), d.div(d.one, x)),),
        inverse=lambda d, y: d.pow(d.const(10), y),
        latex=r"\log_{10}",
        lanes=Lanes.LIBMVEC_2_35,
        bounds=intervals.RISING,
        domain=(0, None),
    )
    LOG1P = Operation(
        name="log1p",
        doc="log(1 + x), accurate for small x too; argument and result without unit.",
        evaluate=_LIMITED(math.log1p, doubles.downwards, -1.0),
        points={0: 0},
        partials=lambda d, y, x: (d.div(d.one, d.add(d.one, x)),),
        inverse=lambda d, y: d.call(Op.EXPM1, y),
        lanes=Lanes.LIBMVEC_2_35,
        bounds=intervals.RISING,
        domain=(-1, None),
    )

    # --- roots, size, rounding ------------------------------------------------------------------

    SQRT = Operation(
        name="sqrt",
        doc="Square root of a number that is not negative; the unit is the root of its unit.",
        plain=False,
        unit_power=Fraction(1, 2),
        evaluate=_LIMITED(math.sqrt, doubles.upwards),
        exact=_root_of_square,
        partials=lambda d, y, x: (_guarded(d, y, d.const(Fraction(1, 2))),),
        # The fourth power of sqrt(y), so that a negative y gives NaN.
        inverse=lambda d, y: d.pow(d.call(Op.SQRT, y), d.const(4)),
        latex=r"\sqrt{#}",
        bounds=intervals.RISING,
        domain=(0, None),
        image=(0, None),
    )
    CBRT = Operation(
        name="cbrt",
        doc="Cube root of a number of either sign; the unit is the cube root of its unit.",
        plain=False,
        unit_power=Fraction(1, 3),
        evaluate=math.cbrt,
        points={0: 0, 1: 1},
        partials=lambda d, y, x: (d.mul(d.const(Fraction(1, 3)), _guarded(d, d.mul(y, y), d.one)),),
        inverse=lambda d, y: d.pow(y, d.const(3)),
        parity=Parity.ODD,
        latex=r"\sqrt[3]{#}",
        lanes=Lanes.LIBMVEC_2_35,
        bounds=intervals.RISING,
    )
    HYPOT = Operation(
        name="hypot",
        doc="sqrt(a^2 + b^2) without overflow; arguments and result have one unit.",
        arguments=("a", "b"),
        plain=False,
        unit_power=Fraction(1),
        evaluate=math.hypot,
        exact=lambda a, b: _root_of_square(a * a + b * b),
        partials=_hypotenuse_partials,
        symmetric=True,
        lanes=Lanes.LIBMVEC_2_35,
        bounds=Bounds("hypot", intervals.hypotenuse),
        image=(0, None),
    )
    ABS = Operation(
        name="abs",
        doc="Absolute value of a number of any unit, in the same unit.",
        plain=False,
        unit_power=Fraction(1),
        evaluate=abs,
        exact=abs,
        partials=lambda d, y, x: (d.call(Op.SIGN, x),),
        parity=Parity.EVEN,
        jump=Jump.NOT_BELOW,
        pieces=lambda d, mode, x: (x, d.select(mode, x, d.neg(x))),
        kink=True,
        latex=r"\left| # \right|",
        c="fabs",
        lanes=Lanes.HEADER,
        bounds=Bounds("abs", intervals.size),
        image=(0, None),
    )
    FLOOR = Operation(
        name="floor",
        doc="Largest whole number not above a number without unit. It jumps, as `sign` does.",
        evaluate=doubles.rounding(math.floor),
        exact=math.floor,
        partials=_no_partials,
        jump=Jump.FLOOR,
        pieces=_mode_of,
        latex=r"\left\lfloor # \right\rfloor",
        bounds=intervals.RISING,
    )
    CEIL = Operation(
        name="ceil",
        doc="Smallest whole number not below a number without unit. It jumps, as `sign` does.",
        evaluate=doubles.rounding(math.ceil),
        exact=math.ceil,
        partials=_no_partials,
        jump=Jump.CEIL,
        pieces=_mode_of,
        latex=r"\left\lceil # \right\rceil",
        bounds=intervals.RISING,
    )
    FMOD = Operation(
        name="fmod",
        doc="Remainder of a / b with the sign of a, all of one unit. It jumps, as `sign` does.",
        arguments=("a", "b"),
        plain=False,
        unit_power=Fraction(1),
        evaluate=doubles.remainder,
        partials=lambda d, y, a, b: (d.one, d.neg(d.div(d.sub(a, y), b))),
        jump=Jump.TRUNC,
        pieces=_remainder_in_mode,
        bounds=Bounds("remainder", intervals.remainder),
    )

    # --- special functions ----------------------------------------------------------------------

    ERF = Operation(
        name="erf",
        doc="Error function, 2/sqrt(pi) times the integral of exp(-t^2) from 0 to x; no units.",
        evaluate=math.erf,
        points={0: 0},
        partials=lambda d, y, x: (_error_function_slope(d, x),),
        parity=Parity.ODD,
        lanes=Lanes.LIBMVEC_2_35,
        watch=Watch.SATURATING,
        bounds=intervals.RISING,
        image=(-1, 1),
    )
    ERFC = Operation(
        name="erfc",
        doc="Complementary error function 1 - erf(x), accurate for large x too; no units.",
        evaluate=math.erfc,
        points={0: 1},
        partials=lambda d, y, x: (d.neg(_error_function_slope(d, x)),),
        lanes=Lanes.LIBMVEC_2_35,
        watch=Watch.SATURATING,
        bounds=intervals.FALLING,
        image=(0, 2),
    )

    # --- random numbers -------------------------------------------------------------------------

    RANDOM = Operation(
        name="random",
        doc="Random number in [0, 1), a function of a whole seed and a whole index; no units.",
        arguments=("seed", "i"),
        evaluate=random,
        exact=lambda seed, i: None if math.isnan(x := random(seed, i)) else Fraction(x),
        partials=_no_partials,
        c="bgc_random",
        c_header="bgc_random.h",
        smooth=False,
        image=(0, 1),
    )

    # --- tables of data: the first operand is the number of a table -----------------------------

    LOOKUP = Operation(
        name="interpolate",
        doc="A smooth table of one argument.",
        arguments=("table", "x"),
        evaluate=_not_computed,
        partials=lambda d, y, table, x: (d.zero, _table_slope(d, Op.LOOKUP, 0, table, x)),
        c="bgc_lookup",
        lanes=Lanes.HEADER,
        smooth=False,
    )
    PLACE = Operation(  # rises with x; its whole part is the segment
        name="place",
        doc="Place of an argument among the segments of a table.",
        arguments=("table", "x"),
        evaluate=_not_computed,
        partials=_no_partials,
        c="bgc_place",
        lanes=Lanes.HEADER,
        smooth=False,
    )
    PIECE = Operation(
        name="interpolate",
        doc="A table of one argument, on a segment.",
        arguments=("table", "x", "segment"),
        evaluate=_not_computed,
        partials=lambda d, y, table, x, segment: (
            d.zero,
            _table_slope(d, Op.PIECE, 0, table, x, segment),
        ),
        c="bgc_piece",
        lanes=Lanes.HEADER,
        smooth=False,
    )
    LOOKUP2 = Operation(
        name="interpolate",
        doc="A table of two arguments.",
        arguments=("table", "x", "y"),
        evaluate=_not_computed,
        partials=lambda d, y, table, u, v: (
            d.zero,
            _table_slope(d, Op.LOOKUP2, 0, table, u, v),
            _table_slope(d, Op.LOOKUP2, 1, table, u, v),
        ),
        c="bgc_lookup2",
        lanes=Lanes.HEADER,
        smooth=False,
    )

    # --- matrices that a run inverts: `Dag.inverted` --------------------------------------------

    LISTED = Operation(  # no number: the entries before it, or the number of rows, and one more
        arguments=("before", "entry"),
        evaluate=_not_computed,
        partials=_no_partials,
        c="bgc_listed",
        lanes=Lanes.HEADER,
        smooth=False,
    )
    INVERTED = Operation(  # one entry of the inverse; its derivatives are in `derivatives.py`
        arguments=("matrix", "place"),
        evaluate=_not_computed,
        partials=_no_partials,
        c="bgc_invert",
        c_header="bgc_inverse.h",
        lanes=Lanes.HEADER,
        smooth=False,
    )


ROWS: tuple[Operation, ...] = tuple(op.row for op in Op)
"""`ROWS[op]` is the row of an operation, also given as a plain int."""
