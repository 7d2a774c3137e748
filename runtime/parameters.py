"""The run-time parameters of a model: read, and set without compiling again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from bgc.grammar.catalogue.machine import parameter_out_of_range, unknown_parameter
from bgc.grammar.diagnostics import BgError
from bgc.runtime.binding import Instance, Library, text
from bgc.runtime.failures import require
from bgc.runtime.quantity import read_quantity

Quantity: TypeAlias = float | str
"""An SI number, or a text with a unit: `"7 t"`."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter: its present value in `unit` (SI), its default and its range."""

    name: str
    unit: str
    value: float
    default: float
    low: float
    high: float


class Parameters(Mapping[str, Parameter]):
    """A model's parameters by name.

    `parameters["boom.mass"] = 7e3` or `= "7 t"` sets one for all later runs, and what follows
    from it follows; `del parameters["boom.mass"]` puts it back to its default.
    """

    def __init__(self, library: Library) -> None:
        self._library = library
        model = library.model
        self._index = {text(model.param[k].name): k for k in range(model.n_param)}
        self._given: dict[str, float] = {}

    def __getitem__(self, name: str) -> Parameter:
        index = self._find(name)
        instance = self.instance({})
        require(instance, instance.reset())
        info = self._library.model.param[index]
        value, low, high = instance.parameter(index), info.low, info.high
        return Parameter(name, text(info.unit), value, info.value, low, high)

    def __setitem__(self, name: str, value: Quantity) -> None:
        self._given[name] = self._checked(name, value)

    def __delitem__(self, name: str) -> None:
        self._find(name)
        self._given.pop(name, None)

    def __iter__(self) -> Iterator[str]:
        return iter(self._index)

    def __len__(self) -> int:
        return len(self._index)

    def __contains__(self, name: object) -> bool:
        return name in self._index

    def __repr__(self) -> str:
        lines = (f"  {p.name} = {p.value:g} {p.unit}".rstrip() for p in self.values())
        return "\n".join(("parameters:", *lines))

    def instance(self, changes: Mapping[str, Quantity]) -> Instance:
        """Make an instance with these parameters, and `changes` to them, not yet reset."""
        given = self._given | {name: self._checked(name, v) for name, v in changes.items()}
        instance = Instance(self._library)
        for name, value in given.items():
            instance.set_parameter(self._index[name], value)
        return instance

    def _find(self, name: str) -> int:
        if (index := self._index.get(name)) is None:
            raise BgError([unknown_parameter(name, self._index)])
        return index

    def _checked(self, name: str, value: Quantity) -> float:
        info = self._library.model.param[self._find(name)]
        unit = text(info.unit)
        number = read_quantity(value, name, unit) if isinstance(value, str) else float(value)
        if not info.low <= number <= info.high:
            raise BgError([parameter_out_of_range(name, number, unit, info.low, info.high)])
        return number
