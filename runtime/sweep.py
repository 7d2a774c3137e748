"""Ranges of parameters, as `bgc sweep` takes them, and the sets of values they stand for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bgc.grammar.catalogue.ensembles import bad_range
from bgc.grammar.diagnostics import BgError
from bgc.runtime.binding import Array
from bgc.runtime.parameters import Parameters
from bgc.runtime.quantity import read_quantity

_COUNT = 10  # values of a range that does not say


@dataclass(frozen=True, slots=True)
class Range:
    """A parameter from one SI value to another, both included, in `count` values."""

    name: str
    low: float
    high: float
    count: int = _COUNT


def read_range(text: str, parameters: Parameters) -> Range:
    """Read `name=low..high unit:count`, of which the unit and the count may be left out.

    Raises BgError: BG743 where it is no such thing, and what a wrong name or unit raises.
    """
    name, equals, rest = (part.strip() for part in text.partition("="))
    span, colon, count = (part.strip() for part in rest.partition(":"))
    low, dots, high = (part.strip() for part in span.partition(".."))
    if not (name and equals and low and dots and high) or (colon and not count.isdecimal()):
        raise BgError([bad_range(text)])
    unit = " ".join(high.split()[1:])
    first, last = (
        read_quantity(f"{number} {unit}".strip(), name, parameters[name].unit)
        for number in (low, high.split()[0])
    )
    return Range(name, first, last, int(count) if colon else _COUNT)


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
    from scipy.stats import qmc

    points = qmc.LatinHypercube(d=len(ranges), seed=0).random(count)
    return {
        each.name: each.low + (each.high - each.low) * points[:, k] for k, each in enumerate(ranges)
    }
