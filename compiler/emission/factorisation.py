"""Choose how one instance factorises `W = c M - J`: by unrolled code, tables or blocks of rows.

The interface to the choice of pivots is an `LuPlan` with the positions of the entries of W; nothing
here depends on where the entries come from.
"""

from __future__ import annotations

from collections.abc import Collection

from bgc.emission import print_lu
from bgc.emission.blocks import plan_blocks
from bgc.emission.lu_cost import block_cost, table_cost, unrolled_cost
from bgc.ir.lowered import BlockPlan, Lowered, LuPlan

# Operations of a factorisation up to which unrolled code was the fastest for every pattern that
# `tests/bench/factorisation.py` measures: blocks are not planned.
_ALWAYS_UNROLLED = 5_000


def choose_blocks(plan: LuPlan, positions: Collection[tuple[int, int]]) -> BlockPlan | None:
    """Plan blocks of rows where they are estimated to be the fastest; else return None.

    Without blocks `print_lu` unrolls code up to a number of operations, and prints tables above it.
    """
    if plan.operations <= _ALWAYS_UNROLLED:
        return None
    blocks = plan_blocks(plan, positions)
    unrolled = plan.operations <= print_lu.UNROLLED
    other = unrolled_cost(plan) if unrolled else table_cost(plan)
    own = block_cost(blocks.sizes, blocks.left, blocks.right, len(positions))
    return blocks if own < other else None


def describe_factors(lowered: Lowered) -> str:
    """Name the way in which a single instance factorises W."""
    if lowered.blocks is not None:
        return f"{len(lowered.blocks.sizes)} blocks of rows"
    unrolled = lowered.plan.operations <= print_lu.UNROLLED
    return "unrolled code" if unrolled else "tables of entries"
