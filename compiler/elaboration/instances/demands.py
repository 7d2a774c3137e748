"""Compute values and parts that depend on each other, in any order and at any depth.

A chain of definitions may be longer than Python's stack allows for nested evaluation. Where little
of the stack is left, the pending computations are suspended: the value they need is computed first,
with an empty stack, and then they restart. A computation must therefore be repeatable: it may
change shared tables only after its last demand.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Protocol, TypeVar

from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.tree import Status

_FRAMES = 650
"""The most stack frames that one computation takes up to its next demand: 600 for an expression,
whose nesting is bounded, and 50 for its callers."""

T = TypeVar("T")


class Demand(Protocol):
    """A value or part that is computed when it is first needed."""

    status: Status


class _SuspendedError(Exception):
    """Unwinds the pending computations, to compute the demand that they need first."""

    def __init__(self, demand: Demand, compute: Callable[[], object]) -> None:
        self.demand = demand
        self.compute = compute
        super().__init__()


class Demands:
    """The pending computations.

    Attributes
    ----------
    under_way
        The demands that are being computed or suspended, each of which needs the next one. A
        further demand for one of them is a cyclic definition.
    """

    def __init__(self) -> None:
        self.under_way: list[Demand] = []
        self._running = 0

    def meet(self, demand: Demand, compute: Callable[[], T]) -> T:
        """Return the result of `compute`, which sets the final status of the demand.

        If `compute` raises BgError, the demand has FAILED; after any other exception it is NEW.
        """
        if self._running:
            if _is_stack_short():
                raise _SuspendedError(demand, compute)
            return self._run(demand, compute)
        try:
            while True:
                try:
                    return self._run(demand, compute)
                except _SuspendedError as needed:
                    self._meet_first(needed)
        finally:
            self._reopen(0)

    def _meet_first(self, needed: _SuspendedError) -> None:
        """Compute a demand that suspended others, and any demand that suspends it in turn."""
        waiting = [needed]
        starts = [len(self.under_way)]
        while waiting:
            try:
                self._run(waiting[-1].demand, waiting[-1].compute)
            except _SuspendedError as deeper:
                waiting.append(deeper)
                starts.append(len(self.under_way))
                continue
            except BgError:
                pass  # the computations that need it will find it FAILED
            waiting.pop()
            starts.pop()
            self._reopen(starts[-1] if starts else 0)

    def _run(self, demand: Demand, compute: Callable[[], T]) -> T:
        demand.status = Status.OPEN
        self.under_way.append(demand)
        self._running += 1
        try:
            result = compute()
        except _SuspendedError:
            raise  # the demand remains OPEN
        except BaseException as reason:
            demand.status = Status.FAILED if isinstance(reason, BgError) else Status.NEW
            self.under_way.pop()
            raise
        finally:
            self._running -= 1
        self.under_way.pop()
        return result

    def _reopen(self, start: int) -> None:
        """Mark the suspended demands from position `start` on as NEW, so that they restart."""
        for demand in self.under_way[start:]:
            demand.status = Status.NEW
        del self.under_way[start:]


def _is_stack_short() -> bool:
    """Return whether one more computation might exceed Python's stack."""
    try:
        sys._getframe(sys.getrecursionlimit() - _FRAMES)
    except ValueError:  # the stack is not that deep
        return False
    return True
