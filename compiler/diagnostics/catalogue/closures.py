"""Diagnostics of closed chains."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed, underlined, warning
from bgc.diagnostics.catalogue.causality import Connection
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span

_LISTED = 12  # states that a message lists


def changing_rank(
    span: Span, transformers: Sequence[Connection], others: Sequence[Connection]
) -> Diagnostic:
    """BG525: a closed chain whose constraints change in number"""
    names = list(dict.fromkeys(c.name for c in (*transformers, *others)))
    labels = [Label(c.span, f"`{c.name}` is in the chain") for c in (*transformers, *others)]
    return error(
        "BG525",
        f"the constraints of the closed chain through {listed(names)} are not independent",
        span,
        labels=underlined(labels),
        help="close the chain with `Weld`, or make one of its joints compliant",
    )


def open_start(
    span: Span, name: str, misfit: float, ways: Sequence[tuple[str, float]]
) -> Diagnostic:
    """BG526: a chain that is not closed at the start"""
    shown = [f"`{state}` = {value:.6g}" for state, value in ways[:_LISTED]]
    more = f" and {len(ways) - _LISTED} more" if len(ways) > _LISTED else ""
    return error(
        "BG526",
        f"the chain is not closed at the start: `{name}` is off by {misfit:.3g}",
        span,
        note=f"the nearest closed start has {', '.join(shown)}{more}" if ways else "",
        help="leave some of the initial values ungiven, or give values that close the chain",
    )


def contradicting_mounts(span: Span, name: str, misfit: float, body: str | None) -> Diagnostic:
    """BG550: mounts that contradict each other in a closed chain"""
    return error(
        "BG550",
        f"mounts in the closed chain contradict each other: `{name}` stays off by {misfit:.3g}",
        span,
        note=f"`{body}` is the first body that does not move in the directions of its joints alone"
        if body
        else "the joints agree with each other; the mounts at the ends of the chain do not fit",
        help="correct the mount or the axis there, or write it in seven digits or more",
    )


def singular_start(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG527: a start at a singular position"""
    return error(
        "BG527",
        f"the closed chain through {listed(names)} starts at a singular position",
        span,
        help="start at another position, or make one of its joints compliant",
    )


def not_kept(span: Span, name: str) -> Diagnostic:
    """BG528: a projected signal that the bonds do not keep"""
    return error(
        "BG528",
        f"the bonds do not keep `{name}` at this value",
        span,
        help="hold it by a rigid connection, or remove the projection",
    )


def redundant_rows(span: Span, names: Sequence[str], count: int) -> Diagnostic:
    """BG529: a closed chain that is held more than once"""
    return warning(
        "BG529",
        f"the closed chain through {listed(names)} has {count} redundant constraint"
        f"{'s' if count > 1 else ''}: efforts within it are undetermined",
        span,
        help="use joints that hold less, or a compliant one, if such an effort matters",
    )


def input_moves_chain(names: Sequence[str]) -> Diagnostic:
    """BG534: a linearisation by an input that a closed chain depends on"""
    return error(
        "BG534",
        f"the closed chain through {listed(names)} depends on an input of the linearisation",
        None,
        help="take another input, or make one joint of the chain compliant",
    )


def moved_start(span: Span, name: str, variable: str, value: float) -> Diagnostic:
    """BG546: a given flow or momentum that closing a chain moves"""
    return error(
        "BG546",
        f"the closed chain moves `{variable}` of `{name}`, which would start at {value:.6g}",
        span,
        help="give all inertias of the chain values that keep it closed, or give this value",
    )


def singular_chain(time: float, parts: str) -> Diagnostic:
    """BG735: a closed chain at a singular position"""
    chain = f" through {listed(parts.split(', '))}" if parts else ""
    return error(
        "BG735",
        f"at t = {time:.9g} s the closed chain{chain} is at a singular position",
        help="make one of its joints compliant, or keep the motion away from this position",
    )


def open_chain(condition: str) -> Diagnostic:
    """BG736: parameters for which a chain does not close at the start"""
    return error(
        "BG736",
        f"the chain is not closed at the start: no initial values satisfy `{condition}`",
        help="give other lengths or initial values, or leave more initial values ungiven",
    )
