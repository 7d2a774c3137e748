"""Changes of a scene, and the alternative models for its slots.

A model is an alternative for a slot if it has the slot's interface (by `is`) and is visible in the
file of the scene. Compiling the changed scene shows if the model needs further arguments.
"""

from __future__ import annotations

from collections.abc import Iterable

from bgc.elaboration.instances.fills import takes
from bgc.grammar import syntax
from bgc.ir.graph import FlatGraph, Slot
from bgc.options import Options
from bgc.record_class import dataclass, replace
from bgc.resolution.modules import Declared, Package, fitting_models


@dataclass(frozen=True, slots=True)
class Change:
    """A statement added to a scene: `use name = value;`, or with `is_use` False `set ..`."""

    name: str
    value: str
    is_use: bool = True

    @property
    def statement(self) -> str:
        """The text of the statement."""
        return f"{'use' if self.is_use else 'set'} {self.name} = {self.value};"

    def excludes(self, other: Change) -> bool:
        """Return whether both changes have one target, or one fills a slot around the other."""
        return (
            self.name == other.name
            or (self.is_use and other.name.startswith(f"{self.name}."))
            or (other.is_use and self.name.startswith(f"{other.name}."))
        )


def with_changes(options: Options, changes: Iterable[Change]) -> Options:
    """The options with the changes added."""
    made = tuple(changes)
    uses = tuple((change.name, change.value) for change in made if change.is_use)
    sets = tuple((change.name, change.value) for change in made if not change.is_use)
    return replace(options, uses=(*options.uses, *uses), overrides=(*options.overrides, *sets))


def variants_of(package: Package, graph: FlatGraph) -> tuple[Change, ...]:
    """All alternative models for each slot: slots in order of the model, models by name."""
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
    """The model as a type with the slot's dimensions or its defaults; None if neither fits.

    It keeps the arguments of the slot's present model that it takes itself.
    """
    formals, name = model.syntax.formals, model.syntax.name
    kept = "(..)" if any(takes(model, each) for each in slot.given) else ""
    more = formals[len(slot.dims) :]
    if slot.dims and len(formals) >= len(slot.dims) and all(f.default is not None for f in more):
        return f"{name}[{', '.join(map(str, slot.dims))}]{kept}"
    if formals and not slot.dims:
        kept = "(..)"  # its dimensions
    return f"{name}{kept}" if all(f.default is not None for f in formals) else None
