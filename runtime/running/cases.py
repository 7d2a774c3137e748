"""The parameter sets of many runs as one array."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias, TypeGuard

import numpy as np

from bgc.diagnostics.catalogue.ensembles import no_instances, uneven_values
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.parameters import Parameters, ParameterValue

Sets: TypeAlias = Mapping[str, ParameterValue] | Sequence[Mapping[str, ParameterValue]]
"""Values by parameter, one for each instance; or a set of parameters for each instance."""


def parameter_sets(given: Sets) -> Iterator[Mapping[str, ParameterValue]]:
    """Make one mapping for each instance; in a mapping of lists, other values are for all.

    Raises BgError: BG740 if lists differ in length, BG741 if there is no instance.
    """
    if not isinstance(given, Mapping):
        if not len(given):
            raise BgError([no_instances()])
        return iter(given)
    lists = {name: value for name, value in given.items() if _is_list(value)}
    shared = {name: value for name, value in given.items() if name not in lists}
    first = next(iter(lists), "")
    count = len(lists[first]) if lists else 1
    for name, values in lists.items():
        if len(values) != count:
            raise BgError([uneven_values(name, len(values), first, count)])
    if not count:
        raise BgError([no_instances()])
    return ({**shared, **{name: values[k] for name, values in lists.items()}} for k in range(count))


def count_sets(given: Sets) -> int:
    """Count the instances of parameter sets."""
    if not isinstance(given, Mapping):
        return len(given)
    return next((len(value) for value in given.values() if _is_list(value)), 1)


def _is_list(value: ParameterValue) -> TypeGuard[Sequence[ParameterValue]]:
    return not isinstance(value, str) and np.ndim(np.asarray(value, dtype=object)) > 0


@dataclass(frozen=True, slots=True)
class Cases(Sequence[Mapping[str, float]]):
    """Values of parameters, SI, (n, names); NaN where a case leaves a parameter as it is.

    An array of 1e5 cases of three parameters takes 2.4 MB, and as many mappings 60 MB.
    """

    names: tuple[str, ...]
    values: Array

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, number: int) -> dict[str, float]:  # type: ignore[override]
        row = self.values[number].tolist()
        return {name: v for name, v in zip(self.names, row, strict=True) if v == v}

    def part(self, numbers: slice) -> Cases:
        """Some of the cases."""
        return Cases(self.names, self.values[numbers])

    def varied(self, preset: Mapping[str, float]) -> list[str]:
        """Names with different values, and those that the model itself has not set."""
        return [
            name
            for name, column in zip(self.names, self.values.T, strict=True)
            if name not in preset or not (column == column[0]).all()
        ]


def checked_cases(given: Sets, parameters: Parameters) -> Cases:
    """Check all sets, with the values set in the model; BG060 to BG063 for a bad value."""
    names: dict[str, int] = {}
    numbers, places = array("d"), array("q")
    count = 0
    for each in parameter_sets(given):
        for name, value in parameters.given(each).items():
            places.extend((count, names.setdefault(name, len(names))))
            numbers.append(value)
        count += 1
    values = np.full((count, len(names)), np.nan)
    at = np.array(places, dtype=np.int64).reshape(-1, 2)
    values[at[:, 0], at[:, 1]] = np.array(numbers)
    return Cases(tuple(names), values)
