"""Plan the LU factorisation of `W = c M - J` in blocks of rows.

Pivots with almost equal patterns are eliminated together, padded to the same pattern (relaxed
supernodes: Ashcraft and Grimes, ACM Trans. Math. Softw. 15 (1989), 291-309). The pivots are those
of an `LuPlan`, in a postorder of the tree in which pivot k hangs on the first pivot whose row or
column it changes, so that the pivots of a chain follow each other and the longest pattern comes
last. Chains are merged while they store few zeros, and cut into blocks of at most 8 rows; the
pattern of blocks follows from that of W. Of several limits on the zeros the cheapest by
`lu_cost.block_cost` is kept.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from heapq import heapify, heappop, heappush

from bgc.emission.lu_cost import block_cost
from bgc.ir.lowered import BlockPlan, LuPlan
from bgc.record_class import dataclass

MOST_ROWS = 8  # of a block: the doubles of a vector register with AVX-512
_ZERO_PARTS = (0.05, 0.2, 0.4, 0.8)  # of the stored entries of merged pivots
_ZEROS_EACH = (0, 2, 6, 12)  # for each merged pivot
_FEW_PIVOTS = 2_000  # up to which all these limits are tried


@dataclass(frozen=True, slots=True)
class _Tree:
    """Pivots in postorder, and of each, in that order, its parent (or -1) and number of entries."""

    order: list[int]
    parent: list[int]
    entries: list[int]


def plan_blocks(plan: LuPlan, positions: Collection[tuple[int, int]]) -> BlockPlan:
    """Plan blocks for the pivots of a plan; `positions` are the entries of W."""
    tree = _postorder(plan)
    pattern = _in_order(plan, tree.order, positions)
    wide = len(tree.order) > _FEW_PIVOTS
    limits = [
        (part, each)
        for part in (_ZERO_PARTS[1:3] if wide else _ZERO_PARTS)
        for each in (_ZEROS_EACH[1:3] if wide else _ZEROS_EACH)
    ]
    partitions = dict.fromkeys(tuple(_sizes(tree, part, each)) for part, each in limits)
    candidates = [(sizes, *_eliminate_blocks(sizes, pattern)) for sizes in partitions]
    costs = [block_cost(sizes, left, right, len(positions)) for sizes, left, right in candidates]
    sizes, left, right = candidates[costs.index(min(costs))]
    return BlockPlan(
        rows=tuple(plan.rows[k] for k in tree.order),
        columns=tuple(plan.columns[k] for k in tree.order),
        sizes=sizes,
        left=tuple(map(tuple, left)),
        right=tuple(map(tuple, right)),
    )


def _postorder(plan: LuPlan) -> _Tree:
    size = len(plan.rows)
    below: list[list[int]] = [[] for _ in range(size)]
    for k, lower in enumerate(plan.lower):
        for j in lower:
            below[j].append(k)
    parent = [
        min((*upper[:1], *rows[:1]), default=-1)
        for upper, rows in zip(plan.upper, below, strict=True)
    ]
    entries = [len(upper) + len(rows) for upper, rows in zip(plan.upper, below, strict=True)]
    children: list[list[int]] = [[] for _ in range(size + 1)]  # of -1: the last
    for k in range(size):
        children[parent[k]].append(k)
    # A child with many entries is visited late: it continues the chain of its parent.
    order: list[int] = []
    stack = [(-1, False)]
    while stack:
        pivot, visited = stack.pop()
        if visited:
            order.append(pivot)
            continue
        stack.append((pivot, True))
        stack += [(k, False) for k in sorted(children[pivot], key=lambda k: -entries[k])]
    order.pop()  # the root of all trees
    place = [0] * (size + 1)
    for position, pivot in enumerate(order):
        place[pivot] = position
    place[-1] = -1
    return _Tree(order, [place[parent[k]] for k in order], [entries[k] for k in order])


def _in_order(
    plan: LuPlan, order: Sequence[int], positions: Iterable[tuple[int, int]]
) -> list[set[int]]:
    """The columns of the entries of each row of W, both numbered by their pivots."""
    pivot_of_row, pivot_of_column = [0] * len(order), [0] * len(order)
    for place, k in enumerate(order):
        pivot_of_row[plan.rows[k]] = place
        pivot_of_column[plan.columns[k]] = place
    pattern = [{k} for k in range(len(order))]
    for row, column in positions:
        pattern[pivot_of_row[row]].add(pivot_of_column[column])
    return pattern


def _sizes(tree: _Tree, part: float, each: int) -> list[int]:
    """The sizes of blocks: chains that store few zeros, cut with the rest in the first block."""
    sizes: list[int] = []
    begin, size = 0, len(tree.order)
    while begin < size:
        end, zeros, stored = begin + 1, 0, tree.entries[begin] + 1
        while end < size and tree.parent[end - 1] == end:
            count = end - begin
            more = zeros + count * (tree.entries[end] + 2 - tree.entries[end - 1])
            total = stored + tree.entries[end] + 1
            if more > zeros and more > part * total and more > each * count:
                break
            zeros, stored = more, total
            end += 1
        rest = (end - begin) % MOST_ROWS
        sizes += [rest] * bool(rest) + [MOST_ROWS] * ((end - begin) // MOST_ROWS)
        begin = end
    return sizes


def _eliminate_blocks(
    sizes: Sequence[int], pattern: Sequence[set[int]]
) -> tuple[list[list[int]], list[list[int]]]:
    """The blocks left of each block, and the pivots right of it, with their fill."""
    block_of = [t for t, size in enumerate(sizes) for _ in range(size)]
    all_left: list[list[int]] = []
    all_right: list[list[int]] = []
    begin = 0
    for size in sizes:
        end = begin + size
        columns = set[int]().union(*pattern[begin:end])
        queue = list({block_of[column] for column in columns if column < begin})
        heapify(queue)
        found, left = set(queue), []
        while queue:
            source = heappop(queue)
            left.append(source)
            for column in all_right[source]:
                columns.add(column)
                if column < begin and block_of[column] not in found:
                    found.add(block_of[column])
                    heappush(queue, block_of[column])
        all_left.append(left)
        all_right.append(sorted(column for column in columns if column >= end))
        begin = end
    return all_left, all_right
