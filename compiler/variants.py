"""What could stand in the slots of a scene instead: the variants that its file can see.

Nothing here knows what the models are. A model may stand in a slot if it is (by `is`) what the
slot asks for, and is visible where the scene is written; whether it can stand there as it is,
with no more arguments than the slot gives, shows when it is compiled.
"""

from __future__ import annotations

from dataclasses import dataclass

from bgc.elaboration.modules import Declared, Package, fitting_models
from bgc.grammar import syntax
from bgc.graph import FlatGraph, Slot


@dataclass(frozen=True, slots=True)
class Variant:
    """One slot filled otherwise: `use slot = type;`."""

    slot: str
    type: str

    @property
    def use(self) -> tuple[str, str]:
        """The pair that `Options.uses` takes."""
        return self.slot, self.type


def variants_of(package: Package, graph: FlatGraph) -> tuple[Variant, ...]:
    """All other models for each slot, slots as they are in the model, models by name."""
    models = package.root.models
    found: list[Variant] = []
    for slot in graph.slots:
        interface = models.get(slot.interface)
        if interface is None:
            continue
        for name in fitting_models(interface.syntax, models):
            text = _as_type(slot, models[name])
            if name != slot.filled_by and text is not None:
                found.append(Variant(slot.path, text))
    return tuple(found)


def _as_type(slot: Slot, model: Declared[syntax.Model]) -> str | None:
    """The model as a type with the slot's dimensions, or its own; None if they do not fit."""
    formals = model.syntax.formals
    if slot.dims and len(formals) == len(slot.dims):
        return f"{model.syntax.name}[{', '.join(map(str, slot.dims))}]"
    return model.syntax.name if all(f.default is not None for f in formals) else None
