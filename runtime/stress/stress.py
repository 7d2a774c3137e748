"""`bgc stress`: every drive, every value, within a budget of time."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bgc.driver import Compilation
from bgc.grammar.catalogue.arguments import no_duration
from bgc.grammar.catalogue.stress import nominal_run_failed, nothing_to_judge
from bgc.grammar.diagnostics import BgError
from bgc.runtime.compiling import compile_model
from bgc.runtime.model import Model
from bgc.runtime.progress import ProgressBar
from bgc.runtime.run import FIXED_DEFAULT, Method, choose_method
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
    Reference,
    Tolerance,
    Verdict,
)
from bgc.runtime.trade.measure import timed_run

WITHIN = 1e-3
BUDGET = 120.0

_ROWS = 200
_WANTED = 300  # points that the budget should do for, if the scene can be shortened for it
_SHORTEST = 0.02  # of the scene
_RUNS = 4.0  # that a point takes about: its own and those of the reference
_PATIENCE = 10.0  # times the scene's own run
_AT_LEAST = 1.0  # s for any run

Settings = tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class Point:
    """A place of the map: what was set, and what came of it."""

    settings: Settings
    judgement: Judgement


@dataclass(frozen=True, slots=True)
class StressMap:
    """What `bgc stress` found.

    `drives` were driven one by one, with a point for each value; as a `grid`, two together.
    `duration` is what was run of the scene, `scene_duration` what it says, s. `skipped` are the
    drives for which the budget was too small.
    """

    scene: str
    method: str
    duration: float
    scene_duration: float
    tolerance: Tolerance
    grid: bool
    drives: tuple[Drive, ...]
    points: tuple[Point, ...]
    skipped: tuple[Drive, ...]

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
    model: Model,
    drives: Sequence[str] = (),
    *,
    grid: bool = False,
    solver: str | None = None,
    rtol: float | None = None,
    step: float | None = None,
    duration: float | None = None,
    within: float | None = None,
    budget: float = BUDGET,
    progress: bool = False,
) -> StressMap:
    """Drive a scene to its extremes, and hold each run against a reference of two methods.

    Parameters
    ----------
    model
        A model with its source, as `bgc.compile` gives it.
    drives
        What is driven, as `"k=1e3..1e14 N/m"`; by default the method's step or tolerance, the
        duration, and every run-time parameter by its role.
    grid
        Whether two drives make a map of both together.
    solver, rtol, step
        The method that is looked at; by default the scene's.
    duration
        How much of the scene to run, s; by default all, or as much as the budget allows.
    within
        The error up to which a number holds, relative to the range of each observed quantity;
        by default what the scene's `require` asks for, else 1e-3.
    budget
        Roughly how long it may take, s.

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
    seconds = _time_of_nominal(model, method, full, budget)
    chosen = full
    if duration is None:
        affordable = budget / (_WANTED * _RUNS * max(seconds, 1e-4))
        chosen = full * min(1.0, max(_SHORTEST, affordable))
    session = _Session(
        model,
        method,
        chosen,
        Tolerance(WITHIN if within is None else within, within is None, model.facts.requirements),
        limit=max(_AT_LEAST, _PATIENCE * seconds * chosen / full),
    )
    wanted = session.drives(drives)
    if grid and len(wanted) != 2:
        raise ValueError("a grid takes two drives")
    plan = (
        _grid(wanted)
        if grid
        else [(drive, [((drive.name, v),) for v in drive.values]) for drive in wanted]
    )
    points: list[Point] = []
    skipped: list[Drive] = []
    total = sum(len(settings) for _, settings in plan)
    with ProgressBar(total, progress, "driving", " points") as bar:
        for drive, places in plan:
            if time.monotonic() - started > budget and points:
                skipped.append(drive)
                continue
            for settings in places:
                bar.show(len(points))
                points.append(Point(settings, session.judged(settings)))
    return StressMap(
        model.facts.scene or model.facts.model,
        _told(method),
        chosen,
        full,
        session.tolerance,
        grid,
        tuple(drive for drive in wanted if drive not in skipped),
        tuple(points),
        tuple(skipped),
    )


def _grid(drives: Sequence[Drive]) -> list[tuple[Drive, list[Settings]]]:
    """Row after row of the second drive, so that a budget cuts whole rows."""
    across, up = drives
    return [(up, [((across.name, x), (up.name, y)) for x in across.values]) for y in up.values]


def _told(method: Method) -> str:
    return (
        f"{method.name} at {method.step:g} s"
        if method.fixed
        else (f"{method.name}, rtol {method.rtol or DEFAULT_RTOL:g}")
    )


def _time_of_nominal(model: Model, method: Method, duration: float, limit: float) -> float:
    """Seconds that the scene takes as it is; BG089 where it does not run."""
    run = timed_run(model, method, np.array([0.0, duration]), accounts=False, limit=limit)
    if run.status != "done":
        raise BgError([nominal_run_failed(run.message)])
    return run.seconds


@dataclass
class _Session:
    """Runs points of one model, and keeps the references that several share."""

    model: Model
    method: Method
    duration: float
    tolerance: Tolerance
    limit: float
    _references: dict[tuple[Settings, float], Reference] = field(default_factory=dict)

    def drives(self, texts: Iterable[str]) -> tuple[Drive, ...]:
        """Those asked for, or all that the model has."""
        known = [self.model.parameters[name] for name in self.model.parameters]
        units = {p.name: p.unit for p in known}
        if given := tuple(read_drive(text, units) for text in texts):
            return given
        assert self.model.origin is not None
        graph = Compilation(*self.model.origin).graph
        return all_drives(graph, known, self.method.fixed, self.duration)

    def judged(self, settings: Settings) -> Judgement:
        """Run one point."""
        values = {n: v for n, v in settings if n not in (STEP, RTOL, TIME)}
        try:
            model = self._model_with(values)
        except BgError as problem:
            first = problem.diagnostics[0]
            return Judgement(Verdict.FAILS, message=f"{first.code}: {first.message}")
        told = dict(settings)
        end = told.get(TIME, self.duration)
        method = self._method_with(told)
        times = np.linspace(0.0, end, _ROWS + 1)
        with np.errstate(all="ignore"):
            run = timed_run(model, method, times, accounts=bool(model.accounts), limit=self.limit)
            rtol = 0.0 if method.fixed else method.rtol or DEFAULT_RTOL
            key = tuple(values.items()), end
            judge = Judge(model, times, self.tolerance, self.limit)
            judgement = judge.judge(run, rtol, lambda: self._reference(judge, key))
        for name in values:
            if name in model.parameters:
                del model.parameters[name]
        return judgement

    def _model_with(self, values: Mapping[str, float]) -> Model:
        """The model with parameters set; compiled anew for those that are compiled in."""
        model = self.model
        if all(name in model.parameters for name in values):
            for name, value in values.items():
                model.parameters[name] = value
            return model
        assert model.origin is not None
        path, options = model.origin
        given: dict[str, Any] = {**dict(options.overrides), **values}
        return compile_model(
            path, options.scene, given, whole=options.whole, uses=dict(options.uses)
        )

    def _method_with(self, told: Mapping[str, float]) -> Method:
        old = self.method
        if STEP in told:
            name = old.name if old.fixed else FIXED_DEFAULT
            return Method(name, True, step=told[STEP], keep=old.keep)
        if RTOL in told and not old.fixed:
            return Method(old.name, False, rtol=told[RTOL], atol=old.atol)
        return old

    def _reference(self, judge: Judge, key: tuple[Settings, float]) -> Reference:
        if key not in self._references:
            self._references[key] = judge.reference()
        return self._references[key]
