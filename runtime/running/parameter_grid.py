"""Values of parameters for `bgc sweep`, and the points of a grid or a sample of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.ensembles import bad_range, too_many_instances, varied_twice
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.quantity import read_quantity

DESIGNS = ("latin", "sobol", "saltelli")

_DEFAULT_VALUES = 10  # default number of values of a range
_MOST_INSTANCES = 1_000_000  # instances of a sweep
_MOST_DIGITS = 18  # of a count that a message shows; Python refuses to read 4,301


@dataclass(frozen=True, slots=True)
class Range:
    """A parameter from one SI value to another, both included, in `count` values; 0 for ten.

    With `log`, equal steps are equal ratios.
    """

    name: str
    low: float
    high: float
    count: int = 0
    log: bool = False

    def values(self) -> Array:
        """Equally spaced values."""
        spaced = np.geomspace if self.log else np.linspace
        return spaced(self.low, self.high, self.count or _DEFAULT_VALUES)

    def at(self, u: Array) -> Array:
        """Values at numbers from 0 to 1."""
        if self.log:
            return np.asarray(self.low * (self.high / self.low) ** u)
        return self.low + (self.high - self.low) * u

    def slope(self, value: float) -> float:
        """The derivative of `at` where it has a value."""
        length = self.high - self.low
        return float(value * np.log(self.high / self.low)) if self.log else length


@dataclass(frozen=True, slots=True)
class Listed:
    """A parameter with given SI values; a sample takes each with the same probability."""

    name: str
    numbers: tuple[float, ...]

    def values(self) -> Array:
        """The values."""
        return np.array(self.numbers)

    def at(self, u: Array) -> Array:
        """Values at numbers from 0 to 1."""
        places = np.minimum((u * len(self.numbers)).astype(int), len(self.numbers) - 1)
        return np.asarray(self.values()[places])


Axis: TypeAlias = Range | Listed
"""The values of one parameter."""


def read_axis(
    text: str,
    unit_of: Callable[[str], str],
    refused: Callable[[str, str], Diagnostic] = bad_range,
) -> Axis:
    """Read a range `name=low..high unit:count log`, or a list `name=1, 2, 5 kg`, also of one value.

    The unit, the count and `log` are optional. A unit behind the last value is for all that have
    none. `unit_of` gives the SI unit of a name, `refused` the error for another form and a reason.

    Raises BgError: `refused`, BG745 for too large a count, and the errors of a wrong name or unit.
    """
    name, equals, rest = (part.strip() for part in text.partition("="))
    is_range = ":" in rest or ".." in rest
    log = is_range and rest.endswith(" log")
    span, colon, count = (part.strip() for part in rest.removesuffix(" log" * log).partition(":"))
    parts = [part.strip() for part in (span.split("..", 1) if is_range else span.split(","))]
    counted = not colon or (count.isdecimal() and count.strip("0") != "")
    if not (name and equals and all(parts) and counted and len(parts) > is_range):
        raise BgError([refused(text, "")])
    _, _, unit = parts[-1].partition(" ")
    texts = (part if " " in part else f"{part} {unit}".strip() for part in parts)
    si = unit_of(name)
    numbers = tuple(read_quantity(each, name, si) for each in texts)
    if not is_range:
        return Listed(name, numbers)
    low, high = numbers
    if log and not (low > 0 and high > 0):
        raise BgError([refused(text, "a logarithmic range begins and ends above 0")])
    if len(count) > _MOST_DIGITS or int(count or 0) > _MOST_INSTANCES:
        raise BgError([too_many_instances(int(count[:_MOST_DIGITS]), _MOST_INSTANCES)])
    return Range(name, low, high, int(count or 0), log)


def points(
    axes: Sequence[Axis],
    sample: int | None,
    design: str = "latin",
    seed: int = 0,
    cases: Mapping[str, Array] | None = None,
) -> dict[str, Array]:
    """Compute the values of all instances: every combination, or a sample of so many points.

    `cases` are given points, each of which is combined with all combinations of the axes. A
    sample of the design `saltelli` has `sample` base points, rounded up to a power of two, and
    base points times (parameters + 2) instances.

    Raises BgError: BG744 if a parameter is varied twice, BG745 if there are too many instances,
    BG066 for an unknown design or a sample of cases.
    """
    cases = cases or {}
    names = [*cases, *(each.name for each in axes)]
    for name in names:
        if names.count(name) > 1:
            raise BgError([varied_twice(name)])
    if sample is not None and seed < 0:
        raise BgError([bad_option("seed", seed, "a whole number of 0 or more", "1")])
    if design not in DESIGNS:
        raise BgError([bad_option("design", design, f"one of {', '.join(DESIGNS)}", "sobol")])
    given = len(next(iter(cases.values()))) if cases else 1
    if sample is not None and cases:
        raise BgError([bad_option("sample", sample, "left out where the cases are given", "")])
    count = given * math.prod(len(each.values()) for each in axes)
    if sample is not None:
        count = sample * (len(axes) + 2) if design == "saltelli" else sample
    if count > _MOST_INSTANCES:
        raise BgError([too_many_instances(count, _MOST_INSTANCES)])
    if sample is None:
        return grid(axes, cases)
    if design == "latin":
        return latin_hypercube(axes, sample, seed)
    return (saltelli if design == "saltelli" else sobol)(axes, sample, seed)


def grid(axes: Sequence[Axis], cases: Mapping[str, Array] | None = None) -> dict[str, Array]:
    """Combine all values of the axes: one value for each instance, by parameter.

    Each of the `cases` is combined with all of them.
    """
    count = len(next(iter(cases.values()))) if cases else 1
    lists = [np.arange(count), *(each.values() for each in axes)]
    places, *found = (each.ravel() for each in np.meshgrid(*lists, indexing="ij"))
    given = {name: np.asarray(values)[places] for name, values in (cases or {}).items()}
    return {**given, **{each.name: p for each, p in zip(axes, found, strict=True)}}


def latin_hypercube(axes: Sequence[Axis], count: int, seed: int = 0) -> dict[str, Array]:
    """Spread `count` points over the axes by Latin hypercube sampling.

    M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979).
    """
    # Slow to load, and a grid does without it.
    from scipy.stats import qmc

    return _placed(axes, qmc.LatinHypercube(d=len(axes), seed=seed).random(count))


def sobol(axes: Sequence[Axis], count: int, seed: int = 0) -> dict[str, Array]:
    """Take `count` points of Sobol's sequence with Owen's scrambling.

    Its balance needs a power of two points: A. B. Owen, "On dropping the first Sobol' point", 2020.
    """
    return _placed(axes, _sobol_points(len(axes), count, seed))


def saltelli(axes: Sequence[Axis], count: int, seed: int = 0) -> dict[str, Array]:
    """Make the sample for Sobol indices: A, B, and A with one column of B for each parameter.

    `count` is rounded up to a power of two. A. Saltelli et al., Computer Physics Communications
    181 (2010) 259-270.
    """
    count = 1 << max(count - 1, 0).bit_length()
    both = _sobol_points(2 * len(axes), count, seed)
    a, b = both[:, : len(axes)], both[:, len(axes) :]
    mixed = (np.where(np.arange(len(axes)) == k, b, a) for k in range(len(axes)))
    return _placed(axes, np.concatenate((a, b, *mixed)))


def _placed(axes: Sequence[Axis], points: Array) -> dict[str, Array]:
    """The values of the axes at points of the unit cube, (n, axes)."""
    return {each.name: each.at(points[:, k]) for k, each in enumerate(axes)}


def _sobol_points(dimensions: int, count: int, seed: int) -> Array:
    # Slow to load, and a grid does without it.
    from scipy.stats import qmc

    power = max(count - 1, 0).bit_length()
    points: Array = qmc.Sobol(d=dimensions, scramble=True, seed=seed).random_base2(power)
    return points[:count]
