"""Print the LU factorisation of `W = c M - J`: its pattern as tables, `factor` and `solve` as C.

The factors are stored by rows in `lu`: the entries left of the pivot (of L, with unit diagonal),
the reciprocal of the pivot, the entries right of it (of U). Each entry is one expression that
includes the assembly of `W = c M - J`. This compiles and runs faster than elimination in place
(1.05 us and 0.45 s of gcc instead of 2.35 us and 4.6 s on a crane with 70 states). Above `UNROLLED`
operations there is no C text: the runtime uses the tables, which takes 3.5 times as long to run, or
it factorises W in blocks of rows (`factorisation.py` chooses).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from bgc.emission.block_tables import BlockTables, lay_out_blocks
from bgc.emission.print_c import DOUBLES, LANES, Numbers
from bgc.emission.windows import pointer_argument, shift_indices
from bgc.ir.lowered import BlockPlan, LuPlan
from bgc.record_class import dataclass

UNROLLED = 30_000  # operations of a factorisation
UNROLLED_CHAIN = 150_000  # of one whose pivots follow a chain: its rows are short
_CHUNK = 250  # operations in one C function
_PER_LINE = 5  # products in one line of text

Position = tuple[int, int]

_ARGUMENTS = {
    "m": "const {} *restrict m",
    "jac": "const {} *restrict jac",
    "c": "{} c",
    "lu": "{} *restrict lu",
}
_READS = {name: re.compile(r"\bc\b" if name == "c" else rf"{name}\[") for name in _ARGUMENTS}
_SOLVE_PURPOSE = "/* b := W^-1 b. */\n"
_PURPOSE = (
    "/* Factorises W = c M - J. growth: the sum over the pivots of (c |M_kk| + |J_kk|) / |pivot|,\n"
    " * about n_state where no pivot cancels. Nonzero where a pivot is zero or not finite. */\n"
)


@dataclass(frozen=True, slots=True)
class MatrixText:
    """C functions `factor` and `solve` (empty if the runtime uses the tables), and their needs."""

    text: str
    tables: dict[str, Sequence[int]]  # the pattern of the factors, see `bgc.h`
    work: int  # doubles of scratch
    operations: int  # of factor
    solve_operations: int
    blocks: BlockTables | None = None  # instead of functions and tables


@dataclass(frozen=True, slots=True)
class _Storage:
    """The index of the first entry of each row of the factors in `lu`; the number of states."""

    plan: LuPlan
    first: tuple[int, ...]
    states: int

    def pivot(self, k: int) -> int:
        return self.first[k] + len(self.plan.lower[k])


def is_unrolled(plan: LuPlan) -> bool:
    """Return whether a factorisation without blocks is unrolled code; else it has tables."""
    return plan.operations <= (UNROLLED_CHAIN if plan.units else UNROLLED)


def print_lu(
    plan: LuPlan,
    mass: dict[Position, int] | None,
    jacobian: dict[Position, int],
    shared: bool = False,
    numbers: Numbers = DOUBLES,
    inner: int = 0,
    blocks: BlockPlan | None = None,
) -> MatrixText:
    """Print the tables and the C functions of a plan, or the tables of its `blocks`.

    `mass` and `jacobian` map a position to the index of its entry in m and jac. The last `inner`
    rows and columns have no mass, and right-hand sides have zeros there. There are no
    functions above `UNROLLED` operations. `shared` functions are visible to other units; others are
    static. On lanes `factor` reports through `growth` only and has no status, and blocks are not
    used: eight instances fill a register with each operation of the unrolled code, which blocks of
    rows cannot better.
    """
    solve = solve_operations(plan, len(plan.rows) - inner)
    if blocks is not None and numbers is not LANES:
        laid_out = lay_out_blocks(blocks, mass, jacobian, inner)
        return MatrixText("", {}, 0, plan.operations, solve, laid_out)
    tables = _pattern(plan, mass, jacobian)
    if not is_unrolled(plan):
        return MatrixText("", tables, 0, plan.operations, solve)
    storage = _Storage(plan, _row_starts(plan), len(plan.rows) - inner)
    factor = _unrolled_factor(storage, mass, jacobian, shared, numbers)
    text = f"{factor}\n{_unrolled_solve(storage, shared, numbers)}"
    work = inner + (0 if plan.rows == plan.columns else len(plan.rows))
    return MatrixText(text, tables, work, plan.operations, solve)


def print_solve(plan: LuPlan, inner: int, numbers: Numbers) -> str:
    """Print `solve` alone, shared, for the factors that the `factor` of doubles makes.

    The arguments are those of `print_lu`; the plan is one that `is_unrolled`.
    """
    storage = _Storage(plan, _row_starts(plan), len(plan.rows) - inner)
    return _unrolled_solve(storage, True, numbers)


def solve_prototype(numbers: Numbers) -> str:
    """The declaration of the shared function `solve`."""
    return f"{_solve_head(True, numbers)};\n"


def matrix_prototypes(numbers: Numbers = DOUBLES) -> str:
    """The declarations of shared functions `factor` and `solve`."""
    return f"{_factor_head(True, numbers)};\n{_solve_head(True, numbers)};\n"


def _factor_head(shared: bool, numbers: Numbers) -> str:
    number, result = numbers.type, "void" if numbers is LANES else "int"
    return (
        f"{_linkage(shared, result, numbers)}_factor(\n    const {number} *m, const {number} *jac, "
        f"{number} c, {number} *lu, {number} *growth)"
    )


def _solve_head(shared: bool, numbers: Numbers) -> str:
    number = numbers.type
    head = _linkage(shared, "void", numbers)
    return f"{head}_solve(const {numbers.factors or number} *lu, {number} *b, {number} *w)"


def _linkage(shared: bool, result: str, numbers: Numbers) -> str:
    return f"{result} {numbers.shared}" if shared else f"static {result} {numbers.prefix}"


def _row_starts(plan: LuPlan) -> tuple[int, ...]:
    starts, total = [], 0
    for lower, upper in zip(plan.lower, plan.upper, strict=True):
        starts.append(total)
        total += len(lower) + 1 + len(upper)
    return tuple(starts)


def _wrapped(start: str, terms: Sequence[str], joint: str) -> str:
    """`start` followed by the terms, with line breaks."""
    lines = [joint.join(terms[k : k + _PER_LINE]) for k in range(0, len(terms), _PER_LINE)]
    return start + f"\n       {joint}".join(lines)


# --- factor ---------------------------------------------------------------------------


def _entry_of_w(
    position: Position,
    mass: dict[Position, int] | None,
    jacobian: dict[Position, int],
    states: int,
) -> str:
    """An entry of W as text; empty where W has none (fill)."""
    if mass is None:
        inertia = "c" if position[0] == position[1] < states else ""
    else:
        inertia = f"c * m[{mass[position]}]" if position in mass else ""
    if position not in jacobian:
        return inertia
    entry = f"jac[{jacobian[position]}]"
    return f"{inertia} - {entry}" if inertia else f"-{entry}"


def _magnitude(
    position: Position,
    mass: dict[Position, int] | None,
    jacobian: dict[Position, int],
    states: int,
    size: str,
) -> str:
    """The sum of the magnitudes of the terms of an entry of W; `size` is the C function fabs."""
    parts = []
    if mass is None:
        if position[0] == position[1] < states:
            parts.append("c")
    elif position in mass:
        parts.append(f"{size}(c * m[{mass[position]}])")
    if position in jacobian:
        parts.append(f"{size}(jac[{jacobian[position]}])")
    return " + ".join(parts)


def _unrolled_factor(
    storage: _Storage,
    mass: dict[Position, int] | None,
    jacobian: dict[Position, int],
    shared: bool,
    numbers: Numbers,
) -> str:
    plan = storage.plan
    number, zero = numbers.type, numbers.constant("0.0")
    chunks = _in_chunks(
        statement
        for k in range(len(plan.rows))
        for statement in _factor_row(storage, k, mass, jacobian, numbers)
    )
    parts, calls = [], []
    for count, statements in enumerate(chunks, 1):
        lines, places = _shift_pointers(statements, numbers)
        body = "\n".join(lines)
        used = [name for name, reads in _READS.items() if reads.search(body)]
        declared = ", ".join(_ARGUMENTS[name].format(number) for name in used)
        part = f"{numbers.prefix}_factor_{count}"
        parts.append(
            f"static {number} {part}({declared})\n"
            f"{{\n    {number} g = {zero};\n{body}\n    return g;\n}}\n\n"
        )
        passed = ", ".join(pointer_argument(name, places) for name in used)
        calls.append(f"    g += {part}({passed});\n")
    if not plan.rows:
        parts, calls = [], ["    (void)c;\n    (void)lu;\n"]
    return (
        _PURPOSE
        + "".join(parts)
        + f"{_factor_head(shared, numbers)}\n{{\n{_unused(mass, jacobian)}"
        f"    {number} g = {zero};\n{''.join(calls)}    *growth = g;\n"
        + ("}\n" if numbers is LANES else "    return g < (double)INFINITY ? 0 : 1;\n}\n")
    )


def _unused(mass: dict[Position, int] | None, jacobian: dict[Position, int]) -> str:
    """Statements that mark unused arguments of `factor`."""
    return ("" if mass else "    (void)m;\n") + ("" if jacobian else "    (void)jac;\n")


def _product(left: str, right: str, sign: int | None, other: int | None, numbers: Numbers) -> str:
    """A product as text; a factor that is always 1 or -1 has that sign."""
    if sign is not None and other is not None:
        return numbers.constant(f"{sign * other}.0")
    if sign is not None:
        return right if sign > 0 else _negated(right)
    if other is not None:
        return left if other > 0 else _negated(left)
    return f"{left} * {right}"


def _negated(term: str) -> str:
    """The negative of a term: -a * b is (-a) * b."""
    return term[1:] if term.startswith("-") else f"-{term}"


def _factor_row(
    storage: _Storage,
    k: int,
    mass: dict[Position, int] | None,
    jacobian: dict[Position, int],
    numbers: Numbers,
) -> Iterator[tuple[str, int]]:
    """The statements of row k from left to right, each with its number of operations."""
    plan, fabs = storage.plan, f"{numbers.function}fabs"
    lower, upper = plan.lower[k], plan.upper[k]
    row = plan.rows[k]
    products: dict[int, list[str]] = {j: [] for j in (*lower, k, *upper)}
    for left, i in enumerate(lower, storage.first[k]):
        for right, j in enumerate(plan.upper[i], storage.pivot(i) + 1):
            signs = plan.units.get((k, i)), plan.units.get((i, j))
            products[j].append(_product(f"lu[{left}]", f"lu[{right}]", *signs, numbers))
    for at, j in enumerate(products, storage.first[k]):
        if (k, j) in plan.units:
            growth = f"\n    g += {numbers.constant('1.0')};" if j == k else ""
            constant = numbers.constant(f"{plan.units[k, j]}.0")
            yield f"    lu[{at}] = {constant};{growth}", 1
            continue
        position = (row, plan.columns[j])
        terms = products[j]
        start = _entry_of_w(position, mass, jacobian, storage.states)
        if not start:
            start = _negated(terms[0])
            following = terms[1:]
        else:
            following = terms
        value = _wrapped(start + (" - " if following else ""), following, " - ")
        operations = 2 + 2 * len(terms)
        inner = f"({value})" if following or " " in start else value
        if j < k:
            scaled = _product(
                inner, f"lu[{storage.pivot(j)}]", None, plan.units.get((j, j)), numbers
            )
            yield f"    lu[{at}] = {scaled};", operations
        elif j > k:
            yield f"    lu[{at}] = {value};", operations
        else:
            size = _magnitude(position, mass, jacobian, storage.states, fabs)
            size = size or " + ".join(f"{fabs}({term})" for term in terms)
            size = f"({size})" if " + " in size else size
            yield (
                f"    lu[{at}] = 1.0 / {inner};\n    g += {size} * {fabs}(lu[{at}]);",
                operations + 4,
            )


# --- solve ----------------------------------------------------------------------------


def nonzero_rows(plan: LuPlan, states: int) -> list[bool]:
    """Return whether row k may be nonzero after forward substitution; rows of states may."""
    found: list[bool] = []
    for row, lower in zip(plan.rows, plan.lower, strict=True):
        found.append(row < states or any(found[j] for j in lower))
    return found


def needed_columns(plan: LuPlan, states: int) -> list[bool]:
    """Return whether the states need the unknown of pivot k in backward substitution."""
    needed = [column < states for column in plan.columns]
    for k, upper in enumerate(plan.upper):
        for j in upper if needed[k] else ():
            needed[j] = True
    return needed


def solve_operations(plan: LuPlan, states: int) -> int:
    """The multiplications and additions of one solution."""
    nonzero, needed = nonzero_rows(plan, states), needed_columns(plan, states)
    forward = [(k, j) for k, lower in enumerate(plan.lower) for j in lower if nonzero[j]]
    backward = [(k, j) for k, upper in enumerate(plan.upper) if needed[k] for j in upper]
    pivots = [(k, k) for k in range(len(plan.rows)) if needed[k]]
    trivial = sum(place in plan.units for place in (*forward, *backward, *pivots))
    return 2 * (len(forward) + len(backward)) + len(pivots) - trivial


def _unrolled_solve(storage: _Storage, shared: bool, numbers: Numbers) -> str:
    plan, number, states = storage.plan, numbers.type, storage.states
    factor = numbers.factors or number
    diagonal = plan.rows == plan.columns
    inner = len(plan.rows) - states

    def unknown(number: int) -> str:
        return f"b[{number}]" if number < states else f"w[{number - states}]"

    # With pivots off the diagonal, w holds the unknowns in the order of elimination.
    place = [unknown(row) if diagonal else f"w[{inner + k}]" for k, row in enumerate(plan.rows)]
    nonzero = nonzero_rows(plan, states)
    # The check of solutions on lanes reads all unknowns.
    needed = needed_columns(plan, len(plan.rows) if numbers is LANES else states)
    statements = []
    for k, lower in enumerate(plan.lower):
        terms = [
            _product(f"lu[{at}]", place[j], plan.units.get((k, j)), None, numbers)
            for at, j in enumerate(lower, storage.first[k])
            if nonzero[j]
        ]
        if not nonzero[k] or not (terms or not diagonal):
            continue
        if plan.rows[k] < states:
            start = f"b[{plan.rows[k]}]" + (" - " if terms else "")
        else:
            start, terms = _negated(terms[0]) + (" - " if terms[1:] else ""), terms[1:]
        statements.append((f"    {place[k]} = {_wrapped(start, terms, ' - ')};", len(terms)))
    for k in reversed(range(len(plan.rows))):
        if not needed[k]:
            continue
        pivot = storage.pivot(k)
        terms = [
            _product(f"lu[{at}]", place[j], plan.units.get((k, j)), None, numbers)
            for at, j in enumerate(plan.upper[k], pivot + 1)
        ]
        terms.reverse()  # the unknowns computed first come first, which avoids pipeline stalls
        start = place[k] + (" - " if terms else "")
        if not nonzero[k]:
            zero = numbers.constant("0.0")
            start = (_negated(terms[0]) if terms else zero) + (" - " if terms[1:] else "")
            terms = terms[1:]
        value = _wrapped(start, terms, " - ")
        value = f"({value})" if terms or not nonzero[k] else value
        value = _product(value, f"lu[{pivot}]", None, plan.units.get((k, k)), numbers)
        line = f"    {place[k]} = {value};"
        if not diagonal:
            line += f"\n    {unknown(plan.columns[k])} = {place[k]};"
        statements.append((line, 1 + len(terms)))
    parts, calls = [], []
    with_work = inner > 0 or not diagonal
    extra, more = (f", {number} *restrict w", ", w") if with_work else ("", "")
    for count, chunk in enumerate(_in_chunks(statements), 1):
        lines, places = _shift_pointers(chunk, numbers)
        part = f"{numbers.prefix}_solve_{count}"
        parts.append(
            f"static void {part}(const {factor} *restrict lu, {number} *restrict b{extra})\n"
            "{\n" + "\n".join(lines) + "\n}\n\n"
        )
        passed = f"{pointer_argument('lu', places)}, {pointer_argument('b', places)}"
        calls.append(f"    {part}({passed}{more});\n")
    head = "".join(
        ["    (void)w;\n"] * (not with_work or not parts)
        + ["    (void)lu;\n    (void)b;\n"] * (not parts)
    )
    signature = _solve_head(shared, numbers)
    return f"{_SOLVE_PURPOSE}{''.join(parts)}{signature}\n{{\n{head}{''.join(calls)}}}\n"


def _shift_pointers(
    statements: Sequence[str], numbers: Numbers
) -> tuple[list[str], dict[str, int]]:
    """Shift the indices of a part's statements relative to its pointers."""
    return shift_indices(statements, ("m", "jac", "lu", "b"), numbers.reach)


