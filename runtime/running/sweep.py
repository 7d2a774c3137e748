"""Ranges of parameters, as `bgc sweep` takes them, and the sets of values they stand for."""

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

_COUNT = 10  # values of a range that does not say
_MOST = 1_000_000  # instances of a sweep


@dataclass(frozen=True, slots=True)
class Range:
    """A parameter from one SI value to another, both included, in `count` values."""

    name: str
    low: float
    high: float
    count: int = _COUNT


def read_range(text: str, parameters: Parameters) -> Range:
    """Read `name=low..high unit:count`, of which the unit and the count may be left out.

    A unit of its own is for `low` alone.

    Raises BgError: BG743 where it is no such thing, and what a wrong name or unit raises.
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
    """Values for each instance: every combination, or so many points among them.

    Raises BgError: BG744 where a parameter has two ranges, BG745 where there are too many.
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
    """All combinations of the ranges' values: one value for each instance, by parameter."""
    axes = [np.linspace(each.low, each.high, each.count) for each in ranges]
    points = np.meshgrid(*axes, indexing="ij")
    return {each.name: p.ravel() for each, p in zip(ranges, points, strict=True)}


def latin_hypercube(ranges: Sequence[Range], count: int) -> dict[str, Array]:
    """`count` points spread over the ranges, each of which is covered evenly.

    Latin hypercube sampling: M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979).
    The same points every time.
    """
    # Slow to load; a grid does without it.
    from scipy.stats import qmc

    points = qmc.LatinHypercube(d=len(ranges), seed=0).random(count)
    return {
        each.name: each.low + (each.high - each.low) * points[:, k] for k, each in enumerate(ranges)
    }
