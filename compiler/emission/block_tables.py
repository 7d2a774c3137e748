"""Print the tables by which the runtime factorises `W = c M - J` in blocks of rows (`blocks.c`)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate

from bgc.ir.lowered import BlockPlan
from bgc.record_class import dataclass

Position = tuple[int, int]

_LINE = 8  # doubles of a cache line, where the factors of a block begin
_PER_LINE = 16


@dataclass(frozen=True, slots=True)
class BlockTables:
    """The contents of a `bgc_block_info`.

    `blocks` has the members of each `bgc_block`, with one more that holds the ends of the lists;
    `arrays` has the lists by name, in the order of the members. `factors` counts the doubles of lu,
    `places` those of vectors by blocks.
    """

    blocks: tuple[tuple[int, ...], ...]
    arrays: dict[str, list[int]]
    factors: int
    places: int


def lay_out_blocks(
    plan: BlockPlan,
    mass: Mapping[Position, int] | None,
    jacobian: Mapping[Position, int],
    inner: int = 0,
) -> BlockTables:
    """The tables of a plan; `mass` and `jacobian` map positions to entries of m and jac.

    Without `mass` M is the identity, but for the last `inner` rows and columns, which it lacks.
    """
    if mass is None:
        mass = {(k, k): k for k in range(len(plan.rows) - inner)}
    starts = [0, *accumulate(plan.sizes)]
    block_of = [t for t, size in enumerate(plan.sizes) for _ in range(size)]
    at, places = _places(plan.sizes)
    upper, first = _factors(plan)
    row_of = {row: k for k, row in enumerate(plan.rows)}
    column_of = {column: k for k, column in enumerate(plan.columns)}

    def assembly(entries: Mapping[Position, int]) -> list[list[tuple[int, int]]]:
        """Find the entries in the rows of each block, and their places in its sheet."""
        lists: list[list[tuple[int, int]]] = [[] for _ in plan.sizes]
        for (row, column), entry in entries.items():
            k = row_of[row]
            t = block_of[k]
            lists[t].append((entry, 8 * places[column_of[column]] + k - starts[t]))
        return lists

    of_mass, of_jacobian = assembly(mass), assembly(jacobian)
    right = [[places[k] for k in columns] for columns in plan.right]
    lists: tuple[Sequence[Sequence[object]], ...] = (plan.left, right, of_mass, of_jacobian)
    begins = zip(*([0, *accumulate(map(len, each))] for each in lists), strict=True)
    heads = zip([*plan.sizes, 0], [*at, 0], first, [*upper, 0], strict=True)
    size = range(len(plan.rows))
    arrays = {
        "row_place": [places[row_of[k]] for k in size],
        "col_place": [places[column_of[k]] for k in size],
        "left": _joined(plan.left),
        "right": _joined(right),
        "mass": [entry for part in of_mass for entry, _ in part],
        "mass_to": [to for part in of_mass for _, to in part],
        "jac": [entry for part in of_jacobian for entry, _ in part],
        "jac_to": [to for part in of_jacobian for _, to in part],
    }
    end = at[-1] + _column_size(plan.sizes[-1])
    return BlockTables(
        blocks=tuple((*head, *begin) for head, begin in zip(heads, begins, strict=True)),
        arrays=arrays,
        factors=first[-1],
        places=-(-end // _LINE) * _LINE,
    )


def print_blocks(tables: BlockTables, in_lanes: bool) -> str:
    """Print the tables as C: `model_blocks` and its arrays.

    `in_lanes`: the model's code for batches of instances has functions `factor` and `solve`.
    """
    rows = {"block": [f"{{{', '.join(map(str, block))}}}" for block in tables.blocks]}
    rows |= {name: list(map(str, values)) for name, values in tables.arrays.items()}
    types = {"block": "bgc_block"}
    text = "".join(_array(types.get(name, "int"), name, row) for name, row in rows.items())
    pointers = ", ".join(f"model_block_{name}" if row else "NULL" for name, row in rows.items())
    head = f"{len(tables.blocks) - 1}, {tables.places}, {int(in_lanes)}"
    return f"{text}static const bgc_block_info model_blocks = {{{head}, {pointers}}};\n"


def _column_size(rows: int) -> int:
    """The doubles of a column of a block: a size that vectors have."""
    return rows if rows <= 2 else 4 if rows <= 4 else 8


def _places(sizes: Sequence[int]) -> tuple[list[int], list[int]]:
    """Aligned places in vectors by blocks: of the first pivot of each block, and of each pivot."""
    at: list[int] = []
    places: list[int] = []
    end = 0
    for size in sizes:
        wide = _column_size(size)
        begin = -(-end // wide) * wide
        at.append(begin)
        places += range(begin, begin + size)
        end = begin + wide
    return at, places


def _factors(plan: BlockPlan) -> tuple[list[int], list[int]]:
    """Places of the inverse of each upper triangle, and of the first factor of each block."""
    upper: list[int] = []
    first = [0]
    for size, left, right in zip(plan.sizes, plan.left, plan.right, strict=True):
        before = sum(plan.sizes[t] for t in left) + (size if size > 1 else 0)
        upper.append(first[-1] + before * _column_size(size))
        end = upper[-1] + (size + len(right)) * _column_size(size)
        first.append(-(-end // _LINE) * _LINE)
    return upper, first


def _joined(lists: Iterable[Iterable[int]]) -> list[int]:
    return [number for numbers in lists for number in numbers]


def _array(type_: str, name: str, values: Sequence[str]) -> str:
    if not values:
        return ""
    per_line = _PER_LINE if type_ == "int" else _PER_LINE // 4
    chunks = (values[k : k + per_line] for k in range(0, len(values), per_line))
    lines = "".join(f"    {', '.join(chunk)},\n" for chunk in chunks)
    return f"static const {type_} model_block_{name}[] = {{\n{lines}}};\n"
