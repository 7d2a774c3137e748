"""A start at rest, as a run reports it."""

from __future__ import annotations

from collections.abc import Iterator

from bgc.diagnostics.records import dataclass


@dataclass(frozen=True, slots=True)
class Move:
    """A state or parameter that a start at rest has changed; values in SI units."""

    name: str
    unit: str
    before: float
    after: float


@dataclass(frozen=True, slots=True)
class AtRest:
    """A start at rest.

    Attributes
    ----------
    residual
        The largest rate that remains, as the change of a state, in its scale, that would cancel it.
    moves
        States by the size of their change in their scales, largest first; unchanged ones are left
        out.
    varied
        The parameters that were varied.
    """

    residual: float
    moves: tuple[Move, ...]
    varied: tuple[Move, ...]


def described(found: AtRest, most: int = 3) -> Iterator[str]:
    """Yield the lines of a run's summary: the residual, the largest moves, varied parameters."""
    moves = [
        f"{move.name} by {move.after - move.before:.4g}{_unit(move.unit)}"
        for move in found.moves[:most]
    ]
    more = len(found.moves) - len(moves)
    shown = ", ".join(moves) + (f" and {more} more" if more else "")
    yield f"starts at rest, rates are zero to {found.residual:.0e}; moved {shown or 'nothing'}"
    for move in found.varied:
        given, chosen = f"{move.before:.6g}", f"{move.after:.6g}{_unit(move.unit)}"
        yield f"  {move.name} = {chosen}, given as {given}"


def _unit(unit: str) -> str:
    """A unit behind a number, with a blank before it; empty for a plain number."""
    return f" {unit}" if unit not in ("", "1") else ""
