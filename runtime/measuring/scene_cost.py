"""Costs of a scene: as compiled, without slicing and folding, and with other parts in its slots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.records import dataclass, replace
from bgc.driver import compile_scene
from bgc.elaboration.scenes.variants import Change, variants_of, with_changes
from bgc.emission.operation_cost import Cost, cost_of
from bgc.ir.defaults import program_values
from bgc.ir.lowered import Lowered
from bgc.ir.program import Dropped
from bgc.options import Options
from bgc.resolution.modules import Package
from bgc.resolution.resolve import load
from bgc.runtime.linear.state_space import pencil_eigenvalues
from bgc.runtime.running.model_loading import load_model
from bgc.runtime.running.progress import tracked
from bgc.runtime.running.simulate import method_of, simulate, times_of

_MOST_STATES = 1500  # of a Jacobian whose eigenvalues are computed
_FIXED_STEPS = 2000  # of a measured run
_ADAPTIVE_SECONDS = 2.0
_RUNS = 3  # the fastest counts
# Cost of a step outside the kernels, in operations of the kernels: fitted to the times of a model
# with two states and of cranes with 37 and 70.
_STEP_OPERATIONS, _STATE_OPERATIONS = 4000, 40


@dataclass(frozen=True, slots=True)
class Measured:
    """A measured run: the time of a step, and the calls of each kernel in a step."""

    solver: str
    step_seconds: float
    real_time_factor: float
    rhs: float
    jacobians: float
    factorisations: float
    solutions: float

    def operations(self, cost: Cost) -> float:
        """Count the operations of one step, including the stepping outside the kernels."""
        kernels = cost.operations(self.rhs, self.jacobians, self.factorisations, self.solutions)
        return kernels + _STEP_OPERATIONS + _STATE_OPERATIONS * cost.states


@dataclass(frozen=True, slots=True)
class VariantCost:
    """The cost of a variant, or in `refused` the reason why it does not fit."""

    variant: Change
    cost: Cost | None
    stiffness: float | None
    refused: str = ""


@dataclass(frozen=True, slots=True)
class CostReport:
    """The costs of a scene and of its variants.

    `whole` is the cost without slicing and folding, `cost` that of the compiled scene. `stiffness`
    is the spectral radius of the Jacobian at the start, 1/s; None if it is not finite or the
    Jacobian is too large. `unmeasured` is the reason why there is no measurement. `skipped` counts
    the variants beyond the requested number.
    """

    scene: str
    model: str
    whole: Cost
    cost: Cost
    stiffness: float | None
    states: tuple[str, ...]
    dropped: tuple[Dropped, ...]
    folded: tuple[tuple[str, float], ...]
    measured: Measured | None
    unmeasured: str
    variants: tuple[VariantCost, ...]
    skipped: int
    warnings: tuple[Diagnostic, ...]

    def estimate(self, cost: Cost) -> float | None:
        """Estimate the seconds of a step from its operations, relative to the measured ones."""
        if self.measured is None:
            return None
        ratio = self.measured.operations(cost) / max(self.measured.operations(self.cost), 1.0)
        return self.measured.step_seconds * ratio


def cost_report(
    path: Path, options: Options, most_variants: int, progress: bool = False
) -> CostReport:
    """Compile a scene as it is, without slicing and folding, and with variants of its slots.

    At most `most_variants` are compiled. Only the scene itself is built and run; nothing is
    measured without a C compiler.

    Raises
    ------
    BgError
        The scene itself is at fault; errors of variants go into the report.
    """
    package = load(path)
    ours = compile_scene(path, options, package=package, until="lower")
    lowered = ours.lowered
    whole = replace(options, whole=True)
    everything = compile_scene(path, whole, package=package, until="lower")
    found = variants_of(package, ours.graph)
    chosen = found[:most_variants]
    rows: list[VariantCost] = []
    for variant in tracked(chosen, progress, "compiling variants"):
        rows.append(_variant_cost(path, options, package, variant))
    measured, unmeasured = _measured(path, options)
    facts = ours.graph.scene
    return CostReport(
        scene=facts.name,
        model=facts.model,
        whole=cost_of(everything.lowered),
        cost=cost_of(lowered),
        stiffness=spectral_radius(lowered),
        states=tuple(state.name for state in lowered.program.states),
        dropped=lowered.program.dropped,
        folded=ours.folding.parameters,
        measured=measured,
        unmeasured=unmeasured,
        variants=tuple(rows),
        skipped=len(found) - len(chosen),
        warnings=ours.warnings,
    )


def _variant_cost(path: Path, base: Options, package: Package, variant: Change) -> VariantCost:
    options = with_changes(base, (variant,))
    try:
        lowered = compile_scene(path, options, package=package, until="lower").lowered
    except BgError as problem:
        return VariantCost(variant, None, None, problem.diagnostics[0].message)
    return VariantCost(variant, cost_of(lowered), spectral_radius(lowered))


def spectral_radius(lowered: Lowered) -> float | None:
    """Compute the largest modulus of the eigenvalues of the Jacobian at the given start, 1/s.

    A start at rest is not looked for. Parameters have their defaults, devices are at rest,
    algebraic unknowns at their guess.
    """
    program, jacobian = lowered.program, lowered.jacobian
    size = len(program.states)
    if not 0 < size <= _MOST_STATES:
        return None
    dag = program.dag
    values = program_values(program)
    values[Symbol(Kind.TIME, 0)] = 0.0
    values.update({Symbol(Kind.INPUT, k): 0.0 for k in range(program.inputs)})
    for k in range(len(lowered.switches)):  # no mode is set: the comparison itself decides
        values[Symbol(Kind.INPUT, program.inputs + k)] = math.nan
    start = evaluate_nodes(dag, [state.initial for state in program.states], values)
    values.update({Symbol(Kind.STATE, k): x for k, x in enumerate(start)})
    matrix, mass = np.zeros((jacobian.size, jacobian.size)), np.eye(size)
    matrix[jacobian.rows, jacobian.columns] = evaluate_nodes(dag, jacobian.entries, values)
    if program.mass is not None:
        mass[:] = 0
        places: Sequence[tuple[int, int]] = [(m.row, m.column) for m in program.mass]
        for place, value in zip(
            places, evaluate_nodes(dag, [m.value for m in program.mass], values), strict=True
        ):
            mass[place] = value
    if not np.isfinite(matrix).all():
        return None
    if jacobian.inner:
        with_inner = np.linalg.solve(matrix[size:, size:], matrix[size:, :size])
        matrix = matrix[:size, :size] - matrix[:size, size:] @ with_inner
    eigenvalues = np.abs(pencil_eigenvalues(matrix, mass))
    return float(eigenvalues.max(initial=0.0))


def _measured(path: Path, options: Options) -> tuple[Measured | None, str]:
    """Measure the fastest of a few short runs, or return the reason why there is none."""
    try:
        model = load_model(path, options)
        step, duration = model.facts.step, model.facts.duration
        longest = _ADAPTIVE_SECONDS if step is None else _FIXED_STEPS * step
        end = longest if duration is None else min(duration, longest)
        method, _ = method_of(model)
        times = times_of(model, method, end, every=end)
        runs = [simulate(model, method, times) for _ in range(_RUNS)]
    except BgError as problem:
        return None, problem.diagnostics[0].message
    best = min(runs, key=lambda run: run.counts["run_seconds"])
    counts = best.counts
    steps, seconds = max(counts["steps"], 1), counts["run_seconds"]
    return (
        Measured(
            solver=best.solver,
            step_seconds=seconds / steps,
            real_time_factor=end / seconds if seconds > 0 else float("inf"),
            rhs=counts["rhs"] / steps,
            jacobians=counts["jacobians"] / steps,
            factorisations=counts["factorisations"] / steps,
            solutions=counts["solves"] / steps,
        ),
        "",
    )
