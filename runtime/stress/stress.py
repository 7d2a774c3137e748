"""`bgc stress`: run a scene at extreme values, one point after the other, within a budget."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from bgc.diagnostics.catalogue.stress import nothing_to_judge
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.language.methods import default_method
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field, replace
from bgc.runtime.measuring.judging import Accuracy, duration_of
from bgc.runtime.measuring.measured_store import open_store
from bgc.runtime.measuring.session import Session, changed_model
from bgc.runtime.measuring.timed_run import Budget, completed, reason_of, timed_run
from bgc.runtime.running.arguments import read_solver
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.progress import tracked
from bgc.runtime.running.run import choose_method
from bgc.runtime.stress.drives import (
    RTOL,
    STEP,
    TIME,
    Drive,
    all_drives,
    requested_drives,
)
from bgc.runtime.stress.stress_judge import (
    DEFAULT_RTOL,
    Judgement,
    References,
    Settings,
    Verdict,
    judge,
)

WITHIN = 1e-3
BUDGET = 120.0

_ROWS = 200
_WANTED = 100  # points that should fit in the budget, with a shortened scene if necessary
_PORTIONS = (1.0, 0.5, 0.25)  # of the scene
_RUNS = 8.0  # approximate cost of a point, with its references, in runs of the scene
_PATIENCE = 10.0  # times the scene's own run
_AT_LEAST = 1.0  # s for any run
_SHORT_STEPS_SHARE = 0.3  # of the time limit, for a run with short steps


@dataclass(frozen=True, slots=True)
class Point:
    """A point of the map: its settings, the seconds that were run, and the judgement."""

    settings: Settings
    duration: float
    judgement: Judgement


@dataclass(frozen=True, slots=True)
class StressMap:
    """The result of `bgc stress`.

    `drives` were driven one by one, with a point for each value, or two together in a `grid`.
    `duration` is the part of the scene's `scene_duration` that was run, s. `planned` is the number
    of points; `skipped` are the drives without any point within the budget, and `needed` is the
    budget for the longest of the remaining points, s.
    """

    scene: str
    method: str
    duration: float
    scene_duration: float
    tolerance: Accuracy
    grid: bool
    drives: tuple[Drive, ...]
    points: tuple[Point, ...]
    planned: int
    skipped: tuple[Drive, ...]
    needed: float

    def counts(self) -> Mapping[Verdict, int]:
        """Count the points of each verdict."""
        return Counter(point.judgement.verdict for point in self.points)

    @property
    def wrong(self) -> tuple[Point, ...]:
        """Points with wrong numbers and no warning."""
        return tuple(p for p in self.points if p.judgement.verdict is Verdict.WRONG)

    def of_drive(self, drive: Drive) -> tuple[Point, ...]:
        """Return the points along a drive, in a map that is not a grid."""
        return tuple(p for p in self.points if p.settings and p.settings[0][0] == drive.name)


def stress(
    model: LoadedModel,
    drives: Sequence[str] = (),
    *,
    grid: bool = False,
    solver: str | None = None,
    rtol: float | None = None,
    step: float | None = None,
    duration: float | None = None,
    within: float | None = None,
    budget: float = BUDGET,
    fresh: bool = False,
    progress: bool = False,
) -> StressMap:
    """Run a scene at extreme values, and compare each run with other methods.

    Points are stored in the cache as they are judged: after the end of the budget, or Ctrl-C,
    another call continues.

    Parameters
    ----------
    model
        A model with its source, as `bgc.compile` gives it.
    drives
        The drives, as `"k=1e3..1e14 N/m"`, or `"*.lock.stiffness=.."` for all parameters of such
        names together; by default steps, tolerances, the duration, and every run-time parameter.
    grid
        Whether to combine all values of two drives.
    solver, rtol, step
        The method to judge; by default the scene's.
    duration
        How much of the scene to run, s; by default all, or a part where the budget is small.
    within
        The acceptable error, relative to the range of each observed quantity; by default the
        scene's `require`, else 1e-3.
    budget
        The approximate time for all points, s.
    fresh
        Whether to delete stored points.

    Raises
    ------
    BgError
        A drive is at fault; BG088 if the scene observes nothing, BG089 if it does not run.
    """
    method = choose_method(
        model.library, model.facts, read_solver({"solver": solver, "rtol": rtol, "step": step})
    )
    full = duration_of(model, duration or None, nothing_to_judge)
    clock = Budget(budget)
    requested = requested_drives(model, drives)
    by_scene = within is None
    tolerance = Accuracy(WITHIN if within is None else within, model.facts.requirements * by_scene)
    session = StressSession(
        model=model,
        duration=full,
        accuracy=tolerance,
        store=open_store(model, "stress", method, tolerance, duration, fresh=fresh),
        budget=clock,
        progress=progress,
        method=method,
    )
    points: list[Point] = []
    needed = 0.0
    session.begin(shortened=not duration)
    wanted = session.drives(requested)
    if grid and len(wanted) != 2:
        raise ValueError("a grid takes two drives")
    plan = _grid(wanted) if grid else _in_order(wanted)
    for settings in tracked(plan, progress, "driving", " points"):
        takes = session.seconds(settings)
        if not points or takes == 0 or session.left > (0 if drives else takes):
            points.append(session.point(settings))
        else:
            needed = max(needed, takes)
    written = {(drive.name, x): k for drive in wanted for k, x in enumerate(drive.values)}
    names = [drive.name for drive in wanted]
    if not grid:
        points.sort(key=lambda p: (names.index(p.settings[0][0]), written[p.settings[0]]))
    done = {point.settings[-1][0] for point in points}
    return StressMap(
        scene=model.facts.name or model.facts.model,
        method=_described(method),
        duration=session.duration,
        scene_duration=full,
        tolerance=tolerance,
        grid=grid,
        drives=tuple(drive for drive in wanted if grid or drive.name in done),
        points=tuple(points),
        planned=len(plan),
        skipped=() if grid else tuple(drive for drive in wanted if drive.name not in done),
        needed=needed,
    )


def _grid(drives: Sequence[Drive]) -> list[Settings]:
    """List the points of a grid row by row, so that the budget ends after whole rows."""
    across, up = drives
    return [((across.name, x), (up.name, y)) for y in up.values for x in across.values]


def _in_order(drives: Sequence[Drive]) -> list[Settings]:
    """Order points: one drive of each kind first, its values by their urgency."""
    seen: Counter[tuple[str, str]] = Counter()
    order: list[tuple[int, int, Settings]] = []
    for drive in drives:
        kind = drive.role or drive.name, drive.unit
        for value in drive.values:
            order.append((seen[kind], drive.urgency(value), ((drive.name, value),)))
        seen[kind] += 1
    return [settings for *_, settings in sorted(order, key=lambda item: item[:2])]


def _portion(seconds: float, budget: float) -> float:
    """Choose the part of the scene's duration for which 100 points fit in the budget, if any."""
    affordable = budget / (_WANTED * _RUNS * max(seconds, 1e-9))
    return next((part for part in _PORTIONS if part <= affordable), _PORTIONS[-1])


