"""`bgc stress`: every drive, every value, within a budget of time."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.arguments import no_duration
from bgc.diagnostics.catalogue.stress import nominal_run_failed, nothing_to_judge
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.runtime.measuring.timed import timed_run
from bgc.runtime.running.compiling import load_model
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.progress import ProgressBar
from bgc.runtime.running.run import ADAPTIVE_DEFAULT, FIXED_DEFAULT, Method, choose_method
from bgc.runtime.stress.drives import (
    RTOL,
    STEP,
    TIME,
    Drive,
    all_drives,
    read_drive,
)
from bgc.runtime.stress.judge import (
    DEFAULT_RTOL,
    Judge,
    Judgement,
    References,
    Tolerance,
    Verdict,
    limited_run,
)
from bgc.runtime.stress.store import Settings, Store, open_store

WITHIN = 1e-3
BUDGET = 120.0

_ROWS = 200
_WANTED = 100  # points that the budget should do for, if the scene can be shortened for it
_PORTIONS = (1.0, 0.5, 0.25)  # of the scene
_RUNS = 6.0  # that a point takes about: its own and that of another method
_PATIENCE = 10.0  # times the scene's own run
_AT_LEAST = 1.0  # s for any run
_OF_PATIENCE = 0.3  # that a run of short steps takes
_COARSE = 3  # of so many values of a drive, one is looked at first


@dataclass(frozen=True, slots=True)
class Point:
    """A place of the map: what was set, how many seconds were run, and what came of it."""

    settings: Settings
    duration: float
    judgement: Judgement


@dataclass(frozen=True, slots=True)
class StressMap:
    """What `bgc stress` found.

    `drives` were driven one by one, with a point for each value; as a `grid`, two together.
    `duration` is what was run of the scene, `scene_duration` what it says, s. `planned` points were
    to be looked at; `skipped` are the drives of which the budget was too small for any, and
    `needed` is the budget that the longest of the points left takes, s.
    """

    scene: str
    method: str
    duration: float
    scene_duration: float
    tolerance: Tolerance
    grid: bool
    drives: tuple[Drive, ...]
    points: tuple[Point, ...]
    planned: int
    skipped: tuple[Drive, ...]
    needed: float

    def counts(self) -> Mapping[Verdict, int]:
        """How many points came to each verdict."""
        return Counter(point.judgement.verdict for point in self.points)

    @property
    def wrong(self) -> tuple[Point, ...]:
        """Points with wrong numbers and no word of it."""
        return tuple(p for p in self.points if p.judgement.verdict is Verdict.WRONG)

    def of_drive(self, drive: Drive) -> tuple[Point, ...]:
        """The points along a drive, of a map that is no grid."""
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
    """Drive a scene to its extremes, and hold each run against other methods.

    Points are kept in the cache as they are found: where the budget ends, or Ctrl-C, another call
    goes on.

    Parameters
    ----------
    model
        A model with its source, as `bgc.compile` gives it.
    drives
        What is driven, as `"k=1e3..1e14 N/m"`, or `"*.lock.stiffness=.."` for all of that name
        together; by default steps, tolerances, the duration, and every run-time parameter by its
        role.
    grid
        Whether two drives make a map of both together.
    solver, rtol, step
        The method that is looked at; by default the scene's.
    duration
        How much of the scene to run, s; by default all, or a part where the budget is small.
    within
        The error up to which a number holds, relative to the range of each observed quantity;
        by default what the scene's `require` asks for, else 1e-3.
    budget
        Roughly how long it may take, s.
    fresh
        Whether to forget what was found before.

    Raises
    ------
    BgError
        A drive is at fault; BG088, BG089.
    """
    if not model.measured:
        raise BgError([nothing_to_judge(model.facts.scene)])
    method = choose_method(model.library, model.facts, solver, rtol, None, step)
    full = duration or model.facts.duration
    if full is None:
        raise BgError([no_duration(model.facts.scene)])
    started = time.monotonic()
    tolerance = Tolerance(
        WITHIN if within is None else within, within is None, model.facts.requirements
    )
    store = open_store(model, method, tolerance, duration, fresh)
    if store.nominal is None:
        seconds, steps = _nominal(model, method, full, budget)
        store.nominal = seconds, steps, 1.0 if duration else _portion(seconds, budget)
    seconds, steps, part = store.nominal
    session = _Session(
        model, method, part * full, tolerance, store, cost=seconds / full, density=steps / full
    )
    wanted = session.drives(drives)
    if grid and len(wanted) != 2:
        raise ValueError("a grid takes two drives")
    plan = _grid(wanted) if grid else _in_order(wanted)
    points: list[Point] = []
    needed = 0.0
    with ProgressBar(len(plan), progress, "driving", " points") as bar:
        try:
            for settings in plan:
                bar.show(len(points))
                left = budget - (time.monotonic() - started)
                takes = session.seconds(settings)
                if not points or takes == 0 or left > (0 if drives else takes):
                    points.append(session.point(settings, left))
                else:
                    needed = max(needed, takes)
        finally:
            store.write()
    written = {(drive.name, x): k for drive in wanted for k, x in enumerate(drive.values)}
    names = [drive.name for drive in wanted]
    if not grid:
        points.sort(key=lambda p: (names.index(p.settings[0][0]), written[p.settings[0]]))
    done = {point.settings[-1][0] for point in points}
    return StressMap(
        scene=model.facts.scene or model.facts.model,
        method=_told(method),
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
    """Row after row of the second drive, so that a budget cuts whole rows."""
    across, up = drives
    return [((across.name, x), (up.name, y)) for y in up.values for x in across.values]


def _in_order(drives: Sequence[Drive]) -> list[Settings]:
    """One drive of each kind before the next, and of each every third value before the others."""
    seen: Counter[tuple[str, str]] = Counter()
    order: list[tuple[int, bool, Settings]] = []
    for drive in drives:
        kind = drive.role or drive.name, drive.unit
        for k, value in enumerate(drive.values):
            coarse = k % _COARSE == 0 or k == len(drive.values) - 1
            order.append((seen[kind], not coarse, ((drive.name, value),)))
        seen[kind] += 1
    return [settings for *_, settings in sorted(order, key=lambda item: item[:2])]


def _portion(seconds: float, budget: float) -> float:
    """The part of the scene that lets the budget do for many points, if any does."""
    affordable = budget / (_WANTED * _RUNS * max(seconds, 1e-9))
    return next((part for part in _PORTIONS if part <= affordable), _PORTIONS[-1])


def _told(method: Method) -> str:
    return (
        f"{method.name} at {method.step:g} s"
        if method.fixed
        else (f"{method.name}, rtol {method.rtol or DEFAULT_RTOL:g}")
    )


def _nominal(
    model: LoadedModel, method: Method, duration: float, limit: float
) -> tuple[float, float]:
    """The seconds and the steps that the scene takes as it is; BG089 where it does not run."""
    run = timed_run(model, method, np.array([0.0, duration]), accounts=False, limit=limit)
    if run.status != "done":
        raise BgError([nominal_run_failed(run.message)])
    return run.seconds, max(run.counts["steps"], 1.0)


@dataclass
class _Session:
    """Runs points of one model, and keeps the references that several share.

    `cost` is the processor time that a second of the scene takes as it is, s, and `density` its
    steps.
    """

    model: LoadedModel
    method: Method
    duration: float
    tolerance: Tolerance
    store: Store
    cost: float
    density: float
    _driven: dict[str, Drive] = field(default_factory=dict)
    _references: dict[Settings, References] = field(default_factory=dict)

    def drives(self, texts: Iterable[str]) -> tuple[Drive, ...]:
        """Those asked for, or all that the model has."""
        known = [self.model.parameters[name] for name in self.model.parameters]
        units = {p.name: p.unit for p in known}
        found = tuple(read_drive(text, units) for text in texts)
        if not found:
            assert self.model.origin is not None
            graph = compile_scene(*self.model.origin, until="elaborate").graph
            found = all_drives(graph, known, self.duration)
        self._driven = {drive.name: drive for drive in found}
        return found

    def seconds(self, settings: Settings) -> float:
        """What a point takes about, 0 where it is known. Free steps may become ever longer."""
        end = self._end(settings)
        if self.store.found(settings, end) is not None:
            return 0.0
        return _RUNS * self.cost * (end if self._keeps_pace else min(end, self.duration))

    def point(self, settings: Settings, left: float) -> Point:
        """What comes of some settings in the time that is left, or came of them before."""
        end = self._end(settings)
        known = self.store.found(settings, end)
        if known is None:
            limit = self._limit(max(end, self.duration))
            within = (
                limit if self._keeps_pace else min(limit, max(self._limit(self.duration), left))
            )
            known = self._judged(settings, end, within)
            if known.verdict is not Verdict.SLOW or within == limit:
                self.store.keep(settings, end, known)
        return Point(settings, end, known)

    @property
    def _keeps_pace(self) -> bool:
        """Whether steps are as long later as they are at first."""
        return self.method.fixed or self.model.library.model.n_device > 0

    def _end(self, settings: Settings) -> float:
        """How much of the scene is run: as much as is worth the wait of short steps."""
        told = dict(settings)
        if TIME in told:
            return told[TIME]
        if STEP not in told:
            return self.duration
        steps = _OF_PATIENCE * self._limit(self.duration) * self.density / max(self.cost, 1e-12)
        return min(self.duration, float(f"{steps * told[STEP]:.1g}"))

    def _limit(self, end: float) -> float:
        """The longest that a run may take."""
        return max(_AT_LEAST, _PATIENCE * self.cost * end)

    def _judged(self, settings: Settings, end: float, limit: float) -> Judgement:
        values = {
            name: value for driven, value in settings for name in self._driven[driven].parameters
        }
        try:
            model = self._model_with(values)
        except BgError as problem:
            first = problem.diagnostics[0]
            return Judgement(Verdict.FAILS, message=f"{first.code}: {first.message}")
        method = self._method_with(dict(settings))
        times = np.linspace(0.0, end, _ROWS + 1)
        key = *values.items(), (TIME, end)
        references = self._references.setdefault(key, References())
        judge = Judge(model, times, self.tolerance, limit, references)
        with np.errstate(all="ignore"):
            run = limited_run(model, method, times, accounts=bool(model.accounts), limit=limit)
            judgement = judge.judge(run, method)
        for name in values:
            if name in model.parameters:
                del model.parameters[name]
        return judgement

    def _model_with(self, values: Mapping[str, float]) -> LoadedModel:
        """The model with parameters set; compiled anew for those that are compiled in."""
        model = self.model
        if all(name in model.parameters for name in values):
            for name, value in values.items():
                model.parameters[name] = value
            return model
        assert model.origin is not None
        path, options = model.origin
        given: dict[str, Any] = {**dict(options.overrides), **values}
        return load_model(path, replace(options, overrides=(), strict=False, preview=False), given)

    def _method_with(self, told: Mapping[str, float]) -> Method:
        """The method with another step or tolerance; the default of its kind where it has none."""
        old = self.method
        if STEP in told:
            name, keep = (old.name, old.keep) if old.fixed else (FIXED_DEFAULT, 0)
            return Method(name, True, step=told[STEP], keep=keep)
        if RTOL in told:
            name, atol = (ADAPTIVE_DEFAULT, 0.0) if old.fixed else (old.name, old.atol)
            return Method(name, False, rtol=told[RTOL], atol=atol)
        return old
