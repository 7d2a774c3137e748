"""Lines that make another scene of one, and what could stand in its slots instead.

Nothing here knows what the models are. A model may stand in a slot if it is (by `is`) what the
slot asks for, and is visible where the scene is written; whether it can stand there as it is,
with no more arguments than the slot gives, shows when it is compiled.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from bgc.grammar import syntax
from bgc.ir.graph import FlatGraph, Slot
from bgc.options import Options
from bgc.resolution.modules import Declared, Package, fitting_models


@dataclass(frozen=True, slots=True)
class Change:
    """One line of a scene: `use name = value;`, or `set name = value;` where it is no slot's."""

    name: str
    value: str
    is_use: bool = True

    @property
    def statement(self) -> str:
        """The line that a scene would say."""
        return f"{'use' if self.is_use else 'set'} {self.name} = {self.value};"

    def excludes(self, other: Change) -> bool:
        """Whether both cannot be made: of the same, or of what is in the slot that one fills."""
        return (
            self.name == other.name
            or (self.is_use and other.name.startswith(f"{self.name}."))
            or (other.is_use and self.name.startswith(f"{other.name}."))
        )


def with_changes(options: Options, changes: Iterable[Change]) -> Options:
    """The options with the changes made."""
    made = tuple(changes)
    uses = tuple((change.name, change.value) for change in made if change.is_use)
    sets = tuple((change.name, change.value) for change in made if not change.is_use)
    return replace(options, uses=(*options.uses, *uses), overrides=(*options.overrides, *sets))


def variants_of(package: Package, graph: FlatGraph) -> tuple[Change, ...]:
    """All other models for each slot, slots as they are in the model, models by name."""
    models = package.root.models
    found: list[Change] = []
    for slot in graph.slots:
        interface = models.get(slot.interface)
        if interface is None:
            continue
        for name in fitting_models(interface.syntax, models):
            text = _as_type(slot, models[name])
            if name != slot.filled_by and text is not None:
                found.append(Change(slot.path, text))
    return tuple(found)


def _as_type(slot: Slot, model: Declared[syntax.Model]) -> str | None:
    """The model as a type with the slot's dimensions, or its own; None if they do not fit."""
    formals = model.syntax.formals
    if slot.dims and len(formals) == len(slot.dims):
        return f"{model.syntax.name}[{', '.join(map(str, slot.dims))}]"
    return model.syntax.name if all(f.default is not None for f in formals) else None
