"""Bipartite matching of rows to columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence


def match(candidates: Sequence[Iterable[int]], start: Mapping[int, int]) -> dict[int, int]:
    """A largest matching of rows to columns by augmenting paths, from a given one."""
    column_of = dict(start)
    row_of = {column: row for row, column in start.items()}
    for root in range(len(candidates)):
        if root in column_of:
            continue
        came_from: dict[int, int] = {}
        queue = [root]
        free = None
        for row in queue:  # grows while it is walked
            for column in candidates[row]:
                if column in came_from:
                    continue
                came_from[column] = row
                if column not in row_of:
                    free = column
                    break
                queue.append(row_of[column])
            if free is not None:
                break
        while free is not None:
            row = came_from[free]
            free_next = column_of.get(row)
            column_of[row], row_of[free] = free, row
            free = free_next
    return column_of
