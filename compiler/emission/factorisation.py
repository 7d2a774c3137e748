"""Choose how one instance factorises `W = c M - J`: by unrolled code, tables or blocks of rows.

The interface to the choice of pivots is an `LuPlan` with the positions of the entries of W; nothing
here depends on where the entries come from.
"""

from __future__ import annotations

from collections.abc import Collection

from bgc.emission.blocks import plan_blocks
from bgc.emission.lu_cost import block_cost, table_cost, unrolled_cost
from bgc.emission.print_lu import is_unrolled
from bgc.ir.lowered import BlockPlan, Lowered, LuPlan

# Operations of a factorisation up to which unrolled code was the fastest for every pattern that
# `tests/bench/factorisation.py` measures: blocks are not planned.
_ALWAYS_UNROLLED = 5_000


def choose_blocks(plan: LuPlan, positions: Collection[tuple[int, int]]) -> BlockPlan | None:
    """Plan blocks of rows where they are estimated to be the fastest; else return None.

    Without blocks `print_lu` unrolls code up to a number of operations, and prints tables above it.
    Kept vertices of chains have no blocks: their rows are short, and the order of their pivots is
    what makes them exactly 1.
    """
    if plan.operations <= _ALWAYS_UNROLLED or plan.units:
        return None
    blocks = plan_blocks(plan, positions)
    other = unrolled_cost(plan) if is_unrolled(plan) else table_cost(plan)
    own = block_cost(blocks.sizes, blocks.left, blocks.right, len(positions))
    return blocks if own < other else None


def factor_share(lowered: Lowered) -> float:
    """Estimate the time of a factorisation and its solutions over that of unrolled code."""
    plan, blocks = lowered.plan, lowered.blocks
    if blocks is not None:
        entries = len(lowered.jacobian.entries)
        return block_cost(blocks.sizes, blocks.left, blocks.right, entries) / unrolled_cost(plan)
    return 1.0 if is_unrolled(plan) else table_cost(plan) / unrolled_cost(plan)


def describe_factors(lowered: Lowered) -> str:
    """Name the way in which a single instance factorises W."""
    if lowered.blocks is not None:
        return f"{len(lowered.blocks.sizes)} blocks of rows"
    return "unrolled code" if is_unrolled(lowered.plan) else "tables of entries"
