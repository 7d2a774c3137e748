"""Trials of a scene with coarser parts, each run against the whole scene in all cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.scenes.variants import Change
from bgc.language.methods import default_method
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field
from bgc.runtime.measuring.judging import combined, worst_error
from bgc.runtime.measuring.session import changed_model
from bgc.runtime.measuring.timed_run import Run, reason_of
from bgc.runtime.reduce.ladders import Elaborations
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.trade.judge import Target
from bgc.runtime.trade.measurement import DONE, REFUSED
from bgc.runtime.trade.reference_solution import Reference
from bgc.runtime.trade.trade_session import TradeSession

_RTOLS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
_OF_METHOD = 0.05  # of the requirement: the error that the method of trials may have by itself
_PATIENCE = 20.0  # times the run of the whole scene: the limit of a trial
_AT_LEAST = 5.0  # s that any trial may take
_KERNELS = {
    "rhs": "rhs",
    "jacobian": "jacobians",
    "factor": "factorisations",
    "solve": "solves",
}  # functions of a model, with the counts of their calls


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """The whole scene with values of its parameters, SI, and the reference of its runs."""

    values: Mapping[str, float]
    session: TradeSession
    reference: Reference
    target: Target

    def error(self, errors: Sequence[float]) -> float:
        """The error of a run over the requirement, with the doubt about the reference added."""
        return combined(errors, self.target.quantities) + self.reference.accuracy


@dataclass(frozen=True, slots=True)
class Trial:
    """A run of a scene with changes.

    Attributes
    ----------
    changes
        The changes, with `*` for the indices of arrays.
    status, message
        `done`, or `failed`, `stopped` or `refused`, with the reason.
    error, worst
        The largest error over the requirement, with the doubt about the reference, and the quantity
        that has it; of all cases, or of the first one that is not within the requirement.
    states
        The number of states.
    work
        The operations of the run of the first case, in its rates, Jacobians, factorisations and
        solutions.
    """

    changes: tuple[Change, ...]
    status: str = DONE
    message: str = ""
    error: float = float("inf")
    worst: str = ""
    states: int = 0
    work: float = 0.0

    @property
    def accurate(self) -> bool:
        """True if the error is within the requirement."""
        return self.error <= 1.0


@dataclass(slots=True)
class Trials:
    """Runs changes of a scene, and compares them with the whole scene in all cases.

    `tried` lists all trials in their order.
    """

    cases: Sequence[Case]
    elaborations: Elaborations
    method: Solver = field(init=False)
    tried: dict[tuple[Change, ...], Trial] = field(default_factory=dict)
    _whole: Run = field(init=False)

    def __post_init__(self) -> None:
        self.method, self._whole = self._calibrated()

    @property
    def whole(self) -> Trial:
        """The unchanged scene with the method of the trials."""
        return self.of(())

    def of(self, changes: Sequence[Change]) -> Trial:
        """Return the trial of changes: the one that was kept, or a new one."""
        key = tuple(sorted(changes, key=lambda change: (change.is_use, change.name)))
        if key not in self.tried:
            session = self.cases[0].session
            demands = [(case.values, case.target.quantities) for case in self.cases]
            self.tried[key] = session.kept(
                Trial, lambda: self._run(key), "trial", key, self.method, demands
            )
        return self.tried[key]

    def _calibrated(self) -> tuple[Solver, Run]:
        """The loosest method whose own error is negligible, and its run of the whole scene."""
        case = self.cases[0]
        for rtol in _RTOLS:
            method = Solver(default_method(fixed=False), rtol=rtol)
            run = self._timed(case, case.session.model, method)
            if run.status == DONE:
                errors = case.reference.instants.errors(run.rows, case.reference.rows)
                if combined(errors, case.target.quantities) <= _OF_METHOD:
                    return method, run
        method = Solver(case.reference.methods[0], rtol=case.reference.rtol)
        return method, self._timed(case, case.session.model, method)

    def _timed(self, case: Case, model: LoadedModel, method: Solver, busy: float = 1e9) -> Run:
        limit = max(case.session.left, _AT_LEAST)
        return case.reference.instants.run(model, method, accounts=False, limit=limit, busy=busy)

    def _run(self, changes: tuple[Change, ...]) -> Trial:
        """Compile the scene with changes, quickly, and run the cases until one is too far off."""
        first = self.cases[0].session.model
        names = [variable.name for variable in first.measured]
        busy = max(_AT_LEAST, _PATIENCE * self._whole.seconds)
        found = Trial(changes)
        try:
            expanded = self.elaborations.expanded(changes)
            for case in self.cases:
                whole = case.session.model
                model = changed_model(whole, expanded, preview=True) if changes else whole
                if [variable.name for variable in model.measured] != names:
                    return Trial(changes, REFUSED, "it observes something else")
                run = self._timed(case, model, self.method, busy)
                if run.status != DONE:
                    return Trial(changes, run.status, run.message, states=len(model.states))
                errors = case.reference.instants.errors(run.rows, case.reference.rows)
                error = case.error(errors)
                if found.work == 0 or error > found.error:
                    quantity, _ = worst_error(errors, case.target.quantities)
                    work = found.work or work_of(model, run.counts)
                    states = len(model.states)
                    found = Trial(changes, DONE, "", error, quantity.name, states, work)
                if not found.accurate:
                    break
        except BgError as problem:
            return Trial(changes, REFUSED, reason_of(problem))
        return found


def work_of(model: LoadedModel, counts: Mapping[str, float]) -> float:
    """Count the operations of a run in the functions that a step calls."""
    operations = dict(model.facts.operations)
    return sum(operations.get(name, 0) * counts.get(calls, 0) for name, calls in _KERNELS.items())
