"""`block([[A, B], [C, D]])`: a matrix made of matrices."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Dag
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.source import Span
from bgc.values.arithmetic import Component, Operand, failure, require_size
from bgc.values.value import Value


def join_blocks(dag: Dag, blocks: Sequence[Sequence[Operand]], span: Span) -> Value:
    """Join rows of blocks; a vector is a column, a plain zero a zero block of the size that fits.

    Raises BgError where neighbours have different heights or widths.
    """
    width = len(blocks[0]) if blocks else 0
    for row in blocks:
        if not row or len(row) != width:
            at = row[-1].span if row else span
            raise failure(
                shape_messages.blocks_differ(at, "the rows of `block` have different lengths")
            )
    heights = [_common_size(dag, row, 0, "heights in this row") for row in blocks]
    columns = list(zip(*blocks, strict=True))
    widths = [_common_size(dag, column, 1, "widths in this column") for column in columns]
    require_size(span, sum(heights) * sum(widths), "this matrix")
    parts: list[Component] = []
    for row, height in zip(blocks, heights, strict=True):
        for i in range(height):
            for block, size in zip(row, widths, strict=True):
                if _is_zero(dag, block):
                    parts.extend([(dag.zero, None)] * size)
                else:
                    parts.extend(block.value.components_at(range(i * size, (i + 1) * size)))
    nodes, units = zip(*parts, strict=True)
    return Value((sum(heights), sum(widths)), nodes, units)


def _is_zero(dag: Dag, block: Operand) -> bool:
    return block.shape == () and block.value.node == dag.zero


def _common_size(dag: Dag, blocks: Sequence[Operand], axis: int, what: str) -> int:
    """The height (axis 0) or width (axis 1) that adjacent blocks share."""
    sized = [block for block in blocks if not _is_zero(dag, block)]
    sizes = [(*block.shape, 1, 1)[axis] for block in sized]
    for block, size in zip(sized, sizes, strict=True):
        if size != sizes[0]:
            raise failure(
                shape_messages.blocks_differ(
                    block.span, f"the {what} differ: {sizes[0]} and {size}"
                )
            )
    return sizes[0] if sizes else 1
