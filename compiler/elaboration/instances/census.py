"""A lower bound on the parts of a model, found without making them.

A model that doubles at each level is refused at once, not after its first 200,000 parts.
"""

from __future__ import annotations

from bgc.elaboration.instances.limits import MAX_DEPTH, MAX_TURNS
from bgc.grammar import syntax
from bgc.resolution.modules import Declared, Module, ancestors


class Census:
    """Counts the parts that each use of a model makes at least; each model is counted once."""

    def __init__(self) -> None:
        self._counts: dict[int, int] = {}

    def least_parts(self, model: Declared[syntax.Model], depth: int = 0) -> int:
        """Count the parts that do not depend on values: no slots, no conditions but both branches.

        A model that contains itself, or is nested too deeply, counts as empty: the passes that
        follow refuse it.
        """
        key = id(model.syntax)
        if key not in self._counts:
            self._counts[key] = 0  # while it is open
            if depth <= MAX_DEPTH:
                self._counts[key] = sum(
                    self._items(each.syntax.items, each.module, depth) for each in ancestors(model)
                )
        return self._counts[key]

    def _items(
        self, items: tuple[syntax.Item, ...], module: Module, depth: int, turns: bool = False
    ) -> int:
        """Count the parts of items; in `for`, where `turns` is set, an index makes one part."""
        return sum(self._item(item, module, depth, turns) for item in items)

    def _item(self, item: syntax.Item, module: Module, depth: int, turns: bool) -> int:
        match item:
            case syntax.Part(default=None) if turns or not item.index:
                inside = module.models.get(item.type.name)
                if inside is not None and inside.syntax.interface:
                    return 0  # a slot
                return 1 + (self.least_parts(inside, depth + 1) if inside is not None else 0)
            case syntax.For(first=syntax.Number(value=low), last=syntax.Number(value=high)):
                first, last = int(low), int(high)
                if max(abs(first), abs(last)) > MAX_TURNS:
                    return 0  # refused with an error of its own
                count = last - first + 1
                return max(count, 0) * self._items(item.items, module, depth, turns=True)
            case syntax.If():
                branches = (item.yes, item.no)
                return min(self._items(branch, module, depth, turns) for branch in branches)
            case _:
                return 0
