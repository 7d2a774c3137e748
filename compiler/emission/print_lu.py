"""The factors of `W = c M - J`: their pattern as tables, `factor` and `solve` as C.

The factors are stored row after row in `lu`: the entries left of the pivot (of L, whose
diagonal is one), the reciprocal of the pivot, the entries right of it (of U). Each is one
expression, with the assembly of `W = c M - J` folded in, which compiles and runs faster than
an elimination in place (1.05 us and 0.45 s of gcc against 2.35 us and 4.6 s on a crane of 70
states). Beyond `UNROLLED` operations the runtime works by the tables: slower to run by 3.5, nothing
to compile.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from bgc.emission.lowered import LuPlan

UNROLLED = 30_000  # operations of a factorisation
_CHUNK = 250  # operations in one C function
_PER_LINE = 5  # products in one line of text

Position = tuple[int, int]

_FACTOR = (
    "{linkage}int {prefix}factor(\n"
    "    const double *m, const double *jac, double c, double *lu, double *growth)"
)
_SOLVE = "{linkage}void {prefix}solve(const double *lu, double *b, double *w)"
_ARGUMENTS = {
    "m": "const double *restrict m",
    "jac": "const double *restrict jac",
    "c": "double c",
    "lu": "double *restrict lu",
}
_SOLVE_PURPOSE = "/* b := W^-1 b. */\n"
_PURPOSE = (
    "/* Factorises W = c M - J. growth: the sum over the pivots of (c |M_kk| + |J_kk|) / |pivot|,\n"
    " * about n_state where no pivot cancels. Nonzero where a pivot is zero or not finite. */\n"
)


@dataclass(frozen=True, slots=True)
class MatrixText:
    """C functions `factor` and `solve` (none where the tables serve), and what they need."""

    text: str
    tables: dict[str, Sequence[int]]  # the pattern of the factors, see `bgc.h`
    work: int  # doubles of scratch
    operations: int  # of factor
    solve_operations: int


@dataclass(frozen=True, slots=True)
class _Slots:
    """Where each row of the factors begins in `lu`."""

    plan: LuPlan
    first: tuple[int, ...]

    def pivot(self, k: int) -> int:
        return self.first[k] + len(self.plan.lower[k])


def print_lu(
    plan: LuPlan,
    mass: dict[Position, int] | None,
    jacobian: dict[Position, int],
    shared: bool = False,
) -> MatrixText:
    """The tables and the C text for a plan.

    `mass` and `jacobian` give the places of entries in m and jac. No text beyond `UNROLLED`
    operations. Functions `shared` with other units are `bgc_model_NAME`, else they are static.
    """
    tables = _pattern(plan, mass, jacobian)
    solve = 2 * plan.entries - len(plan.rows)
    if plan.operations > UNROLLED:
        return MatrixText("", tables, 0, plan.operations, solve)
    slots = _Slots(plan, _starts(plan))
    text = f"{_unrolled_factor(slots, mass, jacobian)}\n{_unrolled_solve(slots)}"
    text = text.replace(_FACTOR, _head(_FACTOR, shared)).replace(_SOLVE, _head(_SOLVE, shared))
    work = 0 if plan.rows == plan.columns else len(plan.rows)
    return MatrixText(text, tables, work, plan.operations, solve)


def matrix_prototypes() -> str:
    """The declarations of `factor` and `solve` where they are shared."""
    return f"{_head(_FACTOR, shared=True)};\n{_head(_SOLVE, shared=True)};\n"


def _head(signature: str, shared: bool) -> str:
    linkage, prefix = ("", "bgc_model_") if shared else ("static ", "model_")
    return signature.format(linkage=linkage, prefix=prefix)


def _starts(plan: LuPlan) -> tuple[int, ...]:
    starts, total = [], 0
    for lower, upper in zip(plan.lower, plan.upper, strict=True):
        starts.append(total)
        total += len(lower) + 1 + len(upper)
    return tuple(starts)


def _wrapped(start: str, terms: Sequence[str], joint: str) -> str:
    """`start` and the terms, on as many lines as they need."""
    lines = [joint.join(terms[k : k + _PER_LINE]) for k in range(0, len(terms), _PER_LINE)]
    return start + f"\n       {joint}".join(lines)


# --- factor ---------------------------------------------------------------------------


def _assembled(
    position: Position, mass: dict[Position, int] | None, jacobian: dict[Position, int]
) -> str:
    """One entry of W as text, empty where W has none there."""
    if mass is None:
        inertia = "c" if position[0] == position[1] else ""
    else:
        inertia = f"c * m[{mass[position]}]" if position in mass else ""
    if position not in jacobian:
        return inertia
    entry = f"jac[{jacobian[position]}]"
    return f"{inertia} - {entry}" if inertia else f"-{entry}"


def _magnitude(
    position: Position, mass: dict[Position, int] | None, jacobian: dict[Position, int]
) -> str:
    """The sizes of the parts of an entry of W, added up."""
    parts = []
    if mass is None:
        if position[0] == position[1]:
            parts.append("c")
    elif position in mass:
        parts.append(f"fabs(c * m[{mass[position]}])")
    if position in jacobian:
        parts.append(f"fabs(jac[{jacobian[position]}])")
    return " + ".join(parts)


def _unrolled_factor(
    slots: _Slots, mass: dict[Position, int] | None, jacobian: dict[Position, int]
) -> str:
    plan = slots.plan
    chunks = _in_chunks(
        statement
        for k in range(len(plan.rows))
        for statement in _factor_row(slots, k, mass, jacobian)
    )
    parts, calls = [], []
    for number, lines in enumerate(chunks, 1):
        body = "\n".join(lines)
        used = [name for name in _ARGUMENTS if re.search(rf"\b{name}\b", body)]
        parts.append(
            f"static double model_factor_{number}({', '.join(_ARGUMENTS[name] for name in used)})\n"
            f"{{\n    double g = 0.0;\n{body}\n    return g;\n}}\n\n"
        )
        calls.append(f"    g += model_factor_{number}({', '.join(used)});\n")
    if not plan.rows:
        parts, calls = [], ["    (void)c;\n    (void)lu;\n"]
    return (
        _PURPOSE
        + "".join(parts)
        + f"{_FACTOR}\n{{\n{_unused(mass, jacobian)}    double g = 0.0;\n{''.join(calls)}"
        "    *growth = g;\n    return g < INFINITY ? 0 : 1;\n}\n"
    )


def _unused(mass: dict[Position, int] | None, jacobian: dict[Position, int]) -> str:
    """Statements that mark the arguments of `factor` that a model has no use for."""
    return ("" if mass else "    (void)m;\n") + ("" if jacobian else "    (void)jac;\n")


def _factor_row(
    slots: _Slots, k: int, mass: dict[Position, int] | None, jacobian: dict[Position, int]
) -> Iterator[tuple[str, int]]:
    """The statements of row k, left to right, each with its count of operations."""
    plan = slots.plan
    lower, upper = plan.lower[k], plan.upper[k]
    row = plan.rows[k]
    products: dict[int, list[str]] = {j: [] for j in (*lower, k, *upper)}
    for left, i in enumerate(lower, slots.first[k]):
        for right, j in enumerate(plan.upper[i], slots.pivot(i) + 1):
            products[j].append(f"lu[{left}] * lu[{right}]")
    for slot, j in enumerate(products, slots.first[k]):
        position = (row, plan.columns[j])
        terms = products[j]
        start = _assembled(position, mass, jacobian)
        if not start:
            start = f"-{terms[0]}"  # -a * b is (-a) * b
            following = terms[1:]
        else:
            following = terms
        value = _wrapped(start + (" - " if following else ""), following, " - ")
        operations = 2 + 2 * len(terms)
        inner = f"({value})" if following or " " in start else value
        if j < k:
            yield f"    lu[{slot}] = {inner} * lu[{slots.pivot(j)}];", operations
        elif j > k:
            yield f"    lu[{slot}] = {value};", operations
        else:
            size = _magnitude(position, mass, jacobian)
            size = size or " + ".join(f"fabs({term})" for term in terms)
            size = f"({size})" if " + " in size else size
            yield (
                f"    lu[{slot}] = 1.0 / {inner};\n    g += {size} * fabs(lu[{slot}]);",
                operations + 4,
            )


# --- solve ----------------------------------------------------------------------------


def _unrolled_solve(slots: _Slots) -> str:
    plan = slots.plan
    diagonal = plan.rows == plan.columns
    # With pivots off the diagonal the unknowns are kept in w, in the order of elimination.
    place = [f"b[{row}]" if diagonal else f"w[{k}]" for k, row in enumerate(plan.rows)]
    statements = []
    for k, lower in enumerate(plan.lower):
        terms = [f"lu[{slot}] * {place[j]}" for slot, j in enumerate(lower, slots.first[k])]
        if terms or not diagonal:
            start = f"b[{plan.rows[k]}]" + (" - " if terms else "")
            statements.append((f"    {place[k]} = {_wrapped(start, terms, ' - ')};", len(terms)))
    for k in reversed(range(len(plan.rows))):
        pivot = slots.pivot(k)
        terms = [f"lu[{slot}] * {place[j]}" for slot, j in enumerate(plan.upper[k], pivot + 1)]
        terms.reverse()  # those known longest first, so that the processor need not wait
        if terms:
            value = f"({_wrapped(f'{place[k]} - ', terms, ' - ')}) * lu[{pivot}]"
        else:
            value = f"{place[k]} * lu[{pivot}]"
        line = f"    {place[k]} = {value};"
        if not diagonal:
            line += f"\n    b[{plan.columns[k]}] = {place[k]};"
        statements.append((line, 1 + len(terms)))
    parts, calls = [], []
    extra, more = ("", "") if diagonal else (", double *restrict w", ", w")
    for number, lines in enumerate(_in_chunks(statements), 1):
        parts.append(
            f"static void model_solve_{number}"
            f"(const double *restrict lu, double *restrict b{extra})\n"
            "{\n" + "\n".join(lines) + "\n}\n\n"
        )
        calls.append(f"    model_solve_{number}(lu, b{more});\n")
    head = "".join(["    (void)w;\n"] * diagonal + ["    (void)lu;\n    (void)b;\n"] * (not parts))
    return f"{_SOLVE_PURPOSE}{''.join(parts)}{_SOLVE}\n{{\n{head}{''.join(calls)}}}\n"


def _in_chunks(statements: Iterable[tuple[str, int]]) -> list[list[str]]:
    """Statements in groups of at most `_CHUNK` operations."""
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
    """Where the entries of the factors, of M and of the Jacobian are, by the name of the table."""
    slots = _Slots(plan, _starts(plan))
    size = len(plan.rows)
    place: dict[Position, int] = {}
    for k, row in enumerate(plan.rows):
        for slot, j in enumerate((*plan.lower[k], k, *plan.upper[k]), slots.first[k]):
            place[row, plan.columns[j]] = slot
    return {
        "pivot_row": plan.rows,
        "pivot_col": plan.columns,
        "lu_row": [*slots.first, plan.entries],
        "lu_pivot": [slots.pivot(k) for k in range(size)],
        "lu_col": [j for k in range(size) for j in (*plan.lower[k], k, *plan.upper[k])],
        "lu_jac": [place[position] for position in jacobian],
        "lu_mass": [place[position] for position in mass or ()],
    }
