"""Design optimisation: the least or the greatest observable of a run within bounds and limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.studies import (
    cannot_optimise,
    designs_failed,
    limits_not_met,
    without_influence,
)
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.observables import STEPPED, Criterion, Observable
from bgc.runtime.results.runs import Interrupted
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameter_grid import Range
from bgc.runtime.running.progress import StatusLine
from bgc.runtime.running.run_warnings import negative_among
from bgc.runtime.studies.designs import Designs, RunsSpent
from bgc.runtime.studies.followed_runs import FollowedRuns
from bgc.runtime.studies.optimum import Limit, Optimum
from bgc.runtime.studies.points import PointRuns
from bgc.runtime.studies.search_arguments import spread, with_sobol

SEARCHES = ("gradient", "evolution")
JUDGES = ("worst", "mean")

_HELD = 1e-6  # share of its scale by which a limit may be exceeded
_GAIN = 1e-6  # relative gain of a pass from which on another one follows
_PASSES = 40
_NARROWEST = 1e-4  # share of a range to which steps are limited beside designs that fail
_WIDEST = 1e100  # of a range: differences of larger numbers overflow
_FAILED_DISTANCE = 10.0  # scaled distance of a failed design from the last good one
_PEOPLE = 10  # designs of a generation for each parameter


@dataclass(frozen=True, slots=True)
class Goal:
    """The observable to be minimised or maximised, and how cases are joined."""

    observable: Observable
    largest: bool = False
    judge: str = "worst"

    def losses(self, values: Array) -> Array:
        """The numbers to be minimised, one for each case, from observables (cases, observables)."""
        return np.asarray(-values[..., 0] if self.largest else values[..., 0])

    def loss(self, values: Array) -> float:
        """The number to be minimised: that of the worst case, or the mean."""
        losses = self.losses(values)
        return float(losses.max() if self.judge == "worst" else losses.mean())


@dataclass(frozen=True, slots=True)
class Search:
    """Options of an optimisation; `kind` is empty for the one that the observables permit."""

    kind: str = ""
    starts: int = 1
    most_runs: int = 10_000
    seed: int = 0


@dataclass(slots=True)
class _Problem:
    """Scaled loss and margins of designs, and the best design so far."""

    designs: Designs
    goal: Goal
    criteria: tuple[Criterion, ...]
    places: tuple[int, ...]  # of the observables of the criteria
    limits: Array  # scales of the margins
    line: StatusLine
    scale: float = 1.0
    best: Array | None = None
    refused: int = 0  # times that a design without values was asked for
    history: list[tuple[int, float, float]] = field(default_factory=list)
    rank: tuple[float, float] = (np.inf, np.inf)
    _last: tuple[Array, Array] | None = None  # losses and margins of the last good design

    def judge(self, u: Array, values: Array | None) -> tuple[float, float]:
        """Rank a design, and keep it if it is the best: excess over the limits, then its loss."""
        if values is None:
            return np.inf, np.inf
        loss, excess = self.goal.loss(values), self.excess(values)
        rank = (excess if excess > _HELD else 0.0, loss)
        if rank < self.rank:
            self.rank, self.best = rank, np.clip(u, 0.0, 1.0)
            self.history.append((self.designs.runs.count, loss, excess))
            value = self.goal.observable.shown.text(-loss if self.goal.largest else loss)
            self.line.show(f"{self.designs.runs.count} runs, {self.goal.observable.name} = {value}")
        return rank

    def excess(self, values: Array) -> float:
        """The largest excess over a limit in units of its scale, 0 where all hold."""
        margins = self.margins(values)
        return max(0.0, float(-margins.min())) if margins.size else 0.0

    def margins(self, values: Array) -> Array:
        """Scaled margins, (cases, criteria); positive where the criterion holds."""
        found = [
            each.margin(values[:, place])
            for each, place in zip(self.criteria, self.places, strict=True)
        ]
        return np.stack(found, axis=1) / self.limits if found else np.empty((len(values), 0))

    def scaled(self, u: Array) -> tuple[Array, Array]:
        """Scaled losses, (cases,), and margins; of a failed design far beyond the last good one."""
        values = self.designs.at(u)
        self.judge(u, values)
        if values is not None:
            self._last = self.goal.losses(values) / self.scale, self.margins(values)
            return self._last
        assert self._last is not None
        self.refused += 1
        losses, margins = self._last
        return losses + _FAILED_DISTANCE, margins

    def slopes(self, u: Array) -> tuple[Array, Array] | None:
        """Derivatives of losses, (coordinates, cases), and of margins; None where the run fails."""
        found = self.designs.slopes(u)
        if found is None:
            return None
        signs = np.array([-1.0 if each.below else 1.0 for each in self.criteria])
        margins = found.slopes[:, :, list(self.places)] * signs / self.limits
        return self.goal.losses(found.slopes) / self.scale, margins


def optimise(
    model: LoadedModel,
    method: Solver,
    times: Array,
    bounds: Sequence[Range],
    goal: Goal,
    criteria: Sequence[Criterion] = (),
    over: Mapping[str, Array] | None = None,
    search: Search | None = None,
    *,
    progress: bool = False,
    notices: Sequence[Diagnostic] = (),
) -> Optimum:
    """Find the best design within bounds; see `Model.optimise`."""
    search = search or Search()
    over = over or {}
    kind = _checked(bounds, goal, criteria, over, search)
    observables = {each.name: each for each in (goal.observable, *(c.observable for c in criteria))}
    ranges = spread(bounds)
    runs = PointRuns(model, method, times, tuple(observables.values()))
    columns = tuple({each.column: None for each in observables.values()})
    followed = FollowedRuns(runs, tuple(each.name for each in ranges), columns)
    designs = Designs(runs, ranges, over, search.most_runs, followed)
    names = [*observables]
    places = tuple(names.index(each.observable.name) for each in criteria)
    limits = np.array([abs(each.limit) or 1.0 for each in criteria])
    start = designs.place(np.array([model.parameters[each.name].value for each in ranges]))
    converged = False
    with StatusLine(progress) as line:
        problem = _Problem(designs, goal, tuple(criteria), places, limits, line)
        try:
            start = _first(problem, start, search)
            find = _descend if kind == "gradient" else _evolve
            converged = find(problem, start, search)
        except RunsSpent:
            if problem.best is None:
                reason = f"{search.most_runs} runs are too few for one design and its derivatives"
                raise BgError([cannot_optimise(reason, "give a larger `--runs`")]) from None
        except KeyboardInterrupt as signal:
            best = problem.best
            found = None if best is None else _judged(problem, start, False, kind, notices)
            kept = "; the best design by then" if found is not None else ""
            raise Interrupted(f"interrupted after {runs.count} runs{kept}", found) from signal
    return _judged(problem, start, converged, kind, notices)


def _checked(
    bounds: Sequence[Range],
    goal: Goal,
    criteria: Sequence[Criterion],
    over: Mapping[str, Array],
    search: Search,
) -> str:
    """Choose the search, and refuse options that contradict each other: BG066, BG655."""
    if goal.judge not in JUDGES:
        raise BgError([bad_option("judge", goal.judge, f"one of {', '.join(JUDGES)}", "worst")])
    if search.kind and search.kind not in SEARCHES:
        raise BgError(
            [bad_option("search", search.kind, f"one of {', '.join(SEARCHES)}", "gradient")]
        )
    for name, value in (("starts", search.starts), ("runs", search.most_runs)):
        if value < 1:
            raise BgError([bad_option(name, value, "a positive whole number", "64")])
    if search.seed < 0:
        raise BgError([bad_option("seed", search.seed, "a whole number of 0 or more", "1")])
    if not bounds:
        raise BgError([cannot_optimise("no parameter is varied", 'give `--vary "k=1..9 N/m"`')])
    for each in bounds:
        if not each.low < each.high:
            reason = f"the bounds of `{each.name}` hold a single value of its range"
            raise BgError([cannot_optimise(reason, "widen them, or omit this parameter")])
        if not each.high - each.low < _WIDEST:
            reason = f"the bounds of `{each.name}` are too far apart"
            raise BgError([cannot_optimise(reason, "give bounds that a design may have")])
        if each.name in over:
            reason = f"`{each.name}` is varied, and a design runs over its values too"
            raise BgError([cannot_optimise(reason, "omit it from `--vary` or from `--over`")])
    used = (goal.observable, *(each.observable for each in criteria))
    stepped = [each for each in used if each.function in STEPPED]
    if stepped and search.kind == "gradient":
        reason = f"`{stepped[0].name}` changes in steps, so that it has no derivatives"
        raise BgError([cannot_optimise(reason, "omit `--search`, or give `--search evolution`")])
    return search.kind or ("evolution" if stepped else "gradient")


def _first(problem: _Problem, start: Array, search: Search) -> Array:
    """The present values, or the point of a Sobol sequence with the least loss if better.

    Raises BgError: BG655 where all of these designs fail.
    """
    designs = problem.designs
    unit = [Range(each.name, 0.0, 1.0) for each in designs.ranges]
    points = with_sobol(start, unit, search.starts, search.seed)
    for u, values in zip(points, designs.many(points), strict=True):
        problem.judge(u, values)
    if problem.best is None:
        which = "the run at the start fails" if len(points) == 1 else "all runs at the start fail"
        way_out = "give other start values by `--set`, or `--starts 32`"
        raise BgError([cannot_optimise(f"{which}: {designs.runs.reason}", way_out)])
    return problem.best


def _descend(problem: _Problem, start: Array, _: Search) -> bool:
    """Sequential quadratic programming from a point on; return whether it converged.

    The worst of several cases is minimised as a bound s of all of them, which is smooth. Passes
    begin again at the best design until one gains little, since a pass may end early where its
    approximate Hessian is poor. Where designs fail, the next pass stays closer to the best one.
    """
    # Slow to load, and only an optimisation needs it.
    from scipy.optimize import minimize

    n = len(start)
    bounded = problem.goal.judge == "worst" and problem.designs.cases > 1
    _set_scale(problem, start)
    slopes = problem.slopes(start)
    assert slopes is not None

    def derivatives(x: Array) -> tuple[Array, Array]:
        nonlocal slopes
        found = problem.slopes(x[:n])
        slopes = found if found is not None else slopes  # of the last good design otherwise
        assert slopes is not None
        return slopes

    def loss(x: Array) -> float:
        return float(x[n] if bounded else problem.scaled(x[:n])[0].mean())

    def gradient(x: Array) -> Array:
        return np.asarray(np.eye(n + 1)[n] if bounded else derivatives(x)[0].mean(axis=1))

    def margins(x: Array) -> Array:
        losses, found = problem.scaled(x[:n])
        return np.concatenate((found.ravel(), x[n] - losses)) if bounded else found.ravel()

    def margin_slopes(x: Array) -> Array:
        by_loss, found = derivatives(x)
        rows = found.reshape(n, -1)
        if not bounded:
            return np.asarray(rows.T)
        both = np.concatenate((rows, -by_loss), axis=1)
        last = np.repeat([0.0, 1.0], (rows.shape[1], by_loss.shape[1]))
        return np.vstack((both, last)).T

    limited = bounded or bool(problem.criteria)
    demands = [{"type": "ineq", "fun": margins, "jac": margin_slopes}] if limited else []
    reach = 1.0
    for _pass in range(_PASSES):
        assert problem.best is not None
        before, refused = problem.rank, problem.refused
        low, high = np.maximum(problem.best - reach, 0.0), np.minimum(problem.best + reach, 1.0)
        x = problem.best
        if bounded:
            x = np.append(x, problem.scaled(x)[0].max())
        solution: Any = minimize(
            loss, x, jac=gradient, method="SLSQP", constraints=demands,
            bounds=[*zip(low, high, strict=True), *[(None, None)] * bounded],
            options={"maxiter": 100, "ftol": 1e-9},
        )  # fmt: skip
        gained = before[1] - problem.rank[1]
        if problem.rank[0] < before[0] or gained > _GAIN * problem.scale:
            continue
        if problem.refused > refused and reach > _NARROWEST:
            reach /= 4
        else:
            return bool(solution.status in (0, 4, 8))  # done, no feasible step, no descent left
    return False


def _set_scale(problem: _Problem, start: Array) -> None:
    """Scale the loss by its gradient in the unit cube, so that a first step is of its size."""
    found = problem.slopes(start)
    values = problem.designs.at(start)
    assert found is not None and values is not None
    size = float(np.abs(problem.goal.losses(values)).max())
    problem.scale = max(float(np.abs(found[0]).max()), 1e-3 * size) or 1.0


def _evolve(problem: _Problem, start: Array, search: Search) -> bool:
    """Differential evolution from a Sobol sequence; each generation is one batch.

    Designs that exceed a limit, and failed ones, lose against those that hold them.
    """
    # Slow to load, and only an optimisation needs it.
    from scipy.optimize import NonlinearConstraint, differential_evolution

    def values(points: Array) -> list[Array | None]:
        found = problem.designs.many(points.T)
        for u, each in zip(points.T, found, strict=True):
            problem.judge(u, each)
        return found

    def losses(points: Array) -> Array:
        found = values(points)
        return np.array([np.inf if each is None else problem.goal.loss(each) for each in found])

    def worst_margins(points: Array) -> Array:
        columns = [
            np.full(len(problem.criteria), -_FAILED_DISTANCE) if each is None
            else problem.margins(each).min(axis=0)
            for each in values(points)
        ]  # fmt: skip
        return np.array(columns).T

    demands = NonlinearConstraint(worst_margins, 0.0, np.inf) if problem.criteria else ()
    solution = differential_evolution(
        losses, [(0.0, 1.0)] * len(start), x0=start, init="sobol", popsize=_PEOPLE,
        vectorized=True, updating="deferred", polish=False, seed=search.seed,
        constraints=demands, tol=1e-4, maxiter=100_000,
    )  # fmt: skip
    return bool(solution.success)


def _judged(
    problem: _Problem, start: Array, converged: bool, kind: str, notices: Sequence[Diagnostic]
) -> Optimum:
    """The best design with its limits, and the warnings."""
    designs, goal = problem.designs, problem.goal
    runs, model = designs.runs, designs.runs.model
    assert problem.best is not None
    best, before = designs.at(problem.best), designs.at(start)
    assert best is not None and before is not None
    sign = -1.0 if goal.largest else 1.0
    limits = []
    for each, place in zip(problem.criteria, problem.places, strict=True):
        worst = int(np.argmin(each.margin(best[:, place])))
        value = float(best[worst, place])
        slack = float(each.margin(np.array(value))) / (abs(each.limit) or 1.0)
        limits.append(Limit(each, value, worst, slack))
    warnings = [*notices]
    exceeded = [each for each in limits if each.slack < -_HELD]
    if exceeded:
        text = [each.criterion.name for each in exceeded]
        warnings.append(limits_not_met(text))
    point = designs.parameters(problem.best)
    low, high = (np.array([getattr(r, end) for r in designs.ranges]) for end in ("low", "high"))
    edge = 1e-6
    names = tuple(each.name for each in designs.ranges)
    if runs.failures:
        first = runs.failures[0]
        why = f"{first.message} ({first.note.splitlines()[-1]})"
        warnings.append(designs_failed(len(runs.failures), runs.count, why))
    silent = _silent(problem, kind)
    if silent:
        warnings.append(without_influence([names[k] for k in silent]))
    warnings += negative_among(model, names, point[np.newaxis])
    warnings += designs.warned(problem.best)
    return Optimum(
        scene=model.facts.name,
        names=names,
        values=point,
        low=low,
        high=high,
        start=designs.parameters(start),
        at_bound=tuple(bool(u <= edge or u >= 1 - edge) for u in problem.best),
        goal=goal.observable,
        largest=goal.largest,
        judge=goal.judge,
        objective=sign * goal.loss(best),
        at_start=sign * goal.loss(before),
        governing=int(np.argmax(goal.losses(best))),
        limits=tuple(limits),
        over=designs.over,
        shown={name: model.parameters[name].shown for name in (*names, *designs.over)},
        search=kind,
        converged=converged,
        runs=runs.count,
        failed=len(runs.failures),
        failures=tuple(runs.failures),
        history=np.array([(runs, sign * loss, excess) for runs, loss, excess in problem.history]),
        warnings=tuple(warnings),
    )


def _silent(problem: _Problem, kind: str) -> list[int]:
    """Coordinates without influence on loss and limits at the best design."""
    if kind != "gradient" or problem.best is None:
        return []
    found = problem.designs.known_slopes(problem.best)
    if found is None:
        return []
    return [k for k, each in enumerate(found.slopes) if not np.any(each)]
