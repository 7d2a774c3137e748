"""Scalar expressions of flat variables: values, derivatives, linear forms, Python text.

Leaves are numbers, `Time`, and `Var`. Everything is written here independently, so that the
reference shares no algebra with the compiler.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from curves import OPERATORS, function, is_curve
from program_tree import Apply, Expr, Num, Time, call, expr


@dataclass(frozen=True)
class Var(Expr):
    """A differential variable (`x`) or an algebraic one (`z`)."""

    kind: str
    index: int


ZERO, ONE = Num(Fraction(0)), Num(Fraction(1))
LITTLE = Num(Fraction(1, 10**30))  # for slopes where roots begin

# Functions of one argument: value, and derivative as an expression of the argument.
FUNCTIONS: dict[str, tuple[Callable[[float], float], Callable[[Expr], Expr]]] = {
    "sin": (math.sin, lambda u: call("cos", u)),
    "cos": (math.cos, lambda u: -call("sin", u)),
    "tanh": (math.tanh, lambda u: 1 - call("tanh", u) ** 2),
    "atan": (math.atan, lambda u: 1 / (1 + u * u)),
    "exp": (math.exp, lambda u: call("exp", u)),
    "expm1": (math.expm1, lambda u: call("exp", u)),
    "log1p": (math.log1p, lambda u: 1 / (1 + u)),
    "log": (math.log, lambda u: 1 / u),
    "sqrt": (math.sqrt, lambda u: 1 / (2 * call("sqrt", u + LITTLE))),
    "asinh": (math.asinh, lambda u: 1 / call("sqrt", 1 + u * u)),
    "sinh": (math.sinh, lambda u: call("cosh", u)),
    "cosh": (math.cosh, lambda u: call("sinh", u)),
    "erf": (math.erf, lambda u: call("exp", -(u * u)) * Num(Fraction(2 / math.sqrt(math.pi)))),
    "abs": (abs, lambda u: call("sign", u)),
    "sign": (lambda u: math.copysign(1.0, u) if u else 0.0, lambda u: ZERO),
    "cbrt": (math.cbrt, lambda u: 1 / (3 * call("cbrt", u) ** 2)),
}
COMPARISONS = ("<", ">", "<=", ">=")


def derivative(e: Expr, by: Expr) -> Expr:
    """The partial derivative; of a switched expression that of the branch that applies."""
    if e == by:
        return ONE
    match e:
        case Num() | Time() | Var():
            return ZERO
        case Apply(op="+" | "-" as op, args=(a, b)):
            return simple(op, derivative(a, by), derivative(b, by))
        case Apply(op="neg", args=(a,)):
            return simple("-", ZERO, derivative(a, by))
        case Apply(op="*", args=(a, b)):
            da, db = derivative(a, by), derivative(b, by)
            return simple("+", simple("*", da, b), simple("*", a, db))
        case Apply(op="/", args=(a, b)):
            da, db = derivative(a, by), derivative(b, by)
            above = simple("-", da, simple("*", e, db))
            return simple("/", above, b)
        case Apply(op="^", args=(a, Num(value=n))):
            power = ONE if n == 1 else a ** int(n - 1)
            return simple("*", simple("*", Num(n), power), derivative(a, by))
        case Apply(op="if", args=(c, a, b)):
            da, db = derivative(a, by), derivative(b, by)
            return ZERO if (da, db) == (ZERO, ZERO) else Apply("if", (c, da, db))
        case Apply(op="min" | "max" as op, args=(a, b)):
            da, db = derivative(a, by), derivative(b, by)
            if (da, db) == (ZERO, ZERO):
                return ZERO
            first = Apply("<" if op == "min" else ">", (a, b))
            return Apply("if", (first, da, db))
        case Apply(op=op, args=(xs, ys, u)) if is_curve(op):
            inner = derivative(u, by)
            slope = Apply(op.replace("interpolate", "slope"), (xs, ys, u))
            return ZERO if inner == ZERO else simple("*", slope, inner)
        case Apply(op=op, args=(a,)):
            inner = derivative(a, by)
            return ZERO if inner == ZERO else simple("*", FUNCTIONS[op][1](a), inner)
    raise AssertionError(e)


def simple(op: str, a: Expr, b: Expr) -> Expr:
    """`a op b` without zeros and ones."""
    if isinstance(a, Num) and isinstance(b, Num) and not (op == "/" and b.value == 0):
        value = {
            "+": lambda: a.value + b.value,
            "-": lambda: a.value - b.value,
            "*": lambda: a.value * b.value,
            "/": lambda: a.value / b.value,
        }[op]()
        return Num(value)
    if op == "+" and a == ZERO:
        return b
    if op in "+-" and b == ZERO:
        return a
    if op == "*" and ZERO in (a, b):
        return ZERO
    if op == "*" and a == ONE:
        return b
    if op in "*/" and b == ONE:
        return a
    if op == "/" and a == ZERO:
        return ZERO
    return Apply(op, (a, b))


def linear_form(e: Expr) -> tuple[dict[Var, float], float] | None:
    """Coefficients and constant of an expression that is linear in its variables, else None."""
    match e:
        case Num(value=value):
            return {}, float(value)
        case Var():
            return {e: 1.0}, 0.0
        case Apply(op="+" | "-" as op, args=(a, b)):
            left, right = linear_form(a), linear_form(b)
            if left is None or right is None:
                return None
            sign = 1 if op == "+" else -1
            total = dict(left[0])
            for var, c in right[0].items():
                total[var] = total.get(var, 0.0) + sign * c
            return total, left[1] + sign * right[1]
        case Apply(op="neg", args=(a,)):
            return linear_form(ZERO - a)
        case Apply(op="*", args=(a, b)):
            left, right = linear_form(a), linear_form(b)
            if left is None or right is None or (left[0] and right[0]):
                return None
            if not left[0]:
                left, right = right, left
            return {v: c * right[1] for v, c in left[0].items()}, left[1] * right[1]
        case Apply(op="/", args=(a, b)):
            left, right = linear_form(a), linear_form(b)
            if left is None or right is None or right[0]:
                return None
            return {v: c / right[1] for v, c in left[0].items()}, left[1] / right[1]
        case Apply(op=op) if is_curve(op):
            return None if variables(e) else ({}, evaluate(e, {}, 0.0))
        case Apply(op=op, args=args):
            forms = [linear_form(a) for a in args]
            if any(f is None or f[0] for f in forms):
                return None
            return {}, evaluate(e, {}, 0.0)
    return None


def python(e: Expr) -> str:
    """Python text of the expression, in lists `x` and `z` and the time `t`."""
    match e:
        case Num(value=value):
            return repr(float(value)) if value >= 0 else f"({float(value)!r})"
        case Time():
            return "t"
        case Var(kind=kind, index=index):
            return f"{kind}[{index}]"
        case Apply(op="neg", args=(a,)):
            return f"(-{python(a)})"
        case Apply(op="^", args=(a, b)):
            return f"{python(a)}**{python(b)}"
        case Apply(op="if", args=(c, a, b)):
            return f"({python(a)} if {python(c)} else {python(b)})"
        case Apply(op=op, args=(a, b)) if op in ("+", "-", "*", "/", *COMPARISONS):
            return f"({python(a)} {op} {python(b)})"
        case Apply(op="vector", args=args):
            return f"({', '.join(python(a) for a in args)},)"
        case Apply(op=op, args=args):
            return f"{op.replace(' ', '_')}({', '.join(python(a) for a in args)})"
    raise AssertionError(e)


NAMES: dict[str, object] = {name: pair[0] for name, pair in FUNCTIONS.items()}
NAMES |= {"min": min, "max": max} | {op.replace(" ", "_"): function(op) for op in OPERATORS}


def evaluate(e: Expr, values: dict[Var, float], t: float) -> float:
    x = {v.index: a for v, a in values.items() if v.kind == "x"}
    z = {v.index: a for v, a in values.items() if v.kind == "z"}
    return float(eval(python(e), dict(NAMES), {"x": x, "z": z, "t": t}))


def compiled(arguments: str, results: list[Expr]) -> Callable[..., list[float]]:
    """A function of lists that returns the values of all expressions."""
    body = ", ".join(python(e) for e in results)
    space = dict(NAMES)
    exec(f"def function({arguments}):\n    return [{body}]", space)
    return space["function"]  # type: ignore[return-value]


def variables(e: Expr) -> set[Expr]:
    if isinstance(e, Apply):
        return set().union(*(variables(a) for a in e.args))
    return {e} if isinstance(e, Var | Time) else set()


def number(value: Fraction | int) -> Num:
    return expr(value)  # type: ignore[return-value]