def _in_chunks(statements: Iterable[tuple[str, int]]) -> list[list[str]]:
    """Group statements into chunks of at most `_CHUNK` operations."""
    chunks: list[list[str]] = []
    filled = _CHUNK
    for line, operations in statements:
        if filled + operations > _CHUNK or not chunks:
            chunks.append([])
            filled = 0
        chunks[-1].append(line)
        filled += operations
    return chunks


# --- tables ---------------------------------------------------------------------------


def _pattern(
    plan: LuPlan, mass: dict[Position, int] | None, jacobian: dict[Position, int]
) -> dict[str, Sequence[int]]:
    """The tables of the factors, and of the positions of M and J in them, by name."""
    storage = _Storage(plan, _row_starts(plan), len(plan.rows))
    size = len(plan.rows)
    place: dict[Position, int] = {}
    for k, row in enumerate(plan.rows):
        for at, j in enumerate((*plan.lower[k], k, *plan.upper[k]), storage.first[k]):
            place[row, plan.columns[j]] = at
    return {
        "pivot_row": plan.rows,
        "pivot_col": plan.columns,
        "lu_row": [*storage.first, plan.entries],
        "lu_pivot": [storage.pivot(k) for k in range(size)],
        "lu_col": [j for k in range(size) for j in (*plan.lower[k], k, *plan.upper[k])],
        "lu_jac": [place[position] for position in jacobian],
        "lu_mass": [place[position] for position in mass or ()],
    }
