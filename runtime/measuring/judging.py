"""Errors of runs against references: their scales, and what is acceptable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from bgc.diagnostics.catalogue.arguments import no_duration
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.column_names import vector_of
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded_model import LoadedModel, Variable
from bgc.values.shown_units import Shown

_SMALLEST_RANGE = 1e-6  # of the largest quantity of its unit


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity whose error is measured.

    Errors are divided by `scale`: the required accuracy where `required`, else the range of the
    quantity. Only quantities with `decides` count in the combined error. `written` is the unit in
    which tables show it, None for `unit`.
    """

    name: str
    unit: str
    scale: float
    required: bool
    decides: bool
    written: Shown | None = None

    @property
    def shown(self) -> Shown:
        """The unit in which its values and errors are shown."""
        return self.written or Shown(self.unit)


def quantities_of(
    variables: Sequence[Variable], reference: Array, requirements: Mapping[str, float]
) -> tuple[Quantity, ...]:
    """Compute the scales of all outputs from a solution (n, m) and the requirements.

    Components of a vector share the widest range among them. A range is at least a millionth of
    the largest quantity of the same unit, so that noise is not divided by noise; for a quantity
    that is always zero it is 1 in its unit. If anything is required, only required quantities
    decide.
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
        least = _SMALLEST_RANGE * max(sizes[i] for i in of_unit)
        scales.append(float(max(least, *(ranges[i] for i in alike))) or 1.0)
    return tuple(
        Quantity(
            v.name,
            v.unit,
            requirements.get(v.name, scale),
            required=v.name in requirements,
            decides=not requirements or v.name in requirements,
            written=v.written,
        )
        for v, scale in zip(variables, scales, strict=True)
    )


def worst_error(errors: Sequence[float], quantities: Sequence[Quantity]) -> tuple[Quantity, float]:
    """Find the deciding quantity with the largest error over its scale; return it and its error."""
    pairs = [(q, e) for q, e in zip(quantities, errors, strict=True) if q.decides]
    return max(pairs, key=lambda pair: pair[1] / pair[0].scale)


def combined(errors: Sequence[float], quantities: Sequence[Quantity]) -> float:
    """Compute the combined error: the largest of the deciding errors over their scales."""
    quantity, error = worst_error(errors, quantities)
    return error / quantity.scale


@dataclass(frozen=True, slots=True)
class Accuracy:
    """The acceptable error: the `requirements` of a scene, or else `within`, a part of the range.

    The error is that of the worst quantity, over its requirement or its range.
    """

    within: float
    requirements: tuple[tuple[str, float], ...] = ()

    @property
    def required(self) -> bool:
        """True if the scene has requirements."""
        return bool(self.requirements)

    @property
    def limit(self) -> float:
        """The largest acceptable error."""
        return 1.0 if self.required else self.within

    def quantities(self, model: LoadedModel, reference: Array) -> tuple[Quantity, ...]:
        """The observed quantities with the scales of their errors; `reference` is (n, m)."""
        return quantities_of(model.measured, reference, dict(self.requirements))


def duration_of(
    model: LoadedModel, duration: float | None, unobserved: Callable[[str], Diagnostic]
) -> float:
    """The time of the runs of a study, s: the given one, else that of the scene.

    Raises BgError where neither is known, and `unobserved` where the scene observes nothing.
    """
    end = model.facts.duration if duration is None else duration
    if end is None:
        raise BgError([no_duration(model.facts.name)])
    if not model.measured:
        raise BgError([unobserved(model.facts.name)])
    return end
