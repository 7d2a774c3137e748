"""Refuse the user's equations where their Jacobian is singular for all values.

The rates and unknowns of `M y' = f` are determined (index 1) if and only if the rows of M that hold
rates, together with the derivatives of the algebraic rows, form a regular matrix. Its rank is found
modulo a prime at random values, so that a matrix that is always singular is never missed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.algebra.dag import Kind
from bgc.algebra.derivatives import gradient
from bgc.algebra.disjoint_sets import groups_sharing
from bgc.algebra.modular import Solutions, rank_of, solutions_of
from bgc.diagnostics.catalogue import causality as catalogue
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.loops.substitution import Resolver
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Equation, Node
from bgc.record_class import dataclass

_MOST_UNKNOWNS = 100  # unknowns, for which the number of solutions is counted


@dataclass(frozen=True, slots=True)
class Row:
    """An equation `sum entry * rate = right`; one without entries is algebraic."""

    right: Node
    entries: Mapping[int, Node]  # state -> coefficient of its rate
    equation: Equation | None  # None of a loop's unknown


def require_determined(
    variables: Variables, resolver: Resolver, rows: Sequence[Row], names: Mapping[int, str]
) -> None:
    """Check the rows of the user's equations; `names` are those of the states they determine.

    Raises
    ------
    BgError
        Some equations contradict or repeat each other; with their places and unknowns.
    """
    rows = [*rows, *_loop_rows(variables, resolver, rows)]
    symbols = {variables.dag.symbol(Kind.STATE, number): number for number in names}
    symbols |= {symbol: variables.dag.leaf(symbol).index for symbol in resolver.residuals}
    slopes = [_slopes(variables, row, symbols) for row in rows]
    residue = variables.causal.fingerprints.residue
    for group in groups_sharing(slopes):
        columns = {column for i in group for column in slopes[i]}
        numbers = [{c: residue(x) for c, x in slopes[i].items()} for i in group]
        if rank_of(numbers) < len(columns):
            raise _refused(variables, [rows[i] for i in group], numbers, sorted(columns), names)


def _loop_rows(variables: Variables, resolver: Resolver, rows: Sequence[Row]) -> list[Row]:
    """The rows of the unknowns of loops that the equations depend on."""
    residuals, found = resolver.residuals, dict[Node, Row]()
    waiting = [row.right for row in rows if not row.entries]
    while waiting:
        for node in variables.dag.reachable([waiting.pop()]):
            if node in residuals and node not in found:
                found[node] = Row(residuals[node], {}, None)
                waiting.append(residuals[node])
    return list(found.values())


def _slopes(variables: Variables, row: Row, symbols: Mapping[Node, int]) -> dict[int, Node]:
    """A row's entries by states: of the mass matrix, or of the Jacobian."""
    if row.entries:
        return dict(row.entries)
    dag = variables.dag
    held = [node for node in dag.reachable([row.right]) if node in symbols]
    slopes = zip(held, gradient(dag, row.right, held), strict=True)
    return {symbols[node]: slope for node, slope in slopes if slope != dag.zero}


def _refused(
    variables: Variables,
    rows: Sequence[Row],
    numbers: Sequence[Mapping[int, int]],
    columns: Sequence[int],
    names: Mapping[int, str],
) -> BgError:
    """The error for a group of rows that is always singular."""
    spans = [row.equation.span for row in rows if row.equation is not None]
    named = [names[column] for column in columns if column in names]
    found = "unclear"
    if len(rows) == len(columns) <= _MOST_UNKNOWNS and not any(row.entries for row in rows):
        found = _solutions(variables, rows, numbers, columns)
    return BgError([catalogue.singular_equations(spans[-1], named, found, spans[:-1])])


def _solutions(
    variables: Variables,
    rows: Sequence[Row],
    numbers: Sequence[Mapping[int, int]],
    columns: Sequence[int],
) -> str:
    """`none` or `many` for linear equations, otherwise `unclear`."""
    dag = variables.dag
    symbols = [dag.symbol(Kind.STATE, column) for column in columns]
    slopes = [slope for row in rows for slope in gradient(dag, row.right, symbols)]
    if not set(symbols).isdisjoint(dag.reachable(slopes)):
        return "unclear"
    rests = dag.substitute([row.right for row in rows], dict.fromkeys(symbols, dag.zero))
    matrix = [[row.get(column, 0) for column in columns] for row in numbers]
    found = solutions_of(matrix, list(map(variables.causal.fingerprints.residue, rests)))
    return "unclear" if found is Solutions.ONE else found.value
