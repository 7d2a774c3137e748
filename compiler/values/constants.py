"""Values that must be known at compile time, and checks of constants."""

from __future__ import annotations

import math
from fractions import Fraction

from bgc.algebra.dag import Dag, Level
from bgc.algebra.evaluate import evaluate_nodes, to_double
from bgc.diagnostics.catalogue import values as catalogue
from bgc.diagnostics.source import Span
from bgc.values.arithmetic import Operand, failure, require_plain, require_scalar


def constant_number(dag: Dag, node: int) -> Fraction | float | None:
    """The value of a constant node, exact if rational; None if the node is not constant."""
    exact = dag.value(node)
    if exact is not None:
        return exact
    return evaluate_nodes(dag, [node], {})[0] if dag.level[node] == Level.CONST else None


def constant_scalar(dag: Dag, operand: Operand, what: str) -> Fraction:
    """The exact value of a constant scalar in SI units; messages call it `what`."""
    number = constant_number(dag, require_scalar(operand, what))
    if number is None:
        raise failure(catalogue.not_constant(operand.span, what))
    return Fraction(number)


def whole_number(dag: Dag, operand: Operand, what: str, least: int, most: int) -> int:
    """The integer value, from `least` to `most`, of a constant dimensionless scalar."""
    require_plain(operand, what)
    number = constant_scalar(dag, operand, what)
    if number.denominator != 1 or not least <= number <= most:
        found = f"{to_double(number):.15g}"
        raise failure(catalogue.not_whole(operand.span, what, least, most, found))
    return int(number)


def check_finite(dag: Dag, operand: Operand) -> None:
    """Refuse constant components that are infinite, NaN, or zero only as a double."""
    for node in operand.value.nodes:
        exact = dag.value(node)
        if exact is not None:
            check_literal(exact, operand.span)
        elif dag.level[node] == Level.CONST:
            (number,) = evaluate_nodes(dag, [node], {})
            if math.isnan(number):
                raise failure(catalogue.not_a_number(operand.span))
            if math.isinf(number):
                raise failure(catalogue.out_of_range(operand.span))


def check_literal(number: Fraction, span: Span) -> None:
    """Refuse an exact number that a double cannot hold: too large, or not zero but too small."""
    double = to_double(number)
    if math.isinf(double) or (double == 0 and number != 0):
        raise failure(catalogue.out_of_range(span))
