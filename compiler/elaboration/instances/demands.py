"""Computes values and parts that need each other, in any order and at any depth.

A definition may lead to another, that one to a third, along a whole chain of parts. Following
them within each other would need a stack as deep as the chain is long. Where little is left of
Python's stack, the computations under way are put aside instead: what they need is computed
first, with an empty stack, and then they begin anew. A computation must therefore be repeatable:
it may change shared tables only after its last demand.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Protocol, TypeVar

from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.tree import Status

_FRAMES = 650
"""The most frames of Python's stack that one computation takes up to its next demand: 600 for
an expression, whose nesting is bounded, the others for what is around it."""

T = TypeVar("T")


class Demand(Protocol):
    """A value or part that is computed at its first use."""

    status: Status


class _PutAsideError(Exception):
    """Unwinds the computations under way, to compute first what they need."""

    def __init__(self, demand: Demand, compute: Callable[[], object]) -> None:
        self.demand = demand
        self.compute = compute
        super().__init__()


class Demands:
    """The computations under way.

    Attributes
    ----------
    under_way
        What is being computed or was put aside, each of which needs the next one. A further
        demand for one of them is a definition in terms of itself.
    """

    def __init__(self) -> None:
        self.under_way: list[Demand] = []
        self._running = 0

    def meet(self, demand: Demand, compute: Callable[[], T]) -> T:
        """Return what `compute` does, which leaves the status of the demand as it is to be.

        Where that raises BgError, the demand has failed; with any other exception it is NEW
        again.
        """
        if self._running:
            if _is_stack_short():
                raise _PutAsideError(demand, compute)
            return self._run(demand, compute)
        try:
            while True:
                try:
                    return self._run(demand, compute)
                except _PutAsideError as needed:
                    self._meet_first(needed)
        finally:
            self._reopen(0)

    def _meet_first(self, needed: _PutAsideError) -> None:
        """Compute what made others wait, and whatever makes it wait in turn."""
        waiting = [needed]
        starts = [len(self.under_way)]
        while waiting:
            try:
                self._run(waiting[-1].demand, waiting[-1].compute)
            except _PutAsideError as deeper:
                waiting.append(deeper)
                starts.append(len(self.under_way))
                continue
            except BgError:
                pass  # those that need it find that it has failed
            waiting.pop()
            starts.pop()
            self._reopen(starts[-1] if starts else 0)

    def _run(self, demand: Demand, compute: Callable[[], T]) -> T:
        demand.status = Status.OPEN
        self.under_way.append(demand)
        self._running += 1
        try:
            result = compute()
        except _PutAsideError:
            raise  # it stays open
        except BaseException as reason:
            demand.status = Status.FAILED if isinstance(reason, BgError) else Status.NEW
            self.under_way.pop()
            raise
        finally:
            self._running -= 1
        self.under_way.pop()
        return result

    def _reopen(self, start: int) -> None:
        """Let the computations that were put aside begin anew, from a place on."""
        for demand in self.under_way[start:]:
            demand.status = Status.NEW
        del self.under_way[start:]


def _is_stack_short() -> bool:
    """Whether one computation more might exceed Python's stack."""
    try:
        sys._getframe(sys.getrecursionlimit() - _FRAMES)
    except ValueError:  # the stack is not that deep
        return False
    return True
