"""Diagnostics: laws that are not passive."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, warning
from bgc.diagnostics.source import Span


@warning(
    "BG445: the matrix of `{name}` is not symmetric{when}: entry [{row}, {column}] is "
    "{entry:.6g}, [{column}, {row}] is {mirror:.6g}, a difference of {gap:.6g}",
    "correct the matrix, or give the energy, `{ H = ..; }`; to exchange power without "
    "storing it use an MGY with a skew matrix",
    note="a storage element whose matrix is not symmetric has no energy",
)
def not_symmetric(
    span: Span, name: str, place: tuple[int, int], entry: float, mirror: float, when: str
) -> Values:
    row, column = place
    return {"row": row, "column": column, "gap": entry - mirror}


# Refuse parameters that make a symmetric matrix asymmetric (BG445), as the message says.
@error(
    "BG445: {message}",
    "set both entries to the same value, or compute both from one parameter in the model",
    note="the model is compiled for a symmetric matrix; without it storage has no energy",
)
def turned_asymmetric(span: Span, message: str) -> None: ...
@warning(
    "BG460: the {what} of `{name}` is negative{when}: {value:.6g}",
    "change the sign; to supply power use a source, Se or Sf",
)
def negative_value(span: Span | None, name: str, what: str, value: float, when: str) -> None: ...
@warning(
    "BG461: the matrix of `{name}`, {kind:an} field, is not {must}{when}: it has {spectrum}",
    "correct the matrix: all entries must refer to the same point and the same axes",
    note="{pair}",
)
def indefinite_storage(
    span: Span, name: str, kind: str, spectrum: str, pair: str, when: str
) -> Values:
    return {"must": "positive definite" if kind == "I" else "positive semidefinite"}


@warning(
    "BG462: `{name}` supplies power{power}: the symmetric part of its matrix has {spectrum}",
    "correct the entries, or omit their coupling: the symmetric part of a resistor's "
    "matrix is positive semidefinite",
    note="{pair}",
)
def active_field(span: Span, name: str, spectrum: str, power: str, pair: str) -> None: ...
@warning(
    "BG463: `{name}` supplies power: {at} its law gives {answer}, that is {power:.4g} W",
    "write a law whose effort has the sign of its flow, for example `e = d*abs(f)*f`; "
    "model a constant part by a source, Se or Sf",
)
def active_law(span: Span, name: str, at: str, answer: str, power: float) -> None: ...
@warning(
    "BG464: the inertia of `{name}` is not positive {at}: {spectrum}",
    "the energy must be convex in the momentum: check its signs",
)
def energy_not_convex(span: Span, name: str, spectrum: str, at: str) -> None: ...


def listed_direction(variable: str, direction: Sequence[float]) -> str:
    """Name the components of a direction: `f[3] = 1, f[5] = 0.083`."""
    wide = len(direction) > 1
    return ", ".join(
        f"{variable}[{k}] = {component:.3g}" if wide else f"{variable} = {component:.3g}"
        for k, component in enumerate(direction, 1)
        if abs(component) >= 5e-4
    )
