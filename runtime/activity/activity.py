"""`bgc activity`: activities of parts, and simplifications of the scene, verified by runs."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.stress import nothing_to_judge
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.elaboration.scenes.variants import Change
from bgc.emission.operation_cost import Cost, cost_of
from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.activity.powers import Activity, activities, metered_model
from bgc.runtime.activity.simplifications import Candidate, open_variants, possible_changes
from bgc.runtime.measuring.instants import Instants, instants_of
from bgc.runtime.measuring.judging import Accuracy, duration_of, worst_error
from bgc.runtime.measuring.session import Session, changed_model
from bgc.runtime.measuring.timed_run import Budget, Run, completed, reason_of, timed_run
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.progress import tracked
from bgc.runtime.running.rows import row_times
from bgc.runtime.running.run import choose_method

NEGLIGIBLE = 0.01
WITHIN = 0.01
BUDGET = 120.0
_ROWS = 2000
_REPEATS = 3
_PATIENCE = 10.0  # times the scene's own run
_AT_LEAST = 1.0  # s that any run may take
_TOGETHER = 2.0  # times a trial: what has to be left for another one


@dataclass(frozen=True, slots=True)
class Trial:
    """Changes made together, and their effect; `error` is None if they were `refused`.

    `activity` is that of the elements concerned, J. `error` is the largest error of the observed
    quantities, relative to their range or to the accuracy of `require`, and `worst` the quantity
    that has it. `time` is the processor time relative to that of the unchanged scene.
    """

    changes: tuple[Change, ...]
    activity: float
    error: float | None = None
    worst: str = ""
    time: float | None = None
    cost: Cost | None = None
    refused: str = ""


@dataclass(frozen=True, slots=True)
class ActivityReport:
    """The activities of a scene, and the trials of simplifications.

    `activities` are those of all elements, the largest first; `spread` is the relative change of
    their sum with every second row alone. `trials` are the changes tried one by one; `together`
    are as many of the acceptable ones as are acceptable at once. `limit` is 1 where errors are
    relative to `require`. `left` counts changes for which there was no time.
    """

    scene: str
    method: str
    duration: float
    activities: tuple[Activity, ...]
    spread: float
    cost: Cost
    trials: tuple[Trial, ...]
    together: Trial | None
    limit: float
    required: bool
    left: int

    @property
    def total(self) -> float:
        """The activity of all elements, J."""
        return sum(activity.activity for activity in self.activities)

    def is_acceptable(self, trial: Trial) -> bool:
        """Return whether the error of a trial is within the limit."""
        return trial.error is not None and trial.error <= self.limit

    @property
    def variants(self) -> tuple[tuple[Change, ...], ...]:
        """Acceptable changes that save operations: first those made together, then single ones."""
        cheaper = [t for t in self.trials if self.is_acceptable(t) and _saves(t, self.cost)]
        cheaper.sort(key=lambda trial: trial.time or 0.0)
        together = [self.together] if self.together is not None else []
        return tuple(dict.fromkeys(trial.changes for trial in (*together, *cheaper)))


def activity_report(
    model: LoadedModel,
    *,
    duration: float | None = None,
    negligible: float = NEGLIGIBLE,
    within: float = WITHIN,
    budget: float = BUDGET,
    progress: bool = False,
) -> ActivityReport:
    """Measure the activities of a scene, and try to simplify parts with little activity.

    Acceptable simplifications are stored for `bgc trade`.

    Parameters
    ----------
    model
        A model with its source.
    duration
        How much of the scene to run, s; by default all.
    negligible
        The share of activity up to which a part is simplified or switched off in trials.
    within
        The acceptable error relative to the range of each observed quantity; `require` in the scene
        replaces it.
    budget
        The approximate time for the trials, s.

    Raises
    ------
    BgError
        BG088 if the scene observes nothing, BG089 if it does not run.
    """
    clock = Budget(budget)
    for name, value in (("within", within), ("budget", budget)):
        if not value > 0:
            raise BgError([bad_option(name, value, "a positive number")])
    end = duration_of(model, duration, nothing_to_judge)
    path, options = model.source_for("activities")
    method = choose_method(model.library, model.facts)
    base = compile_scene(path, options, until="lower")
    times = row_times(end, end / _ROWS, None, len(model.measured))
    session = ActivitySession(
        model=model,
        duration=end,
        accuracy=Accuracy(within, model.facts.requirements),
        store=open_variants(model),
        budget=clock,
        progress=progress,
        method=method,
        instants=instants_of(model, times, [method], budget),
        cost=cost_of(base.lowered),
    )
    session.begin()
    metered, graph = metered_model(model)
    limit = max(session.left, _AT_LEAST)
    run = completed(timed_run(metered, method, times, accounts=False, limit=limit))
    found, spread = activities(metered, graph, times, run.rows)
    candidates = possible_changes(
        base.package,
        base.graph,
        {name: parameter.value for name, parameter in model.parameters.items()},
        found,
        negligible,
    )
    trials: list[Trial] = []
    took = 0.0
    for candidate in tracked(candidates, progress, "trying", " changes"):
        before = session.left
        if before < _TOGETHER * took:  # changes made together take as long again
            break
        trials.append(session.tried((candidate,)))
        took = before - session.left
    report = ActivityReport(
        scene=model.facts.name or model.facts.model,
        method=method.name,
        duration=end,
        activities=found,
        spread=spread,
        cost=session.cost,
        trials=tuple(trials),
        together=session.together(trials),
        limit=session.accuracy.limit,
        required=session.accuracy.required,
        left=len(candidates) - len(trials),
    )
    session.store.keep(report.variants)
    return report


def _saves(trial: Trial, base: Cost) -> bool:
    """Return whether a step takes fewer operations than one of the unchanged scene."""
    found = trial.cost
    return found is not None and found.operations(1, 1, 1, 1) < base.operations(1, 1, 1, 1)


@dataclass(kw_only=True)
class ActivitySession(Session):
    """The unchanged scene, and trials compared with it.

    `cost` is that of the scene, which `method` runs to `instants`.
    """

    method: Solver
    instants: Instants
    cost: Cost

    def begin(self) -> None:
        """Run the unchanged scene; BG089 if it does not run."""
        self._names = [variable.name for variable in self.model.measured]
        self._base = completed(self._timed(self.model, max(self.left, _AT_LEAST)))
        self._quantities = self.accuracy.quantities(self.model, self._base.rows)

    def _timed(self, model: LoadedModel, limit: float) -> Run:
        """Run a few times, as far as the budget permits; return a run with the median time."""
        runs: list[Run] = []
        while len(runs) < _REPEATS and (not runs or self.left > runs[0].seconds):
            runs.append(self.instants.run(model, self.method, accounts=False, limit=limit))
        done = [run for run in runs if run.status == "done"]
        if not done:
            return runs[0]
        middle = statistics.median(run.seconds for run in done)
        return Run("done", "", done[0].rows, middle, done[0].counts)

    def tried(self, candidates: Sequence[Candidate]) -> Trial:
        """Run the scene with changes, and compare."""
        changes = tuple(candidate.change for candidate in candidates)
        activity = sum(candidate.activity for candidate in candidates)
        try:
            model = changed_model(self.model, changes)
            cost = cost_of(compile_scene(*model.source_for("costs"), until="lower").lowered)
        except BgError as problem:
            return Trial(changes, activity, refused=reason_of(problem))
        if [variable.name for variable in model.measured] != self._names:
            return Trial(changes, activity, refused="it observes something else")
        patience = max(2.0, _PATIENCE * self._base.seconds)
        run = self._timed(model, max(min(patience, self.left), _AT_LEAST))
        if run.status != "done":
            return Trial(changes, activity, refused=run.message)
        errors = self.instants.errors(run.rows, self._base.rows)
        quantity, error = worst_error(errors, self._quantities)
        return Trial(
            changes,
            activity,
            error / quantity.scale,
            quantity.name,
            run.seconds / max(self._base.seconds, 1e-9),
            cost,
        )

    def together(self, trials: Sequence[Trial]) -> Trial | None:
        """Try all acceptable changes that save operations at once, by rising error.

        The last ones are dropped until the error is acceptable, or the budget is spent. Of changes
        that exclude each other, the first is taken.
        """
        good = [t for t in trials if t.error is not None and t.error <= self.accuracy.limit]
        good = [trial for trial in good if _saves(trial, self.cost)]
        good.sort(key=lambda trial: trial.error or 0.0)
        chosen: list[Candidate] = []
        for trial in good:
            (change,) = trial.changes
            if not any(change.excludes(other.change) for other in chosen):
                chosen.append(Candidate(change, trial.activity))
        while chosen and self.left > 0:
            found = self.tried(chosen)
            if found.error is not None and found.error <= self.accuracy.limit:
                return found
            chosen.pop()
        return None
