"""The run-time parameters of a model, set without compiling again."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from numbers import Real
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bgc.diagnostics.catalogue.arguments import (
    not_a_quantity,
    parameter_folded,
    parameter_out_of_range,
    unknown_parameter,
    wrong_shape,
)
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.public import public_class
from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.runtime.running.binding import Instance, Library, text
from bgc.runtime.running.quantity import read_quantity
from bgc.values.shown_units import Shown

ParameterValue: TypeAlias = float | str | Sequence[Any] | NDArray[Any]
"""An SI number, a text with a unit (`"7 t"`), or a vector or matrix of these."""

NOTHING: Mapping[str, Any] = MappingProxyType({})
"""No parameters, where a function takes some by name."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter: its present value in `unit` (SI), its default and its range.

    `shown` is the unit in which it is shown, as it was written.
    """

    name: str
    unit: str
    value: float
    default: float
    low: float
    high: float
    shown: Shown

    def __repr__(self) -> str:
        return f"<parameter {self.name} = {self.shown.text(self.value)}>"


@public_class
class Parameters(Mapping[str, Parameter]):
    """A model's parameters by name.

    `parameters["boom.mass"] = 7e3` or `= "7 t"` sets a value for all later runs; parameters whose
    defaults are computed from it change too. `del parameters["boom.mass"]` restores the default.
    A vector has components `axis[1]`, `axis[2]`, ..; `parameters["axis"] = [0, 0, 1]` sets them
    all. `folded` has the values of parameters that were compiled in and can no longer be set.
    """

    def __init__(
        self,
        library: Library,
        folded: Iterable[tuple[str, float]] = (),
        shown: Mapping[str, Shown] = NOTHING,
    ) -> None:
        """Read the parameters of a library; `folded` were compiled in, `shown` are their units."""
        self._library = library
        self._shown = shown
        self.folded = dict(folded)
        model = library.model
        self._index = {text(model.param[k].name): k for k in range(model.n_param)}
        self._given: dict[str, float] = {}

    def __getitem__(self, name: str) -> Parameter:
        return self._describe(self._find(name), self.instance({}))

    def __setitem__(self, name: str, value: ParameterValue) -> None:
        self._given.update(self.checked(name, value))

    def __delitem__(self, name: str) -> None:
        for component in self._components(name) or (name,):
            self._find(component)
            self._given.pop(component, None)

    def __iter__(self) -> Iterator[str]:
        return iter(self._index)

    def __len__(self) -> int:
        return len(self._index)

    def __contains__(self, name: object) -> bool:
        return name in self._index

    def __repr__(self) -> str:
        instance = self.instance({})
        found = (self._describe(index, instance) for index in self._index.values())
        lines = (f"  {p.name} = {p.shown.text(p.value)}" for p in found)
        compiled_in = [f"compiled in, see `folded`: {len(self.folded)}"] if self.folded else []
        return "\n".join(("parameters:", *lines, *compiled_in))

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._index)

    def _repr_html_(self) -> str:
        # Only a notebook needs it.
        from bgc.runtime.results.html import table_html

        instance = self.instance({})
        found = [self._describe(index, instance) for index in self._index.values()]
        rows = tuple((p.name, p.shown.text(p.value), p.shown.text(p.default)) for p in found)
        note = f"{len(self.folded)} compiled in, see `folded`" if self.folded else ""
        return table_html(Table("parameters", ("name", "value", "default"), rows, note))

    def unit_of(self, name: str) -> str:
        """The SI unit of a parameter; BG060 for an unknown name."""
        return self[name].unit

    def take(self, others: Parameters, *, but: Collection[str] = ()) -> None:
        """Set what is set in `others` and exists here; the names in `but` keep their values."""
        for name, value in others.given({}).items():
            if name in self._index and name not in but:
                self[name] = value

    def can_set(self, name: str, value: ParameterValue) -> bool:
        """Return whether a value can be set: a parameter of that name, or a vector for a vector."""
        if name in self._index:
            return True
        return (
            bool(self._components(name))
            and not self._folded_components(name)
            and not isinstance(value, str)
        )

    def instance(self, changes: Mapping[str, ParameterValue]) -> Instance:
        """Make an instance with these parameters and `changes`; it is not reset yet."""
        instance = Instance(self._library)
        for name, number in self.given(changes).items():
            instance.set_parameter(self._index[name], number)
        return instance

    def set_in(self, instance: Instance, changes: Mapping[str, ParameterValue]) -> None:
        """Set values in a running instance alone; they take effect at its next reset."""
        for name, value in changes.items():
            for component, number in self.checked(name, value).items():
                instance.set_parameter(self._find(component), number)

    def values_in(self, instance: Instance) -> list[float]:
        """The values of all parameters in an instance, SI, in their order."""
        return [instance.parameter(index) for index in self._index.values()]

    def all_in(self, instance: Instance) -> list[Parameter]:
        """All parameters with their values in an instance."""
        return [self._describe(index, instance) for index in self._index.values()]

    def turned_negative(self, instance: Instance, name: str) -> float | None:
        """Return the value of a parameter if it is negative and its default is not, else None."""
        index = self._index.get(name)
        if index is None or (value := instance.parameter(index)) >= 0:
            return None
        return value if self._library.model.param[index].value >= 0 else None

    def default_of(self, name: str) -> float:
        """The default of a scalar parameter of the compiled model, SI; 0 where it has none."""
        index = self._index.get(name)
        return 0.0 if index is None else float(self._library.model.param[index].value)

    def given(self, changes: Mapping[str, ParameterValue]) -> dict[str, float]:
        """Return the values that were set, with `changes`, SI, by the names of scalars."""
        values = dict(self._given)
        for name, value in changes.items():
            values.update(self.checked(name, value))
        return values

    def _find(self, name: str) -> int:
        if (index := self._index.get(name)) is not None:
            return index
        for known, value in self.folded.items():
            if known == name or known.startswith(f"{name}["):
                raise BgError([parameter_folded(known, value)])
        raise BgError([unknown_parameter(name, self._index)])

    def _components(self, name: str) -> list[str]:
        """List the components of a vector or matrix in order; empty for a scalar."""
        return [known for known in self._index if known.startswith(f"{name}[")]

    def _folded_components(self, name: str) -> list[str]:
        return [known for known in self.folded if known.startswith(f"{name}[")]

    def _describe(self, index: int, instance: Instance) -> Parameter:
        info = self._library.model.param[index]
        value = instance.parameter(index)
        name, unit = text(info.name), text(info.unit)
        shown = self.shown(name, unit)
        return Parameter(name, unit, value, info.value, info.low, info.high, shown)

    def shown(self, name: str, unit: str) -> Shown:
        """The unit in which a parameter is shown: as written, else its SI unit."""
        return self._shown.get(name) or Shown(unit)

    def checked(self, name: str, value: ParameterValue) -> dict[str, float]:
        """Check a value; return SI values by the names of parameters or components."""
        if isinstance(value, (int, float, str)) or np.ndim(value) == 0:
            return {name: self._number(name, value)}
        known = {*self._components(name), *self._folded_components(name)}
        if not known:
            self._find(name)
        array = np.asarray(value, dtype=object)
        keys = [",".join(str(k + 1) for k in place) for place in np.ndindex(array.shape)]
        components = [f"{name}[{key}]" for key in keys]
        if known != set(components):
            raise BgError([wrong_shape(name, array.shape, len(known))])
        pairs = zip(components, array.flat, strict=True)
        return {
            component: self._number(component, item)
            for component, item in pairs
            if component not in self.folded or item != self.folded[component]
        }

    def _number(self, name: str, value: Any) -> float:
        info = self._library.model.param[self._find(name)]
        unit = text(info.unit)
        if not isinstance(value, str | Real | np.bool_):
            raise BgError([not_a_quantity(name, type(value).__name__, unit)])
        number = read_quantity(value, name, unit) if isinstance(value, str) else float(value)
        if not info.low <= number <= info.high:
            shown = self.shown(name, unit)
            value, low, high = map(shown.number, (number, info.low, info.high))
            raise BgError([parameter_out_of_range(name, shown.label, value, low, high)])
        return number
