"""How far a run is from the reference, in what the scene observes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded import Variable

_HARDLY_MOVES = 1e-6  # of the largest quantity of its unit
_COMPONENT = re.compile(r"\[[^\]]*\]$")


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity whose error is measured.

    `scale` is what errors are divided by: the accuracy that is asked for where `required`, else
    the range of the quantity. `decides` says that the combined error counts it.
    """

    name: str
    unit: str
    scale: float
    required: bool
    decides: bool


def quantities_of(
    variables: Sequence[Variable], reference: Array, requirements: Mapping[str, float]
) -> tuple[Quantity, ...]:
    """The scales of all outputs, from a solution (n, m) and what is required.

    Components of a vector share the widest range among them. What hardly moves is measured
    against a millionth of the largest quantity of its unit, so that noise is not divided by noise;
    what is zero all along, against 1 in its unit. Where something is required, that alone decides.
    """
    ranges = np.ptp(reference, axis=0)
    sizes = np.max(np.abs(reference), axis=0)
    scales = []
    for k, variable in enumerate(variables):
        vector = vector_of(variable.name)
        alike = [
            i for i, v in enumerate(variables) if i == k or (vector and vector_of(v.name) == vector)
        ]
        of_unit = [i for i, v in enumerate(variables) if v.unit == variable.unit]
        least = _HARDLY_MOVES * max(sizes[i] for i in of_unit)
        scales.append(float(max(least, *(ranges[i] for i in alike))) or 1.0)
    return tuple(
        Quantity(
            v.name,
            v.unit,
            requirements.get(v.name, scale),
            required=v.name in requirements,
            decides=not requirements or v.name in requirements,
        )
        for v, scale in zip(variables, scales, strict=True)
    )


def vector_of(name: str) -> str:
    """The vector that a component belongs to; empty for a scalar."""
    return name[: found.start()] if (found := _COMPONENT.search(name)) else ""


def largest_errors(rows: Array, reference: Array) -> tuple[float, ...]:
    """The largest absolute difference of each column over the run, in its unit."""
    return tuple(np.max(np.abs(rows - reference), axis=0).tolist())


def worst_of(errors: Sequence[float], quantities: Sequence[Quantity]) -> tuple[Quantity, float]:
    """Of the quantities that decide, the one with the largest error over its scale; its error."""
    pairs = [(q, e) for q, e in zip(quantities, errors, strict=True) if q.decides]
    return max(pairs, key=lambda pair: pair[1] / pair[0].scale)


def combined(errors: Sequence[float], quantities: Sequence[Quantity]) -> float:
    """The worst error of those that decide, over its scale."""
    quantity, error = worst_of(errors, quantities)
    return error / quantity.scale
