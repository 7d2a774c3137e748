"""Ranges of parameters for `bgc sweep`, and the points of a grid or a sample of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bgc.diagnostics.catalogue.ensembles import bad_range, too_many_instances, varied_twice
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.parameters import Parameters
from bgc.runtime.running.quantity import read_quantity

_COUNT = 10  # default number of values of a range
_MOST = 1_000_000  # instances of a sweep


@dataclass(frozen=True, slots=True)
class Range:
    """A parameter from one SI value to another, both included, in `count` values."""

    name: str
    low: float
    high: float
    count: int = _COUNT


def read_range(text: str, parameters: Parameters) -> Range:
    """Read `name=low..high unit:count`; the unit and the count are optional.

    A unit after `low` applies to `low` alone.

    Raises BgError: BG743 for another form, and the errors of a wrong name or unit.
    """
    name, equals, rest = (part.strip() for part in text.partition("="))
    span, colon, count = (part.strip() for part in rest.partition(":"))
    low, dots, high = (part.strip() for part in span.partition(".."))
    counted = not colon or (count.isdecimal() and int(count) > 0)
    if not (name and equals and low and dots and high and counted):
        raise BgError([bad_range(text)])
    _, _, unit = high.partition(" ")
    start = low if " " in low else f"{low} {unit}".strip()
    first, last = (read_quantity(value, name, parameters[name].unit) for value in (start, high))
    return Range(name, first, last, int(count) if colon else _COUNT)


def points(ranges: Sequence[Range], sample: int | None) -> dict[str, Array]:
    """Compute the values of all instances: every combination, or a sample of so many points.

    Raises BgError: BG744 if a parameter has two ranges, BG745 if there are too many instances.
    """
    names = [each.name for each in ranges]
    for name in names:
        if names.count(name) > 1:
            raise BgError([varied_twice(name)])
    count = sample or math.prod(each.count for each in ranges)
    if count > _MOST:
        raise BgError([too_many_instances(count, _MOST)])
    return grid(ranges) if sample is None else latin_hypercube(ranges, sample)


def grid(ranges: Sequence[Range]) -> dict[str, Array]:
    """Combine all values of the ranges: one value for each instance, by parameter."""
    axes = [np.linspace(each.low, each.high, each.count) for each in ranges]
    points = np.meshgrid(*axes, indexing="ij")
    return {each.name: p.ravel() for each, p in zip(ranges, points, strict=True)}


def latin_hypercube(ranges: Sequence[Range], count: int) -> dict[str, Array]:
    """Spread `count` points over the ranges by Latin hypercube sampling, with a fixed seed.

    M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979).
    """
    # Slow to load, and a grid does without it.
    from scipy.stats import qmc

    points = qmc.LatinHypercube(d=len(ranges), seed=0).random(count)
    return {
        each.name: each.low + (each.high - each.low) * points[:, k] for k, each in enumerate(ranges)
    }
