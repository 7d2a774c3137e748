"""The transfer function of a linear system as a quotient of determinants.

    G(s) = det [ s M - A   B ] / det (s M - A)
               [   -C      D ]

on the states through which the input reaches the output; the others do not matter. Columns, then
rows, are multiplied by their common denominators, so both matrices hold integer polynomials in s
and the letters. Both determinants are products of factors; common factors are cancelled, so the
result is in lowest terms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeAlias

import sympy

from bgc.algebra.matching import match
from bgc.ir.graph import Node
from bgc.record_class import dataclass
from bgc.symbolic.determinants import Budget, Row, determinant_factors
from bgc.symbolic.quotients import Denominator, Field
from bgc.symbolic.ratios import Ratio, lowest

Entries: TypeAlias = Mapping[tuple[int, int], Node]
_Expressions: TypeAlias = dict[int, sympy.Expr]  # column -> entry


@dataclass(frozen=True, slots=True)
class LinearSystem:
    """`M x' = A x + B u`, `y = C x + D u` of `size` states, as nodes other than zero.

    `convert` makes expressions of nodes. `letters` are in the order in which products are written,
    `laplace` is the symbol s.
    """

    size: int
    M: Entries
    A: Entries
    B: Entries
    C: Entries
    D: Entries
    laplace: sympy.Symbol
    letters: tuple[sympy.Symbol, ...]
    convert: Callable[[Sequence[Node]], list[sympy.Expr]]


class SingularPencil(Exception):
    """`s M - A` is singular for all s: the equations do not determine the states `undetermined`."""

    def __init__(self, undetermined: Sequence[int]) -> None:
        super().__init__()
        self.undetermined = tuple(undetermined)


def transfer_ratio(system: LinearSystem, output: int, input_: int, budget: Budget) -> Ratio:
    """G(s) from one input to one output, s being letter 0 of its field.

    Raises
    ------
    SingularPencil
        The equations do not determine the states.
    ZeroDivisionError
        An entry divides by zero.
    """
    by_input = {r: node for (r, c), node in system.B.items() if c == input_}
    by_state = {c: node for (r, c), node in system.C.items() if r == output}
    row_of, columns = _matched(system)
    states = _between(row_of, columns, by_input, by_state)
    bordered = _bordered(system, [row_of[v] for v in states], states, by_input, by_state)
    size = len(states)
    if (output, input_) in system.D:
        (bordered[size][size],) = system.convert([system.D[output, input_]])
    field = Field(
        [system.laplace, *(e for row in bordered for e in row.values())],
        (system.laplace, *system.letters),
        budget,
    )
    whole, multiple = _cleared(field, bordered)
    inner = [{c: e for c, e in row.items() if c < size} for row in whole[:size]]
    below = determinant_factors(inner, field.ring, budget)
    if below is None:
        raise SingularPencil(states)
    above = determinant_factors(whole, field.ring, budget)
    return lowest(field, above or [field.ring.zero], [*below, *field.factors(multiple)])


def _matched(system: LinearSystem) -> tuple[dict[int, int], list[set[int]]]:
    """The row that is matched to each column of `s M - A`, and the columns of each row."""
    columns: list[set[int]] = [set() for _ in range(system.size)]
    for r, c in (*system.A, *system.M):
        columns[r].add(c)
    start = {r: r for r, found in enumerate(columns) if r in found}
    column_of = match([sorted(found) for found in columns], start)
    row_of = {column: row for row, column in column_of.items()}
    if len(row_of) < system.size:
        raise SingularPencil([c for c in range(system.size) if c not in row_of])
    return row_of, columns


def _between(
    row_of: Mapping[int, int],
    columns: Sequence[Iterable[int]],
    by_input: Iterable[int],
    by_state: Iterable[int],
) -> list[int]:
    """The states that the input reaches and that reach the output, in order."""
    column_of = {row: column for column, row in row_of.items()}
    held_by: dict[int, list[int]] = {}
    for r, found in enumerate(columns):
        for c in found:
            held_by.setdefault(c, []).append(column_of[r])
    reached = _closure((column_of[r] for r in by_input), held_by)
    needed = _closure(by_state, {v: columns[r] for v, r in row_of.items()})
    return sorted(reached & needed)


def _closure(start: Iterable[int], following: Mapping[int, Iterable[int]]) -> set[int]:
    found = set(start)
    stack = list(found)
    while stack:
        for other in following.get(stack.pop(), ()):
            if other not in found:
                found.add(other)
                stack.append(other)
    return found


def _bordered(
    system: LinearSystem,
    rows: Sequence[int],
    states: Sequence[int],
    by_input: Mapping[int, Node],
    by_state: Mapping[int, Node],
) -> list[_Expressions]:
    """`[s M - A, B; -C, 0]` on some rows and columns; the input is the last column."""
    place = {v: k for k, v in enumerate(states)}
    row_place = {r: k for k, r in enumerate(rows)}
    size = len(states)
    minus, s = sympy.Integer(-1), system.laplace
    entries = [
        *((row_place[r], place[c], minus, node) for (r, c), node in _within(system.A, rows, place)),
        *((row_place[r], place[c], s, node) for (r, c), node in _within(system.M, rows, place)),
        *((k, size, sympy.S.One, by_input[r]) for r, k in row_place.items() if r in by_input),
        *((size, k, minus, by_state[c]) for c, k in place.items() if c in by_state),
    ]
    found: list[_Expressions] = [{} for _ in range(size + 1)]
    values = system.convert([node for *_, node in entries])
    for (row, column, factor, _), value in zip(entries, values, strict=True):
        found[row][column] = found[row].get(column, sympy.S.Zero) + factor * value
    return found


def _within(
    entries: Entries, rows: Sequence[int], columns: Mapping[int, int]
) -> list[tuple[tuple[int, int], Node]]:
    wanted = set(rows)
    return [item for item in entries.items() if item[0][0] in wanted and item[0][1] in columns]


def _cleared(field: Field, rows: Sequence[_Expressions]) -> tuple[list[Row], Denominator]:
    """Clear denominators; return the rows and the multiplier of the last one.

    Columns are multiplied first: flows and efforts are states over parameters, so that a column
    of a model has one denominator. The last column, of the input, is left as it is.
    """
    found = [{c: field.of(e) for c, e in row.items()} for row in rows]
    for column in range(len(rows) - 1):
        multiple = field.multiple(row[column].below for row in found if column in row)
        for row in found:
            if column in row:
                row[column] = field.over(row[column], multiple)
    cleared: list[Row] = []
    multiple = field.multiple(())
    for row in found:
        multiple = field.multiple(quotient.below for quotient in row.values())
        scaled = {c: field.over(quotient, multiple).above for c, quotient in row.items()}
        cleared.append({c: above for c, above in scaled.items() if above})
    return cleared, multiple
