"""Laws that a passive part may have, drawn at random with the units of their domain."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from program_tree import PLAIN, SECOND, Expr, Unit, call, choose, unit


@dataclass(frozen=True)
class Domain:
    """A kind of bond, with the sizes that its effort and flow have in a program."""

    name: str
    effort: Unit
    flow: Unit
    e0: Fraction
    f0: Fraction


_1 = Fraction(1)
DOMAINS = (
    Domain("translation", unit(N=1), unit(m=1, s=-1), _1, _1),
    Domain("rotation", unit(N=1, m=1), unit(rad=1, s=-1), _1, _1),
    Domain("electric", unit(V=1), unit(A=1), Fraction(10), Fraction(1, 10)),
    Domain("hydraulic", unit(Pa=1), unit(m=3, s=-1), Fraction(10**5), Fraction(1, 1000)),
)

# Draws a coefficient: a size and its unit to an expression of the model.
Coefficient: TypeAlias = Callable[[Fraction, Unit], Expr]


@dataclass(frozen=True)
class Quantity:
    """A variable of a law: its size in the program, and its unit."""

    size: Fraction
    unit: Unit


def variable(domain: Domain, name: str) -> Quantity:
    """The size and unit of e, f, q or p; times are of the size of a second."""
    return {
        "e": Quantity(domain.e0, domain.effort),
        "f": Quantity(domain.f0, domain.flow),
        "q": Quantity(domain.f0, domain.flow * SECOND),
        "p": Quantity(domain.e0, domain.effort * SECOND),
    }[name]


def nice(rng: random.Random, size: Fraction, low: float = 0.3, high: float = 3.0) -> Fraction:
    """A number of two digits near a size."""
    x = float(size) * math.exp(rng.uniform(math.log(low), math.log(high)))
    return two_digits(x)


def two_digits(x: float) -> Fraction:
    return Fraction(f"{x:.1e}")


def characteristic(
    rng: random.Random,
    coefficient: Coefficient,
    u: Expr,
    of: Quantity,
    to: Quantity,
    *,
    gentle: bool,
) -> Expr:
    """A function of u that grows with it and vanishes with it.

    With `gentle` its slope is bounded from below and above near zero, as storage needs it.
    """
    a = coefficient(to.size / of.size, to.unit / of.unit)
    kinds = ["linear", "cubic", "square", "tanh", "two", "soft", "asinh", "clamp", "sinh", "atan"]
    kinds += ["stops", "erf"]
    kinds += [] if gentle else ["orifice", "diode", "root"]
    kind = rng.choice(kinds)
    y = coefficient(to.size, to.unit)
    at = coefficient(of.size, of.unit)
    match kind:
        case "linear":
            return a * u
        case "cubic":
            return a * u + coefficient(to.size / of.size**3, to.unit / of.unit**3) * u**3
        case "square":
            b = coefficient(to.size / of.size**2, to.unit / of.unit**2)
            return a * u + b * call("abs", u) * u
        case "tanh":
            return y * call("tanh", u / at) + a * u
        case "two":
            b = coefficient(to.size / of.size, to.unit / of.unit)
            return choose(call(">", u, 0), a * u, b * u)
        case "soft":
            return a * u / call("sqrt", 1 + (u / at) ** 2) + a * u / 10
        case "asinh":
            return y * call("asinh", u / at)
        case "clamp":
            return y * call("min", call("max", u / at, -1), 1) + a * u
        case "sinh":
            return y * call("sinh", u / (2 * at))
        case "atan":
            return y * call("atan", u / at) + a * u
        case "stops":
            gap = call("max", u - at, 0 * at) + call("min", u + at, 0 * at)
            return a * (u / 2 + gap)
        case "erf":
            return y * call("erf", u / at) + a * u
        case "orifice":
            return y * call("sign", u) * call("sqrt", call("abs", u) / at)
        case "diode":
            return y * call("expm1", u / (2 * at)) + a * u / 10
        case _:
            return y * (u / at) / call("sqrt", 1 + call("abs", u / at))


def energy(
    rng: random.Random, coefficient: Coefficient, u: Expr, of: Quantity, to: Quantity
) -> Expr:
    """An energy of one variable whose slope grows with it; zero at zero but for a constant."""
    k = coefficient(to.size / of.size, to.unit / of.unit)
    y, at = coefficient(to.size, to.unit), coefficient(of.size, of.unit)
    match rng.randrange(5):
        case 0:
            return k / 2 * u**2
        case 1:
            k3 = coefficient(to.size / of.size**3, to.unit / of.unit**3)
            return k / 2 * u**2 + k3 / 4 * u**4
        case 2:
            return y * at * call("sqrt", 1 + (u / at) ** 2)
        case 3:
            return y * at * call("cosh", u / at)
        case _:
            return k / 2 * u * u + y * at * (1 - call("cos", u / at)) / 2


def signal_of_time(
    rng: random.Random, coefficient: Coefficient, to: Quantity, time: Expr, *, smooth: bool
) -> Expr:
    """A source's value over the time."""
    a = coefficient(to.size, to.unit)
    rate = coefficient(Fraction(2), unit(rad=1, s=-1))
    when = coefficient(Fraction(1), SECOND)
    match rng.randrange(4 if smooth else 7):
        case 0:
            return a
        case 1:
            return a * call("sin", rate * time)
        case 2:
            return a * call("exp", -time / when)
        case 3:
            return a * call("cos", rate * time) / 2 + a * call("tanh", time / when)
        case 4:
            return choose(call("<", time, when), a, 0 * a)
        case 5:
            return a * call("min", time / when, 1)
        case _:
            return a * call("max", call("sin", rate * time), 0)


def plain(size: Fraction) -> Quantity:
    return Quantity(size, PLAIN)
