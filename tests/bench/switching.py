"""The choice between the implicit method and its explicit partner, against each of them alone.

    python tests/bench/switching.py [NAME ..]

runs the scenes of the library, the published problems and the mechanisms of `growing.py` by
`switching`, `rodas5p` and `dopri5` at three tolerances. Work is counted and not timed: calls of f,
J, LU and solutions, each with its operations, and what a stage and a step cost besides, as
`compiler/emission/explicit_cost.py` weighs them. The table has the work of `switching` over that of
the cheaper of the two, that of each of them over the same, and the errors of all three, the largest
of the observed quantities over their ranges, against `rodas5p` at 1e-10. Models in which explicit
steps cannot pay run by `rodas5p` alone, and have no row, unless `--all` is given.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
from growing import text_of
from measured_models import Source, error_of, models, scenes

from bgc.diagnostics.diagnostic import BgError
from bgc.emission.explicit_cost import attempt_operations, stage_operations
from bgc.emission.factorisation import factor_share
from bgc.runtime.model import Model
from bgc.runtime.results.result import Result

FOLDERS = ("library/scenes", "library/examples", "tests/models/ivp")
MECHANISMS = (
    "crane:2", "crane:4", "crane:8", "arm:3", "arm:6", "arm:12", "arm:24", "tree:7", "tree:15",
    "slides:6", "mixed:6", "chain:100", "circuit:100", "grid:10", "motors:20", "ladder:50",
)  # fmt: skip
TOLERANCES = (1e-3, 1e-4, 1e-6)
MOST_STEPS = 300_000  # of dopri5 by a bound on stability: stiffer models run without it
STABLE = 3.3  # step of dopri5 times the spectral radius
METHODS = ("switching", "rodas5p", "dopri5")


@dataclass(frozen=True)
class Weights:
    """Operations of a call, and of an attempt at a step besides."""

    rhs: float
    jacobians: float
    factorisations: float
    solves: float
    attempt: float

    @classmethod
    def of(cls, model: Model) -> Weights:
        stages = model._stages("emit")
        lowered, operations = stages.lowered, dict(stages.emitted.operations)
        share = factor_share(lowered)
        return cls(
            stage_operations(lowered, operations),
            operations["jacobian"],
            share * operations["factor"],
            share * operations["solve"],
            attempt_operations(lowered, operations),
        )

    def work(self, run: Result) -> float:
        """Operations of a run."""
        counts = run.counts
        called = sum(
            counts[name] * getattr(self, name)
            for name in ("rhs", "jacobians", "factorisations", "solves")
        )
        return called + self.attempt * (counts["steps"] + counts["rejected"])


def mechanisms() -> Iterator[Source]:
    """The mechanisms of `growing.py`, in files that last as long as the iteration."""
    with tempfile.TemporaryDirectory() as folder:
        for name in MECHANISMS:
            path = Path(folder) / f"{name.replace(':', '_')}.bg"
            path.write_text(text_of(name), "utf-8")
            yield name, path, None


def solved(model: Model, duration: float, method: str, rtol: float) -> Result | None:
    """A run, None where it ends early."""
    try:
        return model.simulate(duration, solver=method, rtol=rtol, error=False)
    except BgError:
        return None


def examine(name: str, model: Model, duration: float) -> list[tuple[float, str]]:
    """The row of each tolerance, by its ratio."""
    weights = Weights.of(model)
    reference = solved(model, duration, "rodas5p", 1e-10)
    if reference is None:
        return []
    stiff = reference.counts["stiffness"] / STABLE > MOST_STEPS
    methods = [method for method in METHODS if method != "dopri5" or not stiff]
    found = []
    for rtol in TOLERANCES:
        runs = dict.fromkeys(METHODS)
        runs |= {method: solved(model, duration, method, rtol) for method in methods}
        works = {
            method: np.inf if run is None else weights.work(run) for method, run in runs.items()
        }
        least = min(works["rodas5p"], works["dopri5"])
        errors = " ".join(
            "   -   " if run is None else f"{error_of(run, reference):7.1e}"
            for run in runs.values()
        )
        counts = {} if runs["switching"] is None else runs["switching"].counts
        ratios = " ".join(f"{works[method] / least:7.2f}" for method in METHODS)
        told = (
            f"{name:36} {rtol:6.0e} {model.library.explicit_cost:5.2f} {ratios}  {errors}"
            f"  {counts.get('explicit_steps', 0):6.0f} of {counts.get('steps', 0):6.0f} steps,"
            f" {counts.get('method_changes', 0):3.0f} changes"
        )
        found.append((works["switching"] / least, told))
        print(told, flush=True)
    return found


def main(arguments: list[str]) -> None:
    everything = "--all" in arguments
    rows: list[tuple[float, str]] = []
    print(f"{'':36} {'rtol':6} {'cost':5} {' '.join(f'{each:>7.7}' for each in METHODS)}  errors")
    chosen = [text for text in arguments if text != "--all"]
    for name, model, duration in models(chain(scenes(FOLDERS), mechanisms()), chosen):
        if everything or model.library.explicit_cost > 0.0:
            rows += examine(name, model, duration)
    print("\nWorst:")
    for _, told in sorted(rows, reverse=True)[:10]:
        print(told)


if __name__ == "__main__":
    main(sys.argv[1:])
