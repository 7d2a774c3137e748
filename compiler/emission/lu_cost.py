"""Estimate the time that the factorisation of `W = c M - J` and its solutions take.

The unit is the nanosecond on the machine on which `tests/bench/factorisation.py` was run (AVX-512,
November 2026): only ratios count. That script prints estimates beside measured times; whoever
changes a kernel runs it and adapts the constants.
"""

from __future__ import annotations

from collections.abc import Sequence

from bgc.ir.lowered import LuPlan

SOLUTIONS = 8  # of one factorisation, as a step of the default method `rodas5p` has them

# Unrolled code: an operation; 0.105 of a small model, 0.18 of a large one.
_UNROLLED = 0.13
# Loops over tables: an operation and an entry of a factorisation, an entry of a solution.
_BY_TABLE, _ENTRY_BY_TABLE, _SOLVED_BY_TABLE = 0.34, 1.8, 0.62
# Blocks, a factorisation: a block, a row, an entry of W; a column left of a block, and right of it,
# as it is stored; a column that another block changes, for each row of that block. A solution: a
# block, a row, a column.
_BLOCK, _ROW, _ENTRY, _LEFT, _RIGHT, _CHANGED = 2.6, 11.0, 0.36, 2.4, 3.6, 0.33
_SOLVED_BLOCK, _SOLVED_ROW, _SOLVED_COLUMN = 3.5, 2.0, 0.6


def unrolled_cost(plan: LuPlan) -> float:
    """The cost of straight-line code."""
    return _UNROLLED * (plan.operations + SOLUTIONS * 2 * plan.entries)


def table_cost(plan: LuPlan) -> float:
    """The cost of loops over tables of entries."""
    entries = _ENTRY_BY_TABLE + SOLUTIONS * _SOLVED_BY_TABLE
    return _BY_TABLE * plan.operations + entries * plan.entries


def block_cost(
    sizes: Sequence[int],
    left: Sequence[Sequence[int]],
    right: Sequence[Sequence[int]],
    entries: int,
) -> float:
    """The cost of blocks of rows, as `BlockPlan` describes them, of `entries` of W."""
    changed = [size * len(columns) for size, columns in zip(sizes, right, strict=True)]
    total = _ENTRY * entries
    for size, sources, columns in zip(sizes, left, right, strict=True):
        before, after = sum(sizes[source] for source in sources), len(columns)
        total += _BLOCK + _ROW * size + _LEFT * before + _RIGHT * after
        total += _CHANGED * sum(changed[source] for source in sources)
        solved = _SOLVED_COLUMN * (before + size + after)
        total += SOLUTIONS * (_SOLVED_BLOCK + _SOLVED_ROW * size + solved)
    return total
