"""The reference solution for errors, on which two methods must agree."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from bgc.diagnostics.catalogue.trade import no_reference
from bgc.diagnostics.diagnostic import BgError
from bgc.language.solver import Solver
from bgc.record_class import dataclass, replace
from bgc.runtime.measuring.instants import Instants
from bgc.runtime.measuring.judging import (
    METHODS,
    RTOLS,
    Quantity,
    combined,
    quantities_of,
)
from bgc.runtime.measuring.timed_run import Run
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.subtolerance import Probe, Subtolerance, is_repeatable

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
) -> Reference:
    """Tighten the tolerances of two methods as long as that improves their agreement.

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

    Raises
    ------
    BgError
        BG092: fewer than two methods complete the run.
    """
    end = time.monotonic() + seconds
    methods = list(METHODS)  # the first two that complete the run
    reasons: list[str] = []
    best: Reference | None = None
    levels: list[tuple[float, tuple[float, ...]]] = []
    for rtol in RTOLS:
        runs: dict[str, Run] = {}
        for name in list(methods):
            left = end - time.monotonic()
            # A method that does not complete the run leaves time for the next one.
            limit = left if runs or best is not None else left / 2
            run = solve(Solver(name, rtol=rtol), limit)
            if run.status == "done":
                runs[name] = run
            elif best is None:
                methods.remove(name)
                reasons.append(f"{name}: {run.message}")
            if len(runs) == 2 or (best is not None and run.status != "done"):
                break
        if len(runs) < 2:
            break
        methods = list(runs)
        found = _compared(model, requirements, instants, runs, rtol)
        levels.append((rtol, found.agreement))
        best = found if best is None or found.accuracy < best.accuracy else best
        # The next level takes about three times as long as this one.
        if best.accuracy < _ROUNDING or end - time.monotonic() < 6 * found.seconds:
            break
    if best is None:
        raise BgError([no_reference(reasons)])
    return replace(best, levels=tuple(levels))


def with_doubt(
    model: LoadedModel,
    requirements: Mapping[str, float],
    reference: Reference,
    subtolerance: Sequence[Subtolerance],
) -> Reference:
    """Add to the differences what a shift of states below their tolerance by it changes.

    Where rounding decides a state, two methods may agree on a wrong solution. `subtolerance` are
    the states of the first method's run that fell below their tolerance.
    """
    if not subtolerance or not is_repeatable(model):
        return reference
    instants, agreement = reference.instants, reference.agreement
    by = instants.capped(model, Solver(reference.methods[0], rtol=reference.rtol))
    for shifted in Probe(model, by, instants.times).shifted(subtolerance):
        moved = np.nan_to_num(instants.errors(shifted, reference.rows), nan=np.inf)
        agreement = tuple(max(pair) for pair in zip(agreement, moved.tolist(), strict=True))
    quantities = quantities_of(model.measured, reference.rows, requirements)
    return replace(reference, agreement=agreement, accuracy=combined(agreement, quantities))


def _compared(
    model: LoadedModel,
    requirements: Mapping[str, float],
    instants: Instants,
    runs: Mapping[str, Run],
    rtol: float,
) -> Reference:
    (one, first), (other, second) = runs.items()
    quantities: tuple[Quantity, ...] = quantities_of(model.measured, first.rows, requirements)
    agreement = instants.errors(second.rows, first.rows)
    return Reference(
        first.rows,
        instants,
        (one, other),
        rtol,
        agreement,
        combined(agreement, quantities),
        (),
        max(first.seconds, second.seconds),
        bool(requirements),
    )
