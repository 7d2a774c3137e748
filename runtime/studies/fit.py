"""Estimation of parameters from a recorded motion by nonlinear least squares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.studies import cannot_fit, not_identifiable
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameter_grid import Range
from bgc.runtime.running.run_warnings import negative_among
from bgc.runtime.studies.estimate import Estimate
from bgc.runtime.studies.followed_runs import FollowedRuns
from bgc.runtime.studies.motion import Recorded
from bgc.runtime.studies.points import PointRuns, slopes, stencil
from bgc.runtime.studies.search_arguments import spread, with_sobol

LOSSES = ("linear", "soft_l1", "huber", "cauchy")

_PASSES = 10  # fits, each with derivatives and weights of the noise where the one before ended
_STILL = 1e-2  # distance, in standard errors of the parameters, to which passes move the estimate
_UNEXPLAINED = 0.3  # share of a step's change from which on derivatives are computed anew
_SHORT = 1e-4  # step over the scale of the parameters whose change says little about derivatives
_COLLINEAR = 1e4  # condition number from which on parameters count as not identifiable
_SHARE = 0.3  # of a singular vector: parameters that belong to a combination
_MOST_RUNS = 200  # points of one fit
_TO_SIGMA = 1.4826  # times the median magnitude of normal residuals is their deviation


@dataclass(frozen=True, slots=True)
class FitOptions:
    """Options of an estimation.

    `noise` are the standard deviations of the columns by name, in their units; estimated from the
    residuals where they are not given. `starts` is the number of points of a Sobol sequence among
    which the first point is chosen, besides the present values.
    """

    loss: str = "linear"
    noise: Mapping[str, float] | None = None
    starts: int = 1
    confidence: float = 0.95


@dataclass(frozen=True, slots=True)
class Sloped:
    """Values at a point, (rows, columns), and derivatives, (parameters, rows, columns)."""

    point: Array
    values: Array
    slopes: Array


@dataclass(slots=True)
class Residuals:
    """Computed less recorded values over the noise of their columns, and their derivatives.

    `scale` is the size of each parameter, `noise` the standard deviation of each fitted column.
    Derivatives are exact at a point that `follow` was called with, those of the run or, where it
    has none, central differences. From there on Broyden's updates carry them along: the changes
    of the values in each step correct the derivatives along it.
    """

    runs: PointRuns
    recorded: Recorded
    names: tuple[str, ...]
    low: Array
    high: Array
    scale: Array
    noise: Array
    _exact: Sloped | None = None  # where `follow` was called
    _near: Sloped | None = None  # carried along from there
    _tried: tuple[Array, Array | None] | None = None  # the last point, and its values
    _followed: FollowedRuns | None = None

    def values(self, point: Array) -> Array | None:
        """Computed values of the fitted columns, (rows, columns); None where the run fails."""
        if self._near is not None and np.array_equal(point, self._near.point):
            return self._near.values
        if self._tried is None or not np.array_equal(point, self._tried[0]):
            self._tried = point.copy(), self.many(point[np.newaxis])[0]
        return self._tried[1]

    def residuals(self, point: Array) -> Array | None:
        """Residuals of all recorded values, (m,); None where the run fails."""
        values = self.values(point)
        if values is None:
            return None
        return np.asarray(((values - self.recorded.values) / self.noise)[self.recorded.known])

    def follow(self, point: Array) -> None:
        """Compute the derivatives at a point whose run does not fail."""
        values = self.values(point)
        assert values is not None
        if self._followed is None:
            self._followed = FollowedRuns(self.runs, self.names, self.recorded.names)
        found = self._followed.at(point, self.recorded.time, {})
        slopes = found[1] if found is not None else self._differences(point, values)
        self._exact = self._near = Sloped(point.copy(), values, slopes)

    def jacobian(self, point: Array) -> Array:
        """Derivatives of the residuals by the parameters, (m, parameters), near a point."""
        assert self._near is not None
        if not np.array_equal(point, self._near.point):
            self._step_to(point, self._near)
        return self._weighted(self._near)

    def exact_jacobian(self) -> Array:
        """Derivatives of the residuals by the parameters, (m, parameters), of the last `follow`."""
        assert self._exact is not None
        return self._weighted(self._exact)

    def warned(self, point: Array) -> tuple[Diagnostic, ...]:
        """The warnings about the run at a point, which is repeated alone."""
        again = self.runs.repeat(self.runs.plan(self.names, point[np.newaxis]))
        return again.run_warnings.get(0, ())

    def many(self, points: Array) -> list[Array | None]:
        """Computed values at several points, (n, parameters), in one batch."""
        found = self.runs.run(self.runs.plan(self.names, points))
        places = [found.names.index(name) for name in self.recorded.names]
        rows = found.values[:, :, places]
        good = found.done & np.isfinite(rows[:, 1:]).all(axis=(1, 2))
        return [rows[k] if good[k] else None for k in range(len(points))]

    def _step_to(self, point: Array, last: Sloped) -> None:
        """Carry the derivatives to a point, or compute them anew where they do not explain it.

        C. G. Broyden, Mathematics of Computation 19 (1965), 577-593, in parameters over their
        scales.
        """
        values = self.values(point)
        assert values is not None
        step = (point - last.point) / self.scale
        length = float(np.linalg.norm(step))
        change = values - last.values
        unexplained = change - np.tensordot(point - last.point, last.slopes, 1)
        if self._size(unexplained) > _UNEXPLAINED * self._size(change) and length > _SHORT:
            self.follow(point)
            return
        slopes = last.slopes
        if length > _SHORT:
            slopes = slopes + np.multiply.outer(step / self.scale / length**2, unexplained)
        self._near = Sloped(point.copy(), values, slopes)

    def _size(self, changes: Array) -> float:
        """The norm of changes of the values in units of their noise."""
        return float(np.linalg.norm((changes / self.noise)[self.recorded.known]))

    def _differences(self, point: Array, values: Array) -> Array:
        """Central differences within the bounds, from one batch."""
        plan = self.runs.plan(self.names, np.tile(point, (2 * len(point) + 1, 1)))
        step = self.runs.difference(plan) * self.scale
        points = stencil(
            point, np.minimum(point + step, self.high), np.maximum(point - step, self.low)
        )
        batch = self.many(points)
        return slopes(points, [values if batch[0] is None else batch[0], *batch[1:]])

    def _weighted(self, found: Sloped) -> Array:
        slopes = found.slopes / self.noise
        return np.column_stack([each[self.recorded.known] for each in slopes])


def _penalty(residuals: Sequence[float] | Array) -> Array:
    """Residuals that stand for a failed run: larger than those of the start, so it is refused."""
    size = float(np.linalg.norm(np.asarray(residuals)))
    return np.full(len(residuals), 10 * max(size, 1.0))


def fit(
    model: LoadedModel,
    method: Solver,
    recorded: Recorded,
    bounds: Sequence[Range],
    options: FitOptions,
) -> Estimate:
    """Estimate parameters within bounds; see `Model.fit`."""
    _check(recorded, bounds, options)
    names = tuple(each.name for each in bounds)
    low, high = (np.array([getattr(each, end) for each in bounds]) for end in ("low", "high"))
    present = np.array([model.parameters[name].value for name in names])
    inside = (present >= low) & (present <= high)
    start = np.where(inside, present, _middle(low, high))
    known = recorded.values
    spread = np.nanstd(known, axis=0)
    size = np.nanmax(np.abs(known), axis=0)
    noise = np.where(spread > 0, spread, np.where(size > 0, size, 1.0))
    given = options.noise or {}
    for k, name in enumerate(recorded.names):
        noise[k] = given.get(name, noise[k])
    runs = PointRuns(model, method, recorded.time)
    scale = np.where(np.abs(start) > 0, np.abs(start), high - low)
    problem = Residuals(runs, recorded, names, low, high, scale, noise)
    start = _best_start(problem, bounds, start, options.starts)
    point = start
    for _ in range(_PASSES):
        problem.follow(point)
        solution = _solve(problem, point, options.loss)
        moved, point = np.asarray(solution.x) - point, np.asarray(solution.x)
        free = [k for k, name in enumerate(recorded.names) if name not in given]
        before = problem.noise.copy()
        values = problem.values(point)
        assert values is not None
        deviations = _deviations(values - recorded.values, len(names), options.loss)
        problem.noise[free] = np.maximum(deviations[free], 1e-12 * before[free])
        # The weight of one column does not move the estimate.
        alone = len(recorded.names) == 1 and options.loss == "linear"
        weighed = alone or np.allclose(problem.noise, before, rtol=0.01, atol=0)
        there = problem.exact_jacobian() @ moved
        still = float(np.linalg.norm(there)) <= _STILL or (np.abs(moved) <= 1e-8 * scale).all()
        if weighed and still:
            break
    else:
        problem.follow(point)
    return _judge(problem, point, start, solution, options)


def _check(recorded: Recorded, bounds: Sequence[Range], options: FitOptions) -> None:
    if options.loss not in LOSSES:
        raise BgError([bad_option("loss", options.loss, f"one of {', '.join(LOSSES)}", "huber")])
    if not 0 < options.confidence < 1:
        wanted = "a number between 0 and 1"
        raise BgError([bad_option("confidence", options.confidence, wanted, "0.95")])
    if options.starts < 1:
        raise BgError([bad_option("starts", options.starts, "a positive whole number", "16")])
    if not bounds:
        raise BgError([cannot_fit("no parameter is to be estimated", 'give `--vary "k=1..9 N/m"`')])
    for each in bounds:
        if not each.low < each.high:
            raise BgError(
                [cannot_fit(f"the bounds of `{each.name}` hold a single value", "widen them")]
            )
    for value in (options.noise or {}).values():
        if not value > 0:
            raise BgError([bad_option("noise", value, "a positive standard deviation", "1e-3")])
    count = int(recorded.known.sum())
    if count <= len(bounds):
        reason = f"{count} recorded values do not determine {len(bounds)} parameters"
        raise BgError([cannot_fit(reason, "give a longer recording or fewer parameters")])


def _middle(low: Array, high: Array) -> Array:
    """Middles of ranges: geometric where both ends are positive and far apart."""
    far = (low > 0) & (high > 10 * low)
    with np.errstate(invalid="ignore"):
        return np.where(far, np.sqrt(np.abs(low * high)), (low + high) / 2)


def _best_start(problem: Residuals, bounds: Sequence[Range], start: Array, count: int) -> Array:
    """The present values, or the point of a Sobol sequence with the least squares if better."""
    points = with_sobol(start, spread(bounds), count)
    found = problem.many(points)
    squares = [
        np.inf if each is None
        else float(np.nansum(((each - problem.recorded.values) / problem.noise) ** 2))
        for each in found
    ]  # fmt: skip
    best = int(np.argmin(squares))
    if not np.isfinite(squares[best]):
        why = (
            problem.runs.failures[0].message
            if problem.runs.failures
            else "its values are not finite"
        )
        reason = f"the run with the start values fails: {why}"
        raise BgError([cannot_fit(reason, "give other start values by `--set`, or `--starts 16`")])
    return np.asarray(points[best])


def _solve(problem: Residuals, start: Array, loss: str) -> Any:
    """Minimise the loss from a point on; residuals are in units of their noise."""
    # Slow to load, and only an estimation needs it.
    from scipy.optimize import least_squares

    first = problem.residuals(start)
    assert first is not None
    refused = _penalty(first)

    def residuals(point: Array) -> Array:
        found = problem.residuals(point)
        return refused if found is None else found

    # The solver asks for derivatives only where it has accepted a point.
    return least_squares(
        residuals,
        start,
        jac=problem.jacobian,
        bounds=(problem.low, problem.high),
        x_scale=problem.scale,
        loss=loss,
        max_nfev=_MOST_RUNS,
    )


def _deviations(residuals: Array, parameters: int, loss: str) -> Array:
    """The standard deviation of the residuals of each column, robust for a robust loss."""
    known = np.isfinite(residuals)
    count = known.sum(axis=0)
    if loss == "linear":
        freedom = np.maximum(count - parameters * count / count.sum(), 1)
        return np.asarray(np.sqrt(np.nansum(residuals**2, axis=0) / freedom))
    return np.asarray(_TO_SIGMA * np.nanmedian(np.abs(residuals), axis=0))


def _influence(r: Array, loss: str) -> tuple[Array, Array]:
    """The derivative psi of the loss by a residual, and that of psi (`least_squares`' losses)."""
    z = r * r
    if loss == "soft_l1":
        return r * (1 + z) ** -0.5, (1 + z) ** -1.5
    if loss == "huber":
        near = np.abs(r) <= 1
        return np.where(near, r, np.sign(r)), near.astype(float)
    if loss == "cauchy":
        return r / (1 + z), (1 - z) / (1 + z) ** 2
    return r, np.ones_like(r)


def _judge(
    problem: Residuals, point: Array, start: Array, solution: Any, options: FitOptions
) -> Estimate:
    """Intervals from the Jacobian and the noise, and the warnings.

    The covariance is s^2 (J^T J)^-1 with s^2 = mean(psi^2)/mean(psi')^2 m/(m - n), which is the sum
    of squares over m - n for least squares (P. J. Huber, Robust Statistics, 1981, section 7.6).
    Parameters at a bound are kept there: they have no interval, and those of the others hold for
    these values.
    """
    # Slow to load, and only an estimation needs it.
    from scipy.stats import t as student

    residuals, jacobian = problem.residuals(point), problem.exact_jacobian()
    assert residuals is not None
    m, n = jacobian.shape
    edge = 1e-6 * problem.scale
    at_bound = (point - problem.low <= edge) | (problem.high - point <= edge)
    free = np.flatnonzero(~at_bound)
    psi, slope = _influence(residuals, options.loss)
    variance = float(np.mean(psi**2) / np.mean(slope) ** 2) * m / max(m - n, 1)
    warnings, determined = _identifiable(problem.names, jacobian, free.tolist())
    half = np.full(n, np.nan)
    correlation = np.full((n, n), np.nan)
    if len(free) and determined:
        scaled = jacobian[:, free] * problem.scale[free]
        inverse = np.linalg.inv(scaled.T @ scaled) * np.outer(*2 * (problem.scale[free],))
        errors = np.sqrt(variance * np.diag(inverse))
        half[free] = student.ppf((1 + options.confidence) / 2, max(m - n, 1)) * errors
        lengths = np.sqrt(np.diag(inverse))
        correlation[np.ix_(free, free)] = inverse / np.outer(lengths, lengths)
    values = problem.values(point)
    assert values is not None
    model = problem.runs.model
    return Estimate(
        scene=model.facts.name,
        names=problem.names,
        values=point,
        half_widths=half,
        start=start,
        at_bound=tuple(bool(each) for each in at_bound),
        confidence=options.confidence,
        correlation=correlation,
        recorded=problem.recorded,
        computed=values,
        noise=dict(zip(problem.recorded.names, problem.noise.tolist(), strict=True)),
        shown={name: model.parameters[name].shown for name in problem.names},
        shown_columns={v.name: v.shown for v in model.outputs},
        converged=bool(solution.status > 0),
        loss=options.loss,
        runs=problem.runs.count,
        failed=len(problem.runs.failures),
        warnings=(
            *warnings,
            *negative_among(model, problem.names, point[np.newaxis]),
            *problem.warned(point),
        ),
    )


def _identifiable(
    names: Sequence[str], jacobian: Array, free: Sequence[int]
) -> tuple[list[Diagnostic], bool]:
    """Warn of combinations of parameters that the data do not determine (BG478).

    The columns are scaled to length 1: D. A. Belsley, E. Kuh, R. E. Welsch, Regression
    Diagnostics, 1980, chapter 3.
    """
    lengths = np.linalg.norm(jacobian, axis=0)
    largest = float(np.linalg.norm(jacobian)) or 1.0
    silent = [k for k in free if lengths[k] <= 1e-12 * largest]
    found = [not_identifiable([names[k]], float("inf")) for k in silent]
    rest = [k for k in free if k not in silent]
    if rest:
        _, sizes, rows = np.linalg.svd(jacobian[:, rest] / lengths[rest], full_matrices=False)
        for size, row in zip(sizes, rows, strict=True):
            condition = float(sizes[0] / size) if size > 0 else float("inf")
            if condition > _COLLINEAR:
                shared = [
                    names[k] for k, share in zip(rest, row, strict=True) if abs(share) > _SHARE
                ]
                found.append(not_identifiable(shared, condition))
    return found, not found
