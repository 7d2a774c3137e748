"""Diagnostics of laws that are not passive: warnings, and errors under `--strict`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning, with_article
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def not_symmetric(
    span: Span, name: str, place: tuple[int, int], entry: float, mirror: float, when: str
) -> Diagnostic:
    """BG445: a storage field that is not symmetric"""
    row, column = place
    return warning(
        "BG445",
        f"the matrix of `{name}` is not symmetric{when}: entry [{row}, {column}] is {entry:.6g}, "
        f"[{column}, {row}] is {mirror:.6g}, a difference of {entry - mirror:.6g}",
        span,
        note="a storage element whose matrix is not symmetric has no energy",
        help="correct the matrix, or give the energy, `{ H = ..; }`; to exchange power without "
        "storing it use an MGY with a skew matrix",
    )


def turned_asymmetric(span: Span, message: str) -> Diagnostic:
    """Refuse parameters that make a symmetric matrix asymmetric (BG445), as the message says."""
    return error(
        "BG445",
        message,
        span,
        note="the model is compiled for a symmetric matrix; without it storage has no energy",
        help="set both entries to the same value, or compute both from one parameter in the model",
    )


def negative_value(span: Span | None, name: str, what: str, value: float, when: str) -> Diagnostic:
    """BG460: a negative resistance, inertia or compliance"""
    return warning(
        "BG460",
        f"the {what} of `{name}` is negative{when}: {value:.6g}",
        span,
        help="change the sign; to supply power use a source, Se or Sf",
    )


def indefinite_storage(
    span: Span, name: str, kind: str, spectrum: str, pair: str, when: str
) -> Diagnostic:
    """BG461: a storage field whose energy can be negative"""
    must = "positive definite" if kind == "I" else "positive semidefinite"
    return warning(
        "BG461",
        f"the matrix of `{name}`, {with_article(kind)} field, is not {must}{when}: it has "
        f"{spectrum}",
        span,
        note=pair,
        help="correct the matrix: all entries must refer to the same point and the same axes",
    )


def active_field(span: Span, name: str, spectrum: str, power: str, pair: str) -> Diagnostic:
    """BG462: a resistor field that supplies power"""
    return warning(
        "BG462",
        f"`{name}` supplies power{power}: the symmetric part of its matrix has {spectrum}",
        span,
        note=pair,
        help="correct the entries, or omit their coupling: the symmetric part of a resistor's "
        "matrix is positive semidefinite",
    )


def active_law(span: Span, name: str, at: str, answer: str, power: float) -> Diagnostic:
    """BG463: a resistor law that supplies power"""
    return warning(
        "BG463",
        f"`{name}` supplies power: {at} its law gives {answer}, that is {power:.4g} W",
        span,
        help="write a law whose effort has the sign of its flow, for example `e = d*abs(f)*f`; "
        "model a constant part by a source, Se or Sf",
    )


def energy_not_convex(span: Span, name: str, spectrum: str, at: str) -> Diagnostic:
    """BG464: an inertia that is negative in some states"""
    return warning(
        "BG464",
        f"the inertia of `{name}` is not positive {at}: {spectrum}",
        span,
        help="the energy must be convex in the momentum: check its signs",
    )


def listed_direction(variable: str, direction: Sequence[float]) -> str:
    """Name the components of a direction: `f[3] = 1, f[5] = 0.083`."""
    wide = len(direction) > 1
    return ", ".join(
        f"{variable}[{k}] = {component:.3g}" if wide else f"{variable} = {component:.3g}"
        for k, component in enumerate(direction, 1)
        if abs(component) >= 5e-4
    )
