"""The session of `bgc trade`: measurements of configurations within a budget."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence

from bgc.language.methods import default_method
from bgc.language.solver import Solver
from bgc.record_class import dataclass, replace
from bgc.runtime.measuring.agreement import METHODS, RTOLS
from bgc.runtime.measuring.instants import instants_of
from bgc.runtime.measuring.judging import Accuracy, combined
from bgc.runtime.measuring.measured_store import Store
from bgc.runtime.measuring.session import Session
from bgc.runtime.measuring.timed_run import Budget, Run, paced_times, timed_run
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.progress import ProgressBar, tracked
from bgc.runtime.running.rows import row_times
from bgc.runtime.trade.configurations import Configuration, round_step, step_ladder
from bgc.runtime.trade.judge import DEFAULT_ACCURACY, Target, front
from bgc.runtime.trade.measurement import DONE, OUT_OF_BUDGET, REFUSED, SKIPPED, Measurement
from bgc.runtime.trade.reference_solution import Reference, find_reference

REPEATS = 3  # of configurations on or near the front, by default
_REFERENCE_SHARE = 0.4  # of the remaining budget, for the reference
_INSTANTS_SHARE = 0.1  # of the remaining budget, to find where to compare
_AT_LEAST = 5.0  # s that any configuration may take
_AS_THE_REFERENCE = 3.0  # times the time of the reference: the limit of a configuration
_DEFAULT_SAMPLE = 1e-3  # s, of devices in a scene that gives no step: see bgc.h
_SHORT = 0.05  # s: a shorter run is repeated at once
_MOST_REPEATS = 25  # of the shortest runs, whose times are disturbed most
_AUDITED = 3.0  # times the time of a run, for one with energy accounts
_MOST_PACED = 12  # configurations that are tried for the deadline
# Shares of the remaining budget that are reserved: for repetitions, and with variants.
FOR_REPETITIONS, FOR_VARIANTS = 0.25, 0.6
_SAME = 0.01  # relative difference of errors and step counts that are considered equal
_TIME_MARGIN = 1.2  # times the time of a configuration on the front: within noise of it


@dataclass(kw_only=True)
class TradeSession(Session):
    """Measures configurations of one scene against one reference.

    `times` are those of the rows, s. `repeats` is the number of runs that times are medians of.
    Measuring leaves `reserve` s of the budget. `audited` is the model with energy accounts, if the
    model itself has none. `enough` is the accuracy that a reference need not exceed; without it, a
    reference is as accurate as its share of the budget permits.
    """

    times: Array
    repeats: int
    audited: LoadedModel | None = None
    reserve: float = 0.0
    enough: float | None = None

    def reserve_share(self, share: float) -> None:
        """Reserve a share of the remaining budget."""
        self.reserve = share * self.left

    @property
    def _sampled(self) -> bool:
        return bool(self.model.library.model.n_device)

    def reference(self) -> Reference:
        """Return the stored reference, rescaled to the present requirements, or a new one."""
        found = self.kept(Reference, self._reference, "reference")
        quantities = self.accuracy.quantities(self.model, found.rows)
        return found.rescaled(quantities, self.accuracy.required)

    def _reference(self) -> Reference:
        self.store.clear()  # measurements against another reference
        with ProgressBar(self.duration, self.progress, "reference") as bar:
            accurate = [Solver(name, rtol=RTOLS[0]) for name in METHODS]
            limit = _INSTANTS_SHARE * self.left
            instants = instants_of(self.model, self.times, accurate, limit, bar.show)

            def solve(method: Solver, seconds: float) -> Run:
                return instants.run(
                    self.model, method, accounts=False, limit=seconds, watch=bar.show
                )

            requirements = dict(self.accuracy.requirements)
            share = _REFERENCE_SHARE * self.left
            enough = {} if self.enough is None else {"enough": self.enough}
            return find_reference(self.model, requirements, instants, solve, share, **enough)

    def target(self, reference: Reference) -> Target:
        """Collect the demands of the scene."""
        facts = self.model.facts
        return Target(
            quantities=self.accuracy.quantities(self.model, reference.rows),
            required=self.accuracy.required,
            deadline=facts.deadline,
            sample=(facts.step or _DEFAULT_SAMPLE) if self._sampled else None,
            floor=reference.accuracy,
            verified=reference.converged,
            settle=facts.solver.settle,
        )

    def step_ladder(self, reference: Reference) -> tuple[float, ...]:
        """List steps, s, around the scene's, or around the mean step of the adaptive default."""
        step = self.model.facts.step
        if step is None:
            row = self.measured(Configuration(default_method(fixed=False), rtol=1e-6), reference)
            step = round_step(self.duration / max(row.counts.get("steps", 1000.0), 1.0))
        return step_ladder(step, self.duration)

    def measure(
        self,
        configurations: Sequence[Configuration],
        reference: Reference,
        target: Target,
    ) -> tuple[Measurement, ...]:
        """Measure configurations in order; skip those that a coarser one makes unnecessary."""
        rows: list[Measurement] = []
        given_up: dict[object, tuple[str, str]] = {}  # with a status and a reason
        coarser: dict[object, Measurement] = {}
        with ProgressBar(len(configurations), self.progress, "measuring", "") as bar:
            for count, configuration in enumerate(configurations):
                if configuration.ladder in given_up:
                    rows.append(Measurement(configuration, *given_up[configuration.ladder]))
                    continue

                def watch(reached: float, count: int = count) -> None:
                    bar.show(count + reached / self.duration)

                row = self.measured(configuration, reference, watch)
                rows.append(row)
                last = coarser.get(configuration.ladder)
                if row.status == REFUSED:
                    given_up[configuration.ladder] = REFUSED, row.message
                elif reason := _why_no_finer(row, last, target):
                    given_up[configuration.ladder] = SKIPPED, reason
                coarser[configuration.ladder] = row
        return tuple(rows)

    def repeat(self, rows: Sequence[Measurement], target: Target) -> tuple[Measurement, ...]:
        """Repeat the configurations on or near the front as often as requested."""
        near = _near_front(rows, target)
        few = [
            k for k, r in enumerate(rows) if r.configuration in near and r.repeats < self.repeats
        ]
        finished = list(rows)
        for k in tracked(few, self.progress, "repeating"):
            finished[k] = self._repeated(rows[k])
        return tuple(finished)

    def with_worst_times(
        self, rows: Sequence[Measurement], target: Target
    ) -> tuple[Measurement, ...]:
        """Measure the worst times of the configurations for which they matter.

        With a deadline, these are the cheapest accurate ones, up to the first in time; then those
        on the front.
        """
        found = {row.configuration: row for row in rows}
        fit = [row for row in rows if target.accurate(row) and target.samples(row)]
        tried = 0
        for row in sorted(fit, key=lambda row: row.cpu):
            if target.deadline is None or tried == _MOST_PACED:
                break
            period = _period(row.configuration, target)
            if period is not None and not _hopeless(row, period, target):
                tried += not row.paced
                row = found[row.configuration] = self._paced(row, period)
            if target.timely(row) and row.certain:
                break
        on_front = front(rows, target)
        for row in (row for row in rows if row.configuration in on_front):
            if (period := _period(row.configuration, target)) is not None:
                found[row.configuration] = self._paced(found[row.configuration], period)
        return tuple(found.values())

    def _paced(self, row: Measurement, period: float) -> Measurement:
        """Add the paced worst time to a measurement, unless the budget is spent."""
        if row.paced or self.left <= 0:
            return row
        method = row.configuration.method
        paced = paced_times(
            self.model, method, period, self.duration, self.repeats, limit=self.left
        )
        if paced is None:
            return row
        found = replace(row, paced=paced.usual, slowest=paced.slowest, periods=paced.periods)
        self.store.keep(found, self.model.facts.content, found.configuration)
        return found

    def measured(
        self,
        configuration: Configuration,
        reference: Reference,
        watch: Callable[[float], None] = lambda reached: None,
    ) -> Measurement:
        """Return the stored measurement of a configuration, or a new one."""
        content = self.model.facts.content
        return self.kept(
            Measurement,
            lambda: self._in_budget(configuration, reference, watch),
            content,
            configuration,
            # A missing solver may be installed later.
            final=lambda row: row.status not in (REFUSED, SKIPPED),
        )

    def _in_budget(
        self,
        configuration: Configuration,
        reference: Reference,
        watch: Callable[[float], None],
    ) -> Measurement:
        """Measure a configuration, unless the budget is spent before or meanwhile."""
        skipped = Measurement(configuration, SKIPPED, OUT_OF_BUDGET)
        if self.left <= self.reserve:
            return skipped
        limit = max(_AT_LEAST, _AS_THE_REFERENCE * reference.seconds)
        found = self._measured(configuration, reference, limit, watch)
        return skipped if found.status == "stopped" and self.left <= self.reserve else found

    def _measured(
        self,
        configuration: Configuration,
        reference: Reference,
        busy: float,
        watch: Callable[[float], None],
    ) -> Measurement:
        """Run a configuration for at most `busy` seconds of processor time."""
        model, method, times = self.model, configuration.method, self.times
        accounts = bool(model.accounts)
        limit = self.left - self.reserve
        first = timed_run(
            model, method, times, accounts=accounts, limit=limit, busy=busy, watch=watch
        )
        if first.status != DONE:
            return Measurement(configuration, first.status, first.message, counts=first.counts)
        runs = [first]
        if first.seconds < _SHORT:
            runs += self._again(configuration, self._repeats(first.seconds) - 1)
        # Energy accounts, and values between the rows, cost time that must not be counted.
        judged = self.audited or model
        accounts = bool(judged.accounts)
        limit = max(self.left, first.seconds)
        whole = reference.instants.run(
            judged, method, accounts=accounts, limit=limit, busy=_AUDITED * busy
        )
        if whole.status != DONE:
            return Measurement(configuration, whole.status, whole.message, counts=whole.counts)
        found = Measurement(
            configuration,
            DONE,
            errors=reference.instants.errors(whole.rows[:, : len(model.measured)], reference.rows),
            residual=whole.residual if accounts else None,
            counts=first.counts,
        )
        return self._timed(found, runs)

    def _repeated(self, row: Measurement) -> Measurement:
        """Replace times by the medians of more runs, unless the budget is spent."""
        if self.left <= self.repeats * row.cpu * self.duration:
            return row
        runs = self._again(row.configuration, self._repeats(row.cpu * self.duration))
        if len(runs) < self.repeats:
            return row
        found = self._timed(row, runs)
        self.store.keep(found, self.model.facts.content, found.configuration)
        return found

    def _repeats(self, seconds: float) -> int:
        """Return how often to repeat a run of so many seconds: the shorter, the more often."""
        return max(self.repeats, min(_MOST_REPEATS, int(_SHORT / max(seconds, 1e-9))))

    def _again(self, configuration: Configuration, count: int) -> list[Run]:
        """Run a configuration so many times more, or until the budget is spent."""
        model = self.model
        accounts = bool(model.accounts)
        runs: list[Run] = []
        while len(runs) < count and self.left > 0:
            run = timed_run(
                model, configuration.method, self.times, accounts=accounts, limit=self.left
            )
            if run.status != DONE:
                break
            runs.append(run)
        return runs

    def _timed(self, row: Measurement, runs: Sequence[Run]) -> Measurement:
        """Set the times of a measurement to the medians of runs."""

        def median(name: str) -> float:
            return statistics.median(run.counts[name] for run in runs)

        seconds = statistics.median(run.seconds for run in runs)
        return replace(
            row,
            cpu=seconds / self.duration,
            mean_step=seconds / max(row.counts["steps"], 1),
            worst_step=median("worst_step_seconds"),
            worst_sample=median("worst_sample_seconds") if self._sampled else 0.0,
            repeats=len(runs),
        )


