"""Diagnostics: closed chains."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import Values, error, listed, underlined, warning
from bgc.diagnostics.catalogue.causality import Connection
from bgc.diagnostics.diagnostic import Fault, Label
from bgc.diagnostics.source import Span

_LISTED = 12  # states that a message lists
_MOVED = 1e-6  # m, rad: less is the rounding of mounts in seven digits


@error(
    "BG525: the constraints of the closed chain through {names:listed} are not independent",
    "close the chain with `Weld`, or make one of its joints compliant",
    fault=Fault.CHOICE,
)
def changing_rank(
    span: Span, transformers: Sequence[Connection], others: Sequence[Connection]
) -> Values:
    names = list(dict.fromkeys(c.name for c in (*transformers, *others)))
    labels = [Label(c.span, f"`{c.name}` is in the chain") for c in (*transformers, *others)]
    return {"names": names, "labels": underlined(labels)}


@error(
    "BG526: the chain is not closed at the start: `{name}` is off by {misfit:.3g}",
    "leave some of the initial values ungiven, or give values that close the chain",
)
def open_start(span: Span, name: str, misfit: float, ways: Sequence[tuple[str, float]]) -> Values:
    return {"note": f"the nearest closed start has {_values(ways)}" if ways else ""}


def _values(states: Sequence[tuple[str, float]]) -> str:
    """States with their values, SI."""
    shown = [f"`{state}` = {value:.6g}" for state, value in states[:_LISTED]]
    more = f" and {len(states) - _LISTED} more" if len(states) > _LISTED else ""
    return ", ".join(shown) + more


@error(
    "BG550: mounts in the closed chain contradict each other: `{name}` stays off by {misfit:.3g}",
    "correct the mount or the axis there, or write it in seven digits or more",
)
def contradicting_mounts(span: Span, name: str, misfit: float, body: str | None) -> Values:
    return {
        "note": (
            f"`{body}` is the first body that does not move in the directions of its joints alone"
            if body
            else "the joints agree with each other; the mounts at the ends of the chain do not fit"
        )
    }


@error(
    "BG527: the closed chain through {names:listed} starts at a singular position",
    "start at another position, or make one of its joints compliant",
)
def singular_start(span: Span, names: Sequence[str]) -> None: ...
@error(
    "BG528: the bonds do not keep `{name}` at this value",
    "hold it by a rigid connection, or remove the projection",
    fault=Fault.CHOICE,
)
def not_kept(span: Span, name: str) -> None: ...
@warning(
    "BG529: the closed chain through {names:listed} has {count} redundant {noun}: efforts "
    "within it "
    "are undetermined",
    "use joints that hold less, or a compliant one, if such an effort matters",
)
def redundant_rows(span: Span, names: Sequence[str], count: int) -> Values:
    return {"noun": "constraints" if count > 1 else "constraint"}


@error(
    "BG534: the closed chain through {names:listed} depends on an input of the linearisation",
    "take another input, or make one joint of the chain compliant",
)
def input_moves_chain(names: Sequence[str]) -> None: ...
@error(
    "BG546: the closed chain moves `{variable}` of `{name}`, which would start at {value:.6g}",
    "give all inertias of the chain values that keep it closed, or give this value",
)
def moved_start(span: Span, name: str, variable: str, value: float) -> None: ...
@warning(
    "BG551: the closed chain moves initial values that are given: {shown}{more}",
    "give values with more digits, or leave as many ungiven as the chain has constraints",
)
def moved_positions(moves: Sequence[tuple[str, float, str]]) -> Values:
    """Name what gives each state that moved, its move in SI units, and its unit."""
    shown = [f"`{name}` by {move:.3g} {unit}" for name, move, unit in moves[:3]]
    more = f" and {len(moves) - 3} more" if len(moves) > 3 else ""
    return {"shown": ", ".join(shown), "more": more}


def named_moves(
    moves: Iterable[tuple[float, str, str, str]],
) -> list[tuple[str, float, str]]:
    """The moves of states that are more than rounding, the largest first, for `moved_positions`.

    Each move is given with the name of the given value, or an empty one, and the name and unit of
    the state.
    """
    found = [(given or name, x, unit) for x, given, name, unit in moves if abs(x) > _MOVED]
    return sorted(found, key=lambda move: -abs(move[1]))


@error(
    "BG735: at t = {time:.9g} s the closed chain{chain} is at a singular position",
    "make one of its joints compliant, or keep the motion away from this position",
)
def singular_chain(time: float, parts: str, position: Sequence[tuple[str, float]]) -> Values:
    chain = f" through {listed(parts.split(', '))}" if parts else ""
    return {"chain": chain, "note": f"there {_values(position)}" if position else ""}


@error(
    "BG736: the chain is not closed at the start: no initial values satisfy `{condition}`",
    "give other lengths or initial values, or leave more initial values ungiven",
)
def open_chain(condition: str) -> None: ...
