"""Costs of a scene: as compiled, without slicing and folding, and with other parts in its slots."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from itertools import islice, repeat
from pathlib import Path

import numpy as np

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.driver import compile_scene
from bgc.elaboration.scenes.variants import Change, variants_of, with_changes
from bgc.emission.operation_cost import Cost, cost_of
from bgc.ir.defaults import program_values
from bgc.ir.lowered import Lowered
from bgc.ir.program import Dropped
from bgc.options import Options
from bgc.record_class import dataclass, replace
from bgc.resolution.modules import Package
from bgc.resolution.resolve import load
from bgc.runtime.linear.state_space import pencil_eigenvalues
from bgc.runtime.running.failures import require
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.model_loading import load_model
from bgc.runtime.running.progress import tracked
from bgc.runtime.running.simulate import method_of

_MOST_STATES = 1500  # of a Jacobian whose eigenvalues are computed
_FIXED_STEPS = 2000  # of a measured run
_ADAPTIVE_SECONDS = 2.0
_ROUNDS = 10  # in which the scene and its variants take turns; the fastest run of each counts


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


@dataclass(frozen=True, slots=True)
class VariantCost:
    """The cost of a variant, or in `refused` the reason why it does not fit.

    `measured` is its run, None where it does not run.
    """

    variant: Change
    cost: Cost | None
    stiffness: float | None
    refused: str = ""
    measured: Measured | None = None


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


def cost_report(
    path: Path, options: Options, most_variants: int, progress: bool = False
) -> CostReport:
    """Compile a scene as it is, without slicing and folding, and with variants of its slots.

    At most `most_variants` are compiled. They and the scene are built, and take turns in short
    runs, so that a machine that is busy for a while slows all of them. Nothing is measured without
    a C compiler.

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
    models = [_loaded(path, options)]
    rows: list[VariantCost] = []
    for variant in tracked(chosen, progress, "compiling variants"):
        changed = with_changes(options, (variant,))
        rows.append(_variant_cost(path, changed, package, variant))
        models.append(rows[-1].refused or _loaded(path, changed))
    own, *others = _measured(models)
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
        measured=None if isinstance(own, str) else own,
        unmeasured=own if isinstance(own, str) else "",
        variants=tuple(
            row if isinstance(run, str) else replace(row, measured=run)
            for row, run in zip(rows, others, strict=True)
        ),
        skipped=len(found) - len(chosen),
        warnings=ours.warnings,
    )


def _variant_cost(path: Path, options: Options, package: Package, variant: Change) -> VariantCost:
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


def _loaded(path: Path, options: Options) -> LoadedModel | str:
    """Build and load a scene, or return the reason why that fails."""
    try:
        return load_model(path, options)
    except BgError as problem:
        return problem.diagnostics[0].message


def _measured(models: Sequence[LoadedModel | str]) -> list[Measured | str]:
    """Measure the fastest of a few short runs of each model, or return why there is none."""
    rounds = islice(zip(*map(_short_runs, models), strict=True), _ROUNDS)
    return [min(runs, key=_seconds) for runs in zip(*rounds, strict=True)]


def _seconds(run: Measured | str) -> float:
    return math.inf if isinstance(run, str) else run.step_seconds


def _short_runs(model: LoadedModel | str) -> Iterator[Measured | str]:
    """Run a model from its start again and again, without end; yield why where that fails.

    Processor time counts, which other processes do not consume.
    """
    if isinstance(model, str):
        yield from repeat(model)
        return
    try:
        step, duration = model.facts.step, model.facts.duration
        longest = _ADAPTIVE_SECONDS if step is None else _FIXED_STEPS * step
        end = np.array([longest if duration is None else min(duration, longest)])
        method, _ = method_of(model)
        row = np.empty((1, len(model.measured)))
        with model.started(method, accounts=False) as instance:
            start = instance.save()
            while True:
                begin = time.thread_time()
                status, _ = instance.run(end, row)
                seconds = max(time.thread_time() - begin, 1e-9)
                require(instance, status)
                counts = instance.counts
                steps = max(counts["steps"], 1)
                names = ("rhs", "jacobians", "factorisations", "solves")
                calls = (counts[name] / steps for name in names)
                yield Measured(method.name, seconds / steps, float(end[0]) / seconds, *calls)
                instance.restore(start)
    except BgError as problem:
        yield from repeat(problem.diagnostics[0].message)