def open_session(
    model: LoadedModel,
    duration: float,
    budget: Budget,
    store: Store,
    *,
    repeats: int = REPEATS,
    progress: bool = False,
) -> TradeSession:
    """Open the session of a scene with the requirements of its facts; `duration` is in s."""
    facts = model.facts
    return TradeSession(
        model=model,
        duration=duration,
        accuracy=Accuracy(DEFAULT_ACCURACY, facts.requirements),
        store=store,
        budget=budget,
        progress=progress,
        times=row_times(duration, facts.every, None, len(model.measured)),
        repeats=repeats,
    )


def _why_no_finer(row: Measurement, coarser: Measurement | None, target: Target) -> str:
    """Return the reason why a smaller step or tolerance is unnecessary; empty if there is none."""
    if row.done and coarser is not None and coarser.done and _same(row, coarser, target):
        return f"not run: {row.configuration.setting} takes the same steps as the one before"
    if row.status == "stopped":
        return f"not run: {row.configuration.setting} takes too long already"
    if target.at_reference(row):
        return f"not run: {row.configuration.setting} is at the reference's accuracy already"
    return ""


def _same(row: Measurement, other: Measurement, target: Target) -> bool:
    """Return whether another tolerance changed nothing, as when all steps end at samples."""
    error, steps = target.error(row), row.counts["steps"]
    return (
        abs(target.error(other) - error) <= _SAME * error
        and abs(other.counts["steps"] - steps) <= _SAME * steps
    )


def _period(configuration: Configuration, target: Target) -> float | None:
    """Return the period of the work with a deadline: a sample or a fixed step; None otherwise."""
    if target.sample is not None:
        return target.sample
    return configuration.step or None


def _hopeless(row: Measurement, period: float, target: Target) -> bool:
    """Return whether even the mean time exceeds the deadline."""
    return target.deadline is not None and row.cpu * period > min(target.deadline, period)


def _near_front(rows: Sequence[Measurement], target: Target) -> frozenset[Configuration]:
    """Find configurations that noise may keep off the front or from being the cheapest."""
    on_front = [row for row in rows if row.configuration in front(rows, target)]
    fit = [row for row in rows if target.fits(row)]
    on_front += sorted(fit, key=lambda row: row.cpu)[:1]
    return frozenset(
        row.configuration
        for row in rows
        if row.done
        and any(
            row.cpu <= _TIME_MARGIN * other.cpu
            and combined(row.errors, target.quantities) <= max(target.error(other), target.floor)
            for other in on_front
        )
    )
