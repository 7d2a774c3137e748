"""A start at rest, as a run reports it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from bgc.printing.text_tables import Table, as_text

Fixed: TypeAlias = Literal["joined", "conserved", "kept", "nearest"]

_ROUNDING = 1e-9  # of a value
_SHOWN = 3  # names in a line of the summary


@dataclass(frozen=True, slots=True)
class Move:
    """A state or parameter that a start at rest has changed; values in SI units.

    `given` is what the model gives of a state: a parameter or `q0 of spring`; empty for nothing.
    """

    name: str
    unit: str
    before: float
    after: float
    given: str = ""


@dataclass(frozen=True, slots=True)
class Free:
    """A direction that rest leaves free, named by the state that moves most, and what fixes it.

    `joined`: a relation between positions, such as the stretch of a spring and the place of its
    end; `conserved`: a quantity that no motion changes, such as trapped oil; `kept`: the state
    stays at its start; `nearest`: it changes least.
    """

    name: str
    fixed: Fixed


@dataclass(frozen=True, slots=True)
class AtRest:
    """A start at rest; printed, it is a table of all of it.

    Attributes
    ----------
    residual
        The largest rate that remains, as the change of a state, in its scale, that would cancel it.
    moves
        States by the size of their change in their scales, largest first; unchanged ones are left
        out.
    varied
        The parameters that were varied.
    free
        The directions that the equations of rest leave free.
    tipped
        The elements whose laws are on another piece than at the start: a valve that opens, a stop
        that touches, a brake that slips.
    """

    residual: float
    moves: tuple[Move, ...]
    varied: tuple[Move, ...]
    free: tuple[Free, ...] = ()
    tipped: tuple[str, ...] = ()

    @property
    def given(self) -> tuple[Move, ...]:
        """The moves of states that the model gives, without rounding."""
        moves = (move for move in self.moves if move.given)
        return tuple(m for m in moves if abs(m.after - m.before) > _ROUNDING * abs(m.before))

    def __str__(self) -> str:
        moves = [
            (m.name, f"{m.before:.6g}", f"{m.after:.6g}", f"{_change(m)}", m.given)
            for m in (*self.moves, *self.varied)
        ]
        free = [(free.name, free.fixed) for free in self.free]
        return as_text(
            [
                Table("Moved to rest", ("", "from", "to", "by", "given by"), tuple(moves)),
                Table("Left free by rest", ("", "fixed"), tuple(free)),
                Table("Switched on the way to rest", ("",), tuple((n,) for n in self.tipped)),
            ]
        )


def described(found: AtRest) -> Iterator[str]:
    """Yield the lines of a run's summary, each of a few names."""
    shown = _listed([_moved(move) for move in found.moves])
    yield f"starts at rest, rates are zero to {found.residual:.0e}; moved {shown or 'nothing'}"
    if found.given:
        yield f"  given values that moved: {_listed([_moved(move) for move in found.given])}"
    for fixed, words in (("kept", "keeps"), ("nearest", "changes least")):
        names = [free.name for free in found.free if free.fixed == fixed]
        if names:
            yield f"  what rest leaves free {words}: {_listed(names)}"
    if found.tipped:
        yield f"  switched on the way to rest: {_listed(found.tipped)}"
    for move in found.varied:
        given, chosen = f"{move.before:.6g}", f"{move.after:.6g}{_unit(move.unit)}"
        yield f"  {move.name} = {chosen}, given as {given}"


def _moved(move: Move) -> str:
    return f"{move.name} by {_change(move)}"


def _change(move: Move) -> str:
    return f"{move.after - move.before:.4g}{_unit(move.unit)}"


def _listed(parts: Sequence[str]) -> str:
    more = len(parts) - _SHOWN
    return ", ".join(parts[:_SHOWN]) + (f" and {more} more" if more > 0 else "")


def _unit(unit: str) -> str:
    """A unit behind a number, with a blank before it; empty for a plain number."""
    return f" {unit}" if unit not in ("", "1") else ""
