"""Checks that the parameters of a run keep the matrix of a linear storage element symmetric.

The energy account `1/2 x' M x` and the common inertia of several elements are derived for symmetric
matrices. The compiler compares the entries at the parameters' defaults, a run those that it gets.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.linalg import LARGE
from bgc.diagnostics.catalogue import listed
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import FlatGraph, LinearLaw, Matrix, Node, Storage
from bgc.ir.program import PositiveParameter
from bgc.passivity.definite import TOLERANCE, find_asymmetry


def symmetry_checks(variables: Variables) -> Iterator[PositiveParameter]:
    """One check for each pair of entries that parameters can make different.

    A matrix that is not symmetric at the defaults has no checks: BG445 has warned of it, and its
    energy account does not assume symmetry.
    """
    graph = variables.causal.graph
    for element in graph.elements:
        if isinstance(element, Storage):
            matrix = _checked_matrix(graph, element)
            if matrix is not None:
                yield from _checks_of(variables, element, matrix)


def even_matrix(variables: Variables, element: Storage) -> Matrix | None:
    """The mean of a large matrix and its transpose, which has half as many different entries.

    None where it is the matrix itself, is not `LARGE`, or where no check of a run keeps the matrix
    symmetric.
    """
    matrix, dag = _checked_matrix(variables.causal.graph, element), variables.dag
    if matrix is None or len(matrix) < LARGE:
        return None
    size = range(len(matrix))
    if all(matrix[i][j] == matrix[j][i] for i in size for j in range(i)):
        return None
    if any(dag.level[node] > Level.PARAM for row in matrix for node in row):
        return None
    if find_asymmetry([[variables.default(x) for x in row] for row in matrix]):
        return None
    half = dag.const(Fraction(1, 2))

    def mean(a: Node, b: Node) -> Node:
        return a if a == b else dag.mul(half, dag.add(a, b))

    return tuple(tuple(mean(matrix[i][j], matrix[j][i]) for j in size) for i in size)


def _checked_matrix(graph: FlatGraph, element: Storage) -> Matrix | None:
    """The matrix of a linear law whose symmetry a run checks."""
    power = all(graph.bonds[port.bond].power for port in element.ports)
    return element.law.matrix if power and isinstance(element.law, LinearLaw) else None


def _checks_of(
    variables: Variables, element: Storage, matrix: Matrix
) -> Iterator[PositiveParameter]:
    graph = variables.causal.graph
    pairs = [
        (i, j)
        for i, j in combinations(range(len(matrix)), 2)
        if _can_differ(variables, matrix[i][j], matrix[j][i])
    ]
    if not pairs or find_asymmetry([[variables.default(x) for x in row] for row in matrix]):
        return
    for i, j in pairs:
        message = (
            f"the matrix of `{element.name}` must be symmetric: its entries "
            f"[{i + 1}, {j + 1}] and [{j + 1}, {i + 1}] differ"
            f"{_by(graph, matrix[i][j], matrix[j][i])}"
        )
        even = _is_even(graph.dag, matrix, i, j)
        yield PositiveParameter(even, message, strictly_positive=True, symmetric=element.span)


def _can_differ(variables: Variables, a: Node, b: Node) -> bool:
    level = max(variables.dag.level[a], variables.dag.level[b])
    return level == Level.PARAM and not variables.causal.fingerprints.equal(a, b)


def _by(graph: FlatGraph, a: Node, b: Node) -> str:
    """Name the parameters that only one of two entries holds."""
    held = [graph.dag.symbols_in([x], Kind.PARAM).keys() for x in (a, b)]
    symbols = graph.dag.symbols_in(held[0] ^ held[1]).values()
    indices = sorted(symbol.index for symbol in symbols)
    return f", by {listed([graph.parameters[k].name for k in indices])}" if indices else ""


def _is_even(dag: Dag, matrix: Matrix, i: int, j: int) -> Node:
    """0 where two mirrored entries differ as `find_asymmetry` judges, else 1; 1 where undefined."""
    entry, mirror = matrix[i][j], matrix[j][i]
    size = dag.call(Op.SQRT, dag.call(Op.ABS, dag.mul(matrix[i][i], matrix[j][j])))
    for x in (entry, mirror):
        size = dag.call(Op.MAX, size, dag.call(Op.ABS, x))
    difference = dag.call(Op.ABS, dag.sub(entry, mirror))
    differs = dag.call(Op.LT, dag.mul(dag.const(TOLERANCE), size), difference)
    return dag.select(differs, dag.zero, dag.one)
