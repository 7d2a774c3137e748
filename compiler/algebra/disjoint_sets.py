"""Disjoint sets (union-find with path halving), of numbers and of objects."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from itertools import pairwise
from typing import Self

from bgc.record_class import dataclass, field


class DisjointSets:
    """A partition of the numbers from 0 to `size` - 1, at first into sets of one."""

    def __init__(self, size: int) -> None:
        self._parent = list(range(size))

    def find(self, item: int) -> int:
        """The representative of an item's set: its smallest member."""
        parent = self._parent
        while parent[item] != item:
            parent[item] = parent[parent[item]]
            item = parent[item]
        return item

    def unite(self, a: int, b: int) -> bool:
        """Unite the sets of two items; False if they were one already."""
        a, b = self.find(a), self.find(b)
        if a == b:
            return False
        self._parent[max(a, b)] = min(a, b)
        return True

    def join(self, items: Iterable[int]) -> None:
        """Unite the sets of several items."""
        for first, second in pairwise(items):
            self.unite(first, second)

    def groups(self, items: Iterable[int] | None = None) -> list[list[int]]:
        """The sets, restricted to some items (by default all), in the order of the items."""
        found: dict[int, list[int]] = {}
        for item in range(len(self._parent)) if items is None else items:
            found.setdefault(self.find(item), []).append(item)
        return list(found.values())


def groups_sharing(rows: Sequence[Iterable[Hashable]]) -> list[list[int]]:
    """The numbers of rows in groups that share no column with each other."""
    sets, first = DisjointSets(len(rows)), dict[Hashable, int]()
    for i, row in enumerate(rows):
        for column in row:
            sets.unite(first.setdefault(column, i), i)
    return sets.groups()


@dataclass(slots=True, eq=False)
class Joined:
    """Base class of objects that are joined into sets; the root of a set stands for all of it."""

    _parent: Self | None = field(default=None, init=False, repr=False)

    def root(self) -> Self:
        """The object that stands for all that are joined with this one."""
        item = self
        while item._parent is not None:
            if item._parent._parent is not None:
                item._parent = item._parent._parent
            item = item._parent
        return item

    def absorb(self, other: Self) -> None:
        """Join another set with this one; both objects are roots, and this one stays root."""
        assert self._parent is None and other._parent is None and other is not self
        other._parent = self
