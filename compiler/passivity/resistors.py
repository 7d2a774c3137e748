"""Check that resistors dissipate: linear fields by their eigenvalues, nonlinear laws by trial."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence

from bgc.algebra.dag import Kind, Symbol
from bgc.diagnostics.catalogue import physics as messages
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.ir.graph import ExplicitLaw, FlatGraph, Form, LinearLaw, Resistor
from bgc.passivity.definite import find_indefinite
from bgc.passivity.eigenvalue_text import pair_of, spectrum_of
from bgc.passivity.point import StartPoint

# Powers of ten of the trial values, SI, over the whole range that machines reach.
_DECADES = {"f": range(-4, 4), "e": range(-4, 7)}
_DIRECTIONS = 4  # random ones of a field, beside its ports one by one
_ROUNDING = 1e-12  # of the powers of the ports, which may cancel


def check_resistor(graph: FlatGraph, point: StartPoint, element: Resistor) -> list[Diagnostic]:
    """Check an R; at most one diagnostic."""
    match element.law:
        case LinearLaw():
            return _check_linear(point, element, element.law)
        case ExplicitLaw():
            return _check_explicit(graph, point, element, element.law)


def _check_linear(point: StartPoint, element: Resistor, law: LinearLaw) -> list[Diagnostic]:
    matrix = point.matrix(law.matrix)
    if matrix is None:
        return []
    when = point.phrase(node for row in law.matrix for node in row)
    bad = find_indefinite(matrix)
    if bad is None:
        return []
    if bad.direction.count(0.0) == len(matrix) - 1 and bad.pair is None:
        label = element.name
        if len(matrix) > 1:
            label += f" [{bad.direction.index(1.0) + 1}]"
        what = "resistance" if law.form is Form.EFFORT else "conductance"
        return [messages.negative_value(element.span, label, what, bad.eigenvalue, when)]
    spectrum = spectrum_of(bad, "f" if law.form is Form.EFFORT else "e")
    return [messages.active_field(element.span, element.name, spectrum, when, pair_of(bad))]


def _check_explicit(
    graph: FlatGraph, point: StartPoint, element: Resistor, law: ExplicitLaw
) -> list[Diagnostic]:
    """Search for trial values at which effort times flow is negative."""
    given, answered = ("f", "e") if law.form is Form.EFFORT else ("e", "f")
    kind = Kind.FLOW if given == "f" else Kind.EFFORT
    own = [Symbol(kind, port.bond) for port in element.ports]
    for trial in _trials(given, len(own)):
        answers = point.numbers(law.nodes, dict(zip(own, trial, strict=True)))
        if answers is None:
            return []  # it depends on what only the equations show
        powers = [x * y for x, y in zip(trial, answers, strict=True)]
        finite = all(map(math.isfinite, powers))
        size = math.fsum(map(abs, powers)) if finite else 0.0
        # Opposite infinities add up to NaN, which decides nothing; fsum raises on them.
        total = math.fsum(powers) if finite else sum(powers)
        if total < -_ROUNDING * size:
            at = _when(point, law, own) + _listed(graph, element, given, trial)
            found = _listed(graph, element, answered, answers)
            return [messages.active_law(element.span, element.name, at, found, -total)]
    return []


def _trials(given: str, width: int) -> Iterator[tuple[float, ...]]:
    """Values of both signs: along each port, then all together; plain sizes first."""
    rng = random.Random(width)
    directions = [tuple(float(i == k) for i in range(width)) for k in range(width)]
    if width > 1:
        for _ in range(_DIRECTIONS):
            directions.append(tuple(rng.uniform(-1, 1) for _ in range(width)))
    for decade in sorted(_DECADES[given], key=lambda k: (abs(k), k)):
        for direction in directions:
            for sign in (1.0, -1.0):
                yield tuple(sign * x * 10.0**decade if x else 0.0 for x in direction)


def _listed(graph: FlatGraph, element: Resistor, variable: str, values: Sequence[float]) -> str:
    """`f = -1 m/s`, or `f[1] = 1 m/s, f[2] = 0.3 rad/s`; ports at rest are left out."""
    wide = len(values) > 1
    words = []
    for k, (port, value) in enumerate(zip(element.ports, values, strict=True), 1):
        bond = graph.bonds[port.bond]
        unit = bond.effort_unit if variable == "e" else bond.flow_unit
        name = f"{variable}[{k}]" if wide else variable
        if value != 0 or not wide:
            words.append(f"{name} = {value:.4g} {unit}".rstrip())
    return ", ".join(words)


def _when(point: StartPoint, law: ExplicitLaw, own: Sequence[Symbol]) -> str:
    """`at the start, and at ` where the law holds anything else that varies, else `at `."""
    for node in point.dag.reachable(law.nodes):
        symbol = point.dag.symbol_of(node)
        if symbol is not None and symbol.kind is not Kind.PARAM and symbol not in own:
            return "at the start, and at "
    return "at "