def _described(method: Solver) -> str:
    return (
        f"{method.name} at {method.step:g} s"
        if method.fixed
        else (f"{method.name}, rtol {method.rtol or DEFAULT_RTOL:g}")
    )


@dataclass(frozen=True, slots=True)
class Nominal:
    """The unchanged scene: its processor time and steps a second, and the part that is run.

    It is kept, so that the next run of the command uses the same part.
    """

    cost: float
    density: float
    part: float


@dataclass(kw_only=True)
class StressSession(Session):
    """Runs points of one model, and keeps the references that several share.

    A run takes `duration` seconds of the scene, or less: the part of its nominal run.
    """

    method: Solver
    _nominal: Nominal = field(init=False)
    _driven: dict[str, Drive] = field(default_factory=dict)
    _references: dict[Settings, References] = field(default_factory=dict)

    def begin(self, *, shortened: bool) -> None:
        """Run the unchanged scene, only its first part if `shortened`; BG089 if it fails."""
        whole, budget = self.duration, self.budget.seconds

        def nominal() -> Nominal:
            times = np.array([0.0, whole])
            run = completed(timed_run(self.model, self.method, times, accounts=False, limit=budget))
            part = _portion(run.seconds, budget) if shortened else 1.0
            return Nominal(run.seconds / whole, max(run.counts["steps"], 1.0) / whole, part)

        self._nominal = self.kept(Nominal, nominal)
        self.duration = self._nominal.part * whole

    def drives(self, requested: Sequence[Drive]) -> tuple[Drive, ...]:
        """Complete the requested drives, or all of the model, by their values in the scene."""
        known = [self.model.parameters[name] for name in self.model.parameters]
        found = requested
        if not found:
            source = self.model.source_for("drives")
            graph = compile_scene(*source, until="elaborate").graph
            found = all_drives(graph, known, self.duration)
        found = tuple(self._with_own(drive, {p.name: p.value for p in known}) for drive in found)
        self._driven = {drive.name: drive for drive in found}
        return found

    def _with_own(self, drive: Drive, values: Mapping[str, float]) -> Drive:
        """Give a drive the value of the scene; parameters that differ have none."""
        method = self.method
        own: dict[str, float | None] = {
            STEP: method.step if method.fixed else None,
            RTOL: None if method.fixed else method.rtol or DEFAULT_RTOL,
            TIME: self.duration,
        }
        if drive.name not in own:
            found = {values.get(name) for name in drive.parameters}
            own[drive.name] = found.pop() if len(found) == 1 else None
        return replace(drive, own=own[drive.name])

    def seconds(self, settings: Settings) -> float:
        """Estimate the time of a point, s; 0 if it is stored. Adaptive steps may grow with time."""
        end = self._end(settings)
        if self.store.read(Judgement, settings, end) is not None:
            return 0.0
        return _RUNS * self._nominal.cost * (end if self._keeps_pace else min(end, self.duration))

    def point(self, settings: Settings) -> Point:
        """Judge settings in the remaining time, or return the stored judgement."""
        end = self._end(settings)
        most = within = self._limit(max(end, self.duration))
        if not self._keeps_pace:
            within = min(most, max(self._limit(self.duration), self.left))
        judgement = self.kept(
            Judgement,
            lambda: self._judged(settings, end, within),
            settings,
            end,
            final=lambda found: found.verdict is not Verdict.SLOW or within == most,
        )
        return Point(settings, end, judgement)

    @property
    def _keeps_pace(self) -> bool:
        """True if steps do not become longer with time."""
        return self.method.fixed or self.model.library.model.n_device > 0

    def _end(self, settings: Settings) -> float:
        """Choose the duration: shortened for short steps, so that a run stays within its limit."""
        values = dict(settings)
        if TIME in values:
            return values[TIME]
        if STEP not in values:
            return self.duration
        seconds = _SHORT_STEPS_SHARE * self._limit(self.duration)
        steps = seconds * self._nominal.density / max(self._nominal.cost, 1e-12)
        return min(self.duration, float(f"{steps * values[STEP]:.1g}"))

    def _limit(self, end: float) -> float:
        """Limit the time of a run, s."""
        return max(_AT_LEAST, _PATIENCE * self._nominal.cost * end)

    def _judged(self, settings: Settings, end: float, limit: float) -> Judgement:
        values = {
            name: value for driven, value in settings for name in self._driven[driven].parameters
        }
        try:
            model = self._model_with(values)
        except BgError as problem:
            return Judgement(Verdict.FAILS, message=reason_of(problem))
        method = self._method_with(dict(settings))
        times = np.linspace(0.0, end, _ROWS + 1)
        key = *values.items(), (TIME, end)
        references = self._references.setdefault(key, References())
        with np.errstate(all="ignore"):
            judgement = judge(model, method, times, self.accuracy, limit, references)
        for name in values:
            if name in model.parameters:
                del model.parameters[name]
        return judgement

    def _model_with(self, values: Mapping[str, float]) -> LoadedModel:
        """Set parameters in the model; compile it again for parameters that are compiled in."""
        model = self.model
        if all(name in model.parameters for name in values):
            for name, value in values.items():
                model.parameters[name] = value
            return model
        return changed_model(model, values=values)

    def _method_with(self, values: Mapping[str, float]) -> Solver:
        """Change the step or tolerance of the method; its kind's default method if it has none."""
        old = self.method
        if STEP in values:
            name, keep = old.name, old.keep
            if not old.fixed:
                name, keep = default_method(fixed=True), 0
            return Solver(name, step=values[STEP], keep=keep)
        if RTOL in values:
            name, atol = old.name, old.atol
            if old.fixed:
                name, atol = default_method(fixed=False), 0.0
            return Solver(name, rtol=values[RTOL], atol=atol)
        return old
