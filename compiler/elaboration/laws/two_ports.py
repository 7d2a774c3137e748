"""Read transformers, gyrators and gyristors from their ratios and laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bgc.algebra.linalg import SingularMatrixError, inverse
from bgc.diagnostics.catalogue import laws as law_messages
from bgc.diagnostics.catalogue import widths as width_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.components import component_name
from bgc.elaboration.instances.tree import Element
from bgc.elaboration.laws.law_blocks import Laws, arguments_of, left_name, missing_law
from bgc.elaboration.laws.matrix_checks import LawChecks, varies
from bgc.grammar import syntax
from bgc.ir.graph import Gyrator, Gyristor, Matrix, Node, Port, Transformer

_INVERSE_SIDE = {"f2": "f1", "f1": "f2", "e1": "e2", "e2": "e1"}


def read_transformers(laws: Laws, checks: LawChecks, element: Element) -> list[Transformer]:
    """Read a transformer: one element for a matrix, one per component for a scalar ratio."""
    ratio = _read_ratio(laws, element)
    ports1, ports2 = laws.ports(element, "in"), laws.ports(element, "out")
    if isinstance(ratio, list):
        return [
            Transformer(name, "f2", (one,), (two,), ((node,),), None, element.span)
            for name, one, two, node in _pairs(element, ports1, ports2, ratio)
        ]
    if ratio is not None:
        return [Transformer(element.path, "f2", ports1, ports2, ratio, None, element.span)]
    assert element.law
    found = _read_equations(laws, element, element.law)
    left, matrix = found[0]
    inverse_matrix: Matrix | None = None
    if len(found) > 1:
        other, inverse_matrix = found[1]
        if other != _INVERSE_SIDE[left]:
            raise BgError(
                [law_messages.law_too_many(element.law[1].span, element.path, "keep one")]
            )
        if not checks.inverts(inverse_matrix, matrix):
            raise BgError([law_messages.inverse_differs(element.law[1].span, element.path)])
    if left in {"e1", "e2"}:  # e1 = m' e2, e2 = w' e1
        matrix = _transpose(matrix)
        inverse_matrix = _transpose(inverse_matrix) if inverse_matrix is not None else None
    return [Transformer(element.path, left, ports1, ports2, matrix, inverse_matrix, element.span)]


def read_gyrators(laws: Laws, checks: LawChecks, element: Element) -> list[Gyrator]:
    """Read a gyrator likewise; a law that gives flows is inverted to one that gives efforts."""
    ratio = _read_ratio(laws, element)
    ports1, ports2 = laws.ports(element, "in"), laws.ports(element, "out")
    if isinstance(ratio, list):
        return [
            Gyrator(name, (one,), (two,), ((node,),), element.span)
            for name, one, two, node in _pairs(element, ports1, ports2, ratio)
        ]
    if ratio is None:
        assert element.law
        found = _read_equations(laws, element, element.law)
        if len(found) > 1:
            raise BgError(
                [law_messages.law_too_many(element.law[1].span, element.path, "keep one")]
            )
        left, matrix = found[0]
        if left in {"f1", "f2"}:
            ratio = _ratio_from_flows(laws, checks, element, element.law[0], left, matrix)
        else:
            ratio = matrix if left == "e2" else _transpose(matrix)
    return [Gyrator(element.path, ports1, ports2, ratio, element.span)]


def read_gyristor(laws: Laws, checks: LawChecks, element: Element) -> Gyristor:
    """Read an MGY with bonds on one side only: `e = S f` with skew S (eq. 13)."""
    assert element.law, "wiring refuses a one-sided gyrator without a law"
    _, matrix = laws.linear_law(element, element.law, {"e": "f"}, ["e = .."])
    _require_modulated(laws, element, matrix)
    defect = checks.skew_defect(matrix)
    if defect is not None:
        row, column = (place + 1 for place in defect)
        raise BgError([law_messages.not_skew(element.law[0].span, element.path, row, column)])
    return Gyristor(element.path, laws.ports(element, "in"), matrix, element.span)


def _read_ratio(laws: Laws, element: Element) -> Matrix | list[Node] | None:
    """The ratio as a matrix or as one node per component; None if a law replaces it."""
    given = arguments_of(element, ("ratio",))
    if "ratio" not in given:
        if not element.law:
            raise missing_law(element)
        return None
    argument = given["ratio"]
    if element.law is not None:
        raise BgError([law_messages.law_and_argument(argument.span, element.path, "ratio")])
    value = laws.world.evaluate(argument.value, element.env)
    _require_modulated(laws, element, (value.nodes,))
    columns, rows = len(laws.ports(element, "in")), len(laws.ports(element, "out"))
    what = f"the ratio of `{element.path}`"
    if value.is_scalar or len(value.nodes) == columns or value.shape == (rows, columns):
        left = "f2" if element.basic == "TF" else "e2"
        laws.check_entries(element, value, left, "f1", argument.span, what)
    if len(value.shape) == 2:
        return laws.matrix(value, rows, columns, argument.span, what)
    return list(laws.vector(value, columns, argument.span, what, spread=True))


def _read_equations(
    laws: Laws, element: Element, law: Sequence[syntax.LawEquation]
) -> list[tuple[str, Matrix]]:
    """Each left side with the matrix of its right side, in source order."""
    table = element.row.right_sides
    have = [f"{name} = .." for name in table]
    groups: dict[str, list[syntax.LawEquation]] = {}
    for equation in law:
        groups.setdefault(left_name(equation), []).append(equation)
    found = []
    for left, equations in groups.items():
        _, matrix = laws.linear_law(element, equations, table, have)
        _require_modulated(laws, element, matrix)
        found.append((left, matrix))
    if len(found) > 2:
        raise BgError([law_messages.law_too_many(law[2].span, element.path, "keep one")])
    return found


def _ratio_from_flows(
    laws: Laws,
    checks: LawChecks,
    element: Element,
    equation: syntax.LawEquation,
    left: str,
    matrix: Matrix,
) -> Matrix:
    """The ratio r of a gyrator with a law for its flows: `f1 = w e2` or `f2 = w' e1`, w r = 1.

    A matrix w must be square, nonsingular and of constants and parameters only, since a varying
    one may become singular during the run.
    """
    dag, at = laws.world.dag, equation.left.span
    if len(matrix) == len(matrix[0]) == 1 and matrix[0][0] != dag.zero:
        return ((dag.div(dag.one, matrix[0][0]),),)
    if len(matrix) != len(matrix[0]):
        why = f"a matrix of {len(matrix)} x {len(matrix[0])} has no inverse"
        raise BgError([law_messages.flows_not_invertible(at, element.path, why)])
    if varies(dag, matrix):
        why = "a matrix that varies may become singular"
        raise BgError([law_messages.flows_not_invertible(at, element.path, why)])
    try:
        turned = inverse(dag, matrix)
    except SingularMatrixError:
        turned = None
    if turned is None or not checks.is_finite(turned):
        why = "its matrix is singular"
        raise BgError([law_messages.flows_not_invertible(at, element.path, why)])
    return turned if left == "f1" else _transpose(turned)


def _require_modulated(laws: Laws, element: Element, matrix: Matrix) -> None:
    """Raise BgError if the matrix of an unmodulated element (TF, GY) varies."""
    if element.kind in {"TF", "GY"} and varies(laws.world.dag, matrix):
        raise BgError([law_messages.modulated(element.use.span, element.path, element.kind)])


def _pairs(
    element: Element, ports1: Sequence[Port], ports2: Sequence[Port], nodes: Sequence[Node]
) -> Iterator[tuple[str, Port, Port, Node]]:
    """Split a wide two-port with a diagonal ratio into scalar ones: name, ports and ratio."""
    width = len(ports1)
    if len(ports2) != width:
        raise BgError([width_messages.widths_differ(element.span, width, None, len(ports2), None)])
    for k, (one, two, node) in enumerate(zip(ports1, ports2, nodes, strict=True)):
        yield component_name(element.path, (k + 1,) if width > 1 else ()), one, two, node


def _transpose(matrix: Matrix) -> Matrix:
    return tuple(zip(*matrix, strict=True))
