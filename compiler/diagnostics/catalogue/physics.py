"""Diagnostics of laws that are not passive: warnings, and errors under `--strict`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning, with_article
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def not_symmetric(
    span: Span, name: str, place: tuple[int, int], entry: float, mirror: float, when: str
) -> Diagnostic:
    """BG445: a storage field that is not symmetric

    What: the matrix of a C or I field is not symmetric. For a nonlinear law with several ports this
    is the matrix of slopes: `de[1]/dq[2]` differs from `de[2]/dq[1]`. A run whose parameters make a
    symmetric matrix of a linear field asymmetric is refused.

    Why: such a law has no stored energy: a closed path in its state space would create energy
    (Maxwell's reciprocity).

    Example: `field : C[2](stiffness = [[3, 2], [0, 3]]);`

    Way out: correct the matrix, or give the energy, `C[2] { H = ..; }`; the law derived from it is
    symmetric. An MGY with a skew matrix exchanges power without storing it. At run time set both
    entries, `--set "G[1,2]=2" --set "G[2,1]=2"`, or compute both from one parameter in the model.
    """
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
    """BG460: a negative resistance, inertia or compliance

    What: the value of a one-port R, C or I, or a diagonal entry of its matrix, is negative.

    Why: a negative resistance creates energy; a negative mass accelerates against the force; a
    negative stiffness stores negative energy. The sign is nearly always wrong.

    Example: `damper : R(-3 N*s/m);`

    Way out: change the sign. If the sign stands for a direction, reverse the arrow. To supply power
    use a source, Se or Sf.
    """
    return warning(
        "BG460",
        f"the {what} of `{name}` is negative{when}: {value:.6g}",
        span,
        help="change the sign; to supply power use a source, Se or Sf",
    )


def indefinite_storage(
    span: Span, name: str, kind: str, spectrum: str, pair: str, when: str
) -> Diagnostic:
    """BG461: a storage field whose energy can be negative

    What: at the parameters' values or at the start, the matrix of a C field has a negative
    eigenvalue, or that of an I field one that is not positive.

    Why: a motion along the eigenvector stores negative energy. The matrix of an I field must be
    positive definite, since it is inverted; that of a C field may be singular, but not negative in
    any direction.

    Example: `body : I[2]([[2, 3], [3, 2]]);`

    Way out: correct the entries that the message names: `abs(M[i, j])` is at most the square root
    of `M[i, i]*M[j, j]`. Added mass and rigid-body mass must refer to the same point and the same
    axes.
    """
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
    """BG462: a resistor field that supplies power

    What: the symmetric part of the matrix of an R field has a negative eigenvalue.

    Why: along that eigenvector it supplies power at any speed, so a simulation may grow without a
    physical cause. The usual case is a matrix fitted entry by entry, such as a vessel's damping.

    Example: `damping : R[2]([[1, 4], [4, 2]]);`

    Way out: correct the entries that the message names, or omit the coupling: `abs(D[i, j] + D[j,
    i])/2` is at most the square root of `D[i, i]*D[j, j]`. An MGY with a skew matrix exchanges
    power without dissipating it.
    """
    return warning(
        "BG462",
        f"`{name}` supplies power{power}: the symmetric part of its matrix has {spectrum}",
        span,
        note=pair,
        help="correct the entries, or omit their coupling: the symmetric part of a resistor's "
        "matrix is positive semidefinite",
    )


def active_law(span: Span, name: str, at: str, answer: str, power: float) -> Diagnostic:
    """BG463: a resistor law that supplies power

    What: at the flow or effort that the message names, the power into an R is negative. Laws are
    tested at values of both signs, from small to large.

    Why: a resistor only dissipates power. A law fitted to positive speeds often has the wrong sign
    outside that range, or ignores the sign of the flow.

    Example: `drag : R { e = 3*f^2; }`

    Way out: write an odd law, `e = 3*abs(f)*f`. Model a constant part of the law by a source.
    """
    return warning(
        "BG463",
        f"`{name}` supplies power: {at} its law gives {answer}, that is {power:.4g} W",
        span,
        help="write a law whose effort has the sign of its flow, for example `e = d*abs(f)*f`; "
        "model a constant part by a source, Se or Sf",
    )


def energy_not_convex(span: Span, name: str, spectrum: str, at: str) -> Diagnostic:
    """BG464: an inertia that is negative in some states

    What: the energy of an I or IC is not convex in its momentum, or the flow of a nonlinear I falls
    as its momentum grows. The message names the state: the start, or a random state near it.

    Why: the inertia is negative there: a force accelerates it in the opposite direction.

    Example: `rotor : I { H = -p^2/(2*J); }`

    Way out: correct the energy; its second derivative with respect to the momentum is the inverse
    inertia.
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
