"""Diagnostics of laws that no passive part could have: warnings, errors under `--strict`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import warning, with_article
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def not_symmetric(
    span: Span, name: str, place: tuple[int, int], entry: float, mirror: float, when: str
) -> Diagnostic:
    """BG445: a storage field that is not symmetric

    What: the matrix of a C or I field is not symmetric. Of a nonlinear law with several ports it
    is the matrix of slopes, as `de[1]/dq[2]` against `de[2]/dq[1]`.

    Why: then there is no energy that it stores: round a closed path in its state it would make
    power out of nothing (Maxwell's reciprocity).

    Example: `field : C[2](stiffness = [[3, 2], [0, 3]]);`

    Way out: correct the matrix, or give the energy, `C[2] { H = ..; }`, from which a law is
    derived that is symmetric by construction. What turns power round without storing it is an
    MGY with a skew matrix.
    """
    row, column = place
    return warning(
        "BG445",
        f"the matrix of `{name}` is not symmetric{when}: entry [{row}, {column}] is {entry:.6g}, "
        f"[{column}, {row}] is {mirror:.6g}, a difference of {entry - mirror:.6g}",
        span,
        note="a storage element whose matrix is not symmetric has no energy",
        help="correct the matrix, or give the energy, `{ H = ..; }`; what only turns power round "
        "is an MGY with a skew matrix",
    )


def negative_value(span: Span | None, name: str, what: str, value: float, when: str) -> Diagnostic:
    """BG460: a negative resistance, inertia or compliance

    What: the number of a one-port R, C or I, or an entry of a diagonal matrix, is negative.

    Why: a negative resistance gives power without end; a negative mass runs towards what pushes
    it; a negative stiffness stores less than nothing. Nearly always a sign is wrong.

    Example: `damper : R(-3 N*s/m);`

    Way out: turn the sign. Where the sign stands for a direction, turn the arrow. What is meant to
    give power is a source, Se or Sf.
    """
    return warning(
        "BG460",
        f"the {what} of `{name}` is negative{when}: {value:.6g}",
        span,
        help="turn the sign; what is meant to give power is a source, Se or Sf",
    )


def indefinite_storage(
    span: Span, name: str, kind: str, spectrum: str, pair: str, when: str
) -> Diagnostic:
    """BG461: a storage field whose energy may fall below zero

    What: the matrix of a C field has a negative eigenvalue, or that of an I field one that is not
    positive, at the parameters' values or at the start.

    Why: moving along the eigenvector, it would store negative energy. An I field must be positive
    definite, since its motion is found by dividing by its matrix; a C field may have directions
    without stiffness, but none with a negative one.

    Example: `body : I[2]([[2, 3], [3, 2]]);`

    Way out: look at the entries that the message names. `M[i, j]` is at most the root of
    `M[i, i]` times `M[j, j]`. Added mass and rigid-body mass must belong to one point and to the
    same axes.
    """
    must = "positive definite" if kind == "I" else "positive semidefinite"
    return warning(
        "BG461",
        f"the matrix of `{name}`, {with_article(kind)} field, is not {must}{when}: {spectrum}",
        span,
        note=pair,
        help="correct the matrix: its entries must belong to one point and to the same axes",
    )


def active_field(span: Span, name: str, spectrum: str, power: str, pair: str) -> Diagnostic:
    """BG462: a resistor field that makes power

    What: the symmetric part of the matrix of an R field has a negative eigenvalue.

    Why: along that eigenvector it gives power instead of taking it, whatever the speed: damping
    that is active. Simulations with it may grow without a cause. Matrices fitted one entry at a
    time, as a vessel's damping often is, are the usual case.

    Example: `damping : R[2]([[1, 4], [4, 2]]);`

    Way out: `|D[i, j] + D[j, i]| / 2` is at most the root of `D[i, i]` times `D[j, j]`: correct
    the entries that the message names, or leave out the coupling. What turns power round without
    taking it is an MGY with a skew matrix.
    """
    return warning(
        "BG462",
        f"`{name}` makes power{power}: the symmetric part of its matrix has {spectrum}",
        span,
        note=pair,
        help="a resistor's symmetric part is positive semidefinite: correct the entries, or leave "
        "out their coupling",
    )


def active_law(span: Span, name: str, at: str, answer: str, power: float) -> Diagnostic:
    """BG463: a resistor law that makes power

    What: at a flow or effort that the message names, effort times flow of an R is negative. Laws
    are tried at values of both signs, from small to large ones.

    Why: a resistor only takes power. A law that is fitted to a range of positive speeds often
    turns its sign outside it, or misses the sign of the flow.

    Example: `drag : R { e = 3*f^2; }`

    Way out: write an odd law, `e = 3*abs(f)*f`. A constant part of the law belongs to a source.
    """
    return warning(
        "BG463",
        f"`{name}` makes power: {at} its law gives {answer}, which is {power:.4g} W out",
        span,
        help="write a law whose effort has the sign of its flow, as `e = d*abs(f)*f`; a constant "
        "part is a source, Se or Sf",
    )


def energy_not_convex(span: Span, name: str, spectrum: str, at: str) -> Diagnostic:
    """BG464: an inertia that is negative in some state

    What: the energy of an I or IC is not convex in its momentum, or the flow of a nonlinear I
    falls as its momentum grows, in the state that the message names: the start, or a random one
    about it.

    Why: there the inertia is negative, and pushing it one way speeds it up the other way.

    Example: `rotor : I { H = -p^2/(2*J); }`

    Way out: correct the energy; the second derivative by the momentum is the inverse inertia.
    """
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
