"""The reference solution for errors, on which two methods must agree."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from bgc.diagnostics.catalogue.trade import no_reference
from bgc.diagnostics.diagnostic import BgError
from bgc.language.solver import Solver
from bgc.record_class import dataclass, replace
from bgc.runtime.measuring.agreement import Agreement, agreements
from bgc.runtime.measuring.instants import Instants
from bgc.runtime.measuring.judging import Quantity, combined, quantities_of
from bgc.runtime.measuring.timed_run import Run
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded_model import LoadedModel

_ROUNDING = 1e-12  # an agreement that no tighter tolerance improves
_OF_REQUIRED = 0.1
_OF_RANGE = 1e-4

Solve = Callable[[Solver, float], Run]
"""Run a method for at most the given number of seconds."""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A solution, its values (n, m) at `instants`, and the difference of two methods at `rtol`.

    `agreement` is the largest difference of each quantity, in its unit; `accuracy` is the combined
    difference, scaled as combined errors are. `levels` has the agreement at each tolerance that
    was tried. `seconds` is the time of the slower method.
    """

    rows: Array
    instants: Instants
    methods: tuple[str, str]
    rtol: float
    agreement: tuple[float, ...]
    accuracy: float
    levels: tuple[tuple[float, tuple[float, ...]], ...]
    seconds: float
    required: bool

    @property
    def converged(self) -> bool:
        """True if the methods agree to a tenth of the requirements, or to 1e-4 of the range."""
        return self.accuracy <= (_OF_REQUIRED if self.required else _OF_RANGE)

    def rescaled(self, quantities: Sequence[Quantity], required: bool) -> Reference:
        """Return the same reference for other quantities, or other requirements on them."""
        accuracy = combined(self.agreement, quantities)
        return replace(self, accuracy=accuracy, required=required)


def find_reference(
    model: LoadedModel,
    requirements: Mapping[str, float],
    instants: Instants,
    solve: Solve,
    seconds: float,
    enough: float = _ROUNDING,
) -> Reference:
    """Tighten the tolerances of two methods as long as that improves their agreement.

    Where rounding decides a state, two methods may agree on a wrong solution: a shift of states
    that fell below their tolerance adds what it changes to the differences.

    Parameters
    ----------
    model
        The model, for the names of its outputs.
    requirements
        Required accuracies by the names of outputs.
    instants
        Where the methods are compared.
    solve
        Runs a method of the model to the instants.
    seconds
        The approximate time for all runs.
    enough
        The agreement from which on no tighter tolerance is tried, scaled as combined errors are.

    Raises
    ------
    BgError
        BG092: fewer than two methods complete the run.
    """
    end = time.monotonic() + seconds
    reasons: list[str] = []
    completed = False

    def timed(method: Solver) -> Run:
        nonlocal completed
        # A method that does not complete the run leaves time for the next one.
        left = end - time.monotonic()
        run = solve(method, left if completed else left / 2)
        if run.status == "done":
            completed = True
        else:
            reasons.append(f"{method.name}: {run.message}")
        return run

    def error(rows: Array, reference: Array) -> float:
        quantities = quantities_of(model.measured, reference, requirements)
        return combined(instants.errors(rows, reference), quantities)

    found: list[Agreement] = []
    for level in agreements(timed, error):
        found.append(level)
        best = min(found, key=lambda level: level.accuracy)
        # The next level takes about three times as long as this one.
        if best.accuracy < enough or end - time.monotonic() < 6 * _seconds(level):
            break
    if not found:
        raise BgError([no_reference(reasons)])
    levels = tuple((level.by.rtol, _differences(level, instants)) for level in found)
    agreement = _with_doubt(model, instants, best, _differences(best, instants))
    return Reference(
        best.run.rows,
        instants,
        (best.by.name, best.other_by.name),
        best.by.rtol,
        agreement,
        combined(agreement, quantities_of(model.measured, best.run.rows, requirements)),
        levels,
        _seconds(best),
        bool(requirements),
    )


def _seconds(level: Agreement) -> float:
    return max(level.run.seconds, level.other.seconds)


def _differences(level: Agreement, instants: Instants) -> tuple[float, ...]:
    return instants.errors(level.other.rows, level.run.rows)


def _with_doubt(
    model: LoadedModel, instants: Instants, best: Agreement, differences: tuple[float, ...]
) -> tuple[float, ...]:
    """Add to differences what a shift of states below their tolerance by it changes."""
    run = best.run
    probe = instants.probe(model, best.by, run)
    for shifted in probe.shifted(run.subtolerance) if probe is not None else ():
        moved = np.nan_to_num(instants.errors(shifted, run.rows), nan=np.inf)
        differences = tuple(max(pair) for pair in zip(differences, moved.tolist(), strict=True))
    return differences
