"""Two methods that agree: the search for a solution against which runs are judged."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.measuring.timed_run import Run
from bgc.runtime.results.arrays import Array

METHODS = ("radau5", "rodas5p", "rodas4p2", "dopri5")
"""Methods of references; those that come first complete most runs."""

RTOLS = (1e-8, 1e-10, 1e-12)
"""Tolerances of references, each tried where the one before is not enough."""

AT_THE_REFERENCE = 3.0
"""Times the accuracy of a reference: smaller errors may be its own."""


@dataclass(frozen=True, slots=True, eq=False)
class Agreement:
    """The runs of two methods at one tolerance; the first one is the reference.

    `accuracy` is the error of the other against it.
    """

    run: Run
    by: Solver
    other: Run
    other_by: Solver
    accuracy: float


def agreements(
    solve: Callable[[Solver], Run],
    error: Callable[[Array, Array], float],
    methods: Sequence[str] = METHODS,
    rtols: Sequence[float] = RTOLS,
    at_once: int = 2,
) -> Iterator[Agreement]:
    """Solve by methods at tighter and tighter tolerances, and compare those that complete the run.

    Each completed run yields the best agreement with those before it at its tolerance. The first
    `at_once` methods that complete a tolerance are the ones of the next; the search ends where
    fewer than two are left.

    Parameters
    ----------
    solve
        Runs a method.
    error
        The error of rows, (n, m), against those of a reference.
    methods, rtols
        Names of methods and relative tolerances in the order in which they are tried.
    at_once
        How many methods are compared at a tolerance.
    """
    compared = False
    for rtol in rtols:
        done: list[tuple[Run, Solver]] = []
        for place, name in enumerate(methods):
            by = Solver(name, rtol=rtol)
            run = solve(by)
            if run.status == "done":
                pairs = [
                    Agreement(one, one_by, run, by, error(run.rows, one.rows))
                    for one, one_by in done
                ]
                if pairs:
                    compared = True
                    yield min(pairs, key=lambda pair: pair.accuracy)
                done.append((run, by))
            elif compared and len(done) + len(methods[place + 1 :]) < 2:
                return
            if len(done) == at_once:
                break
        methods = [by.name for _, by in done]
        if len(methods) < 2:
            return
