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
    """BG525: a closed chain whose constraints change in number

    What: the rows that close a chain of rigid connections are not independent, and no fixed choice
    of them is independent at the start and at random closed configurations.
    Why: a redundant row can be dropped only if it follows from the same other rows in every
    position. This can be examined only where `project x = value` of a signal states when the chain
    is closed.
    Example: a planar linkage on mounts in general directions, closed by bonds alone.
    Way out: close the chain with `Weld`, which says when it is closed, or make one joint compliant.
    """
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
    """BG526: a chain that is not closed at the start

    What: the initial values of the states leave a gap in a closed chain, and those that are not
    given cannot close it.
    Why: the connection is rigid, so a gap at the start would remain.
    Example: a four-bar linkage with all four angles given, one of them wrong.
    Way out: leave as many initial values ungiven as the chain has constraints (an `angle0` that
    nothing sets), or give the values that the message lists. Given values may be off by 1e-3 (m,
    rad): they count as rounded, and are moved.
    """
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
    """BG550: mounts that contradict each other in a closed chain

    What: no position of the joints closes the chain. A gap stays, although the chain is not at the
    end of its reach.
    Why: a planar linkage in space closes, and moves, because the axes of all its joints are
    parallel. Mounts and axes that are wrong by a little hold it instead. Up to 1e-6 (m, rad) counts
    as rounded data, and the constraints that follow from others are dropped.
    Example: a four-bar linkage with a quarter turn written as 1.57 at one of its pins.
    Way out: correct the mount or the axis, or write it in seven digits or more. It is between the
    body that the message names and the joints before it. Where none is named, the joints agree with
    each other, and a mount before the first joint, behind the last one or at the `Weld` does not
    fit.
    """
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
    """BG527: a start at a singular position

    What: at the start the constraints of a closed chain depend on each other, and elsewhere they
    do not.
    Why: there the chain can move in more than one way (the change point of a parallelogram), or
    the efforts in it have no bound (a dead centre): its motion is undetermined.
    Example: a parallelogram linkage that starts with all its bars in one line.
    Way out: start at another position, or make one joint compliant.
    """
    return error(
        "BG527",
        f"the closed chain through {listed(names)} starts at a singular position",
        span,
        help="start at another position, or make one of its joints compliant",
    )


def not_kept(span: Span, name: str) -> Diagnostic:
    """BG528: a projected signal that the bonds do not keep

    What: `project x = value` of a signal says that the bonds keep x at this value. The rate of x is
    not zero, or x depends on a momentum, an input or an unknown of an algebraic loop.
    Why: projecting the states would change the model: a constraint has to act by an effort.
    Example: `signal gap = height; project gap = 0;` without a rigid connection that holds it.
    Way out: add the rigid connection (an `Sf` of value zero), or remove the statement.
    """
    return error(
        "BG528",
        f"the bonds do not keep `{name}` at this value",
        span,
        help="hold it by a rigid connection, or remove the projection",
    )


def redundant_rows(span: Span, names: Sequence[str], count: int) -> Diagnostic:
    """BG529: a closed chain that is held more than once

    What: some constraints of a closed chain follow from the others wherever the chain is closed.
    Why: the motion is determined, and the share of each constraint in the efforts within the chain
    is not. Those of the redundant ones are taken as zero.
    Example: a planar four-bar linkage of revolute joints in space, three of whose six constraints
    are redundant.
    Way out: nothing, unless an effort within the chain matters: then replace revolute joints by
    spherical ones, or make a joint compliant.
    """
    return warning(
        "BG529",
        f"the closed chain through {listed(names)} has {count} redundant constraint"
        f"{'s' if count > 1 else ''}: efforts within it are undetermined",
        span,
        help="use joints that hold less, or a compliant one, if such an effort matters",
    )


def input_moves_chain(names: Sequence[str]) -> Diagnostic:
    """BG534: a linearisation by an input that a closed chain depends on

    What: a linearisation by a source or parameter that a closed chain of rigid connections depends
    on: the rate in one of its constraints, or a length.
    Why: the chain follows such an input at once, and its states are not functions of others alone.
    Example: `bgc bode` by the length of a coupler.
    Way out: take an effort or a flow outside the chain as input, or make one joint compliant.
    """
    return error(
        "BG534",
        f"the closed chain through {listed(names)} depends on an input of the linearisation",
        None,
        help="take another input, or make one joint of the chain compliant",
    )


def moved_start(span: Span, name: str, variable: str, value: float) -> Diagnostic:
    """BG546: a given flow or momentum that closing a chain moves

    What: the initial flows that are given do not close a closed chain, so the chain would start
    with other flows.

    Why: the momenta of the start are projected onto the flows that keep the chain closed. Which of
    its rows are independent is known only where its positions are closed.

    Example: a pendulum whose rod `project` holds, with `f0` of its horizontal momentum alone.

    Way out: give values to all inertias of the chain that together keep it closed, or give none.
    """
    return error(
        "BG546",
        f"the closed chain moves `{variable}` of `{name}`, which would start at {value:.6g}",
        span,
        help="give all inertias of the chain values that keep it closed, or give this value",
    )


def singular_chain(time: float, parts: str) -> Diagnostic:
    """BG735: a closed chain at a singular position

    What: a closed chain of rigid connections has reached a position at which its constraints depend
    on each other, and the run cannot go on.

    Why: at a change point the chain could continue in more than one way; at a dead centre the
    efforts in it have no bound. Which way it goes depends on play and elasticity, which a rigid
    model does not have.

    Example: a parallelogram linkage of rigid bars whose bars come to lie in one line.

    Way out: make one joint of the chain compliant, or keep the motion away from the position.
    """
    chain = f" through {listed(parts.split(', '))}" if parts else ""
    return error(
        "BG735",
        f"at t = {time:.9g} s the closed chain{chain} is at a singular position",
        help="make one of its joints compliant, or keep the motion away from this position",
    )


def open_chain(condition: str) -> Diagnostic:
    """BG736: parameters for which a chain does not close at the start

    What: with these parameters the initial values leave a gap in a closed chain of rigid
    connections, and those that are not given cannot close it.

    Why: the connection is rigid, so a gap at the start would remain.

    Example: a four-bar linkage whose coupler is set longer than the others can reach.

    Way out: give other lengths or initial values; leave as many initial values ungiven as the chain
    has constraints (an `angle0` that nothing sets).
    """
    return error(
        "BG736",
        f"the chain is not closed at the start: no initial values satisfy `{condition}`",
        help="give other lengths or initial values, or leave more initial values ungiven",
    )
