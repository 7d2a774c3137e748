"""Bipartite matching of rows to columns by augmenting paths."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence


class Matching:
    """A matching of rows to columns, both numbered from 0."""

    def __init__(self, start: Mapping[int, int]) -> None:
        self.column_of = dict(start)
        self.row_of = {column: row for row, column in start.items()}

    def augment(self, root: int, candidates: Callable[[int], Iterable[int]]) -> bool:
        """Match a free row along a shortest augmenting path; False where there is none.

        `candidates` gives the columns that a row may be matched with, the first ones preferred.
        """
        came_from: dict[int, int] = {}  # column -> the row that reached it
        queue = [root]
        for row in queue:  # grows during the loop
            for column in candidates(row):
                if column in came_from:
                    continue
                came_from[column] = row
                if column not in self.row_of:
                    self._hand_over(column, came_from)
                    return True
                queue.append(self.row_of[column])
        return False

    def _hand_over(self, free: int, came_from: Mapping[int, int]) -> None:
        """Give each column of a path to the row that reached it, from its free end."""
        column: int | None = free
        while column is not None:
            row = came_from[column]
            previous = self.column_of.get(row)
            self.column_of[row], self.row_of[column] = column, row
            column = previous


def match(candidates: Sequence[Iterable[int]], start: Mapping[int, int]) -> dict[int, int]:
    """Find a largest matching of rows to columns, beginning with a given one; row -> column."""
    matching = Matching(start)
    for row in range(len(candidates)):
        if row not in matching.column_of:
            matching.augment(row, candidates.__getitem__)
    return matching.column_of
