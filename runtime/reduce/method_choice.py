"""The choice of the method of a reduced scene, and its comparison with the whole scene."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping, Sequence

from bgc.elaboration.scenes.variants import Change
from bgc.language.methods import METHODS
from bgc.language.solver import Solver
from bgc.record_class import dataclass, replace
from bgc.runtime.measuring.judging import worst_error
from bgc.runtime.measuring.session import changed_model
from bgc.runtime.measuring.timed_run import timed_run
from bgc.runtime.reduce.reduction import Proof, Timed
from bgc.runtime.reduce.trial import Case
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.run import choose_method
from bgc.runtime.trade.configurations import RTOLS, Configuration, scene_configurations
from bgc.runtime.trade.measurement import DONE, Measurement
from bgc.runtime.trade.trade import adaptive_and_fixed
from bgc.runtime.trade.trade_session import FOR_REPETITIONS, TradeSession

_ROUNDS = 5  # in which the scenes to be compared take turns
_WHOLE_METHODS = 6  # the cheapest of the reduced scene, with which the whole one is run too


@dataclass(frozen=True, slots=True, eq=False)
class _Accepted:
    """A method that is acceptable in all cases, with its errors in each of them."""

    row: Measurement
    errors: tuple[tuple[float, ...], ...]

    @property
    def method(self) -> Solver:
        return self.row.configuration.method


class MethodChoice:
    """The cheapest method with which a reduced scene meets the requirement in all cases.

    `method` is that of the trials, `measurements` are the methods in the first case.
    """

    def __init__(self, cases: Sequence[Case], changes: tuple[Change, ...], method: Solver) -> None:
        self.cases, self.changes = cases, changes
        self.whole = [case.session for case in cases]
        self.sessions = [
            replace(each, model=changed_model(each.model, changes), audited=None)
            for each in self.whole
        ]
        self.measurements = self._measured(method)
        self.chosen = self._accepted(self.measurements, self.sessions)

    def _measured(self, method: Solver) -> tuple[Measurement, ...]:
        case, session = self.cases[0], self.sessions[0]
        adaptive, fixed = adaptive_and_fixed(session.model, None)
        adaptive, fixed = (
            [name for name in names if name in METHODS] for names in (adaptive, fixed)
        )
        explicit = [name for name in fixed if not METHODS[name].family.jacobian]
        steps = case.session.step_ladder(case.reference) if fixed else ()
        listed = scene_configurations(adaptive, fixed, RTOLS, steps, (1,), explicit)
        sure = Configuration(method.name, rtol=method.rtol)
        wanted = [replace(each, changes=self.changes) for each in dict.fromkeys((sure, *listed))]
        session.reserve_share(FOR_REPETITIONS)
        rows = session.measure(wanted, case.reference, case.target)
        return session.repeat(session.with_worst_times(rows, case.target), case.target)

    def proof(self) -> Proof | None:
        """Compare the reduced scene with the whole one, in time and error.

        The whole scene is run with its own method, and with those that are cheapest for the reduced
        one. None where the reduced scene has no method within the requirement.
        """
        reduced = self.chosen
        if reduced is None:
            return None
        case, model = self.cases[0], self.whole[0].model
        own = choose_method(model.library, model.facts)
        whole = self._accepted(self._of_whole(), self.whole)
        second: _Accepted | None = None
        runs = {"reduced": (self.sessions[0].model, reduced.method), "own": (model, own)}
        if whole is not None:
            runs["whole"] = (model, whole.method)
            # Times of single methods are noisy: both scenes run with the method of the other, too.
            alike = replace(whole.row.configuration, changes=self.changes)
            rows = [row for row in self.measurements if row.configuration == alike]
            second = self._accepted(rows, self.sessions)
            if second is not None and second.method != reduced.method:
                runs["second"] = (self.sessions[0].model, second.method)
        seconds = _in_turns(self.whole[0], runs)
        if "reduced" not in seconds:
            return None
        other = seconds.pop("second", float("inf"))
        if other < seconds["reduced"]:
            assert second is not None
            self.chosen = reduced = second
            seconds["reduced"], runs["reduced"] = other, runs["second"]
        errors = {
            "reduced": self._error(reduced),
            "own": _own_error(case, own),
            "whole": 0.0 if whole is None else self._error(whole),
        }
        timed = {
            name: Timed(_label(method), seconds[name], errors[name])
            for name, (_, method) in runs.items()
            if name in seconds
        }
        is_whole = whole is not None and seconds.get("whole", float("inf")) <= seconds["reduced"]
        winner = whole if whole is not None and is_whole else reduced
        worst, off = max(
            (worst_error(found, each.target.quantities) for each, found in self._each(winner)),
            key=lambda pair: pair[1] / pair[0].scale,
        )
        return Proof(
            method=winner.row.configuration.statement(case.target.settle),
            error=self._error(winner),
            worst=worst,
            off=off,
            reduced=timed["reduced"],
            own=timed.get("own"),
            whole=timed.get("whole"),
            is_whole=is_whole,
        )

    def _of_whole(self) -> list[Measurement]:
        """The whole scene with the cheapest methods of the reduced one, in the first case."""
        case, session = self.cases[0], self.whole[0]
        session.reserve = 0.0
        near = sorted(filter(lambda row: _acceptable(case, row), self.measurements), key=_cpu)
        return [
            session.measured(replace(row.configuration, changes=()), case.reference)
            for row in near[:_WHOLE_METHODS]
        ]

    def _accepted(
        self, rows: Iterable[Measurement], sessions: Sequence[TradeSession]
    ) -> _Accepted | None:
        """The cheapest of methods that is acceptable in all cases."""
        for row in sorted(rows, key=_cpu):
            if not _acceptable(self.cases[0], row):
                continue
            errors = [row.errors]
            for case, session in zip(self.cases[1:], sessions[1:], strict=True):
                session.reserve = 0.0
                other = session.measured(row.configuration, case.reference)
                if not _acceptable(case, other):
                    break
                errors.append(other.errors)
            else:
                return _Accepted(row, tuple(errors))
        return None

    def _error(self, found: _Accepted) -> float:
        """The largest error of all cases over the requirement."""
        return max(case.error(errors) for case, errors in self._each(found))

    def _each(self, found: _Accepted) -> list[tuple[Case, tuple[float, ...]]]:
        return list(zip(self.cases, found.errors, strict=True))


def _acceptable(case: Case, row: Measurement) -> bool:
    return case.target.fits(row) and case.error(row.errors) <= 1.0


def _cpu(row: Measurement) -> float:
    return row.cpu


def _label(method: Solver) -> str:
    """The method with its tolerance or step, where it has one of its own."""
    is_plain = not (method.rtol or method.step)
    found = Configuration(method.name, method.rtol, method.step, max(method.keep, 1))
    return method.name if is_plain else found.label


def _own_error(case: Case, method: Solver) -> float:
    """The error of the whole scene with its own method over the requirement."""
    session = case.session
    run = case.reference.instants.run(
        session.model, method, accounts=False, limit=max(session.left, 1.0)
    )
    if run.status != DONE:
        return float("inf")
    return case.error(case.reference.instants.errors(run.rows, case.reference.rows))


def _in_turns(
    session: TradeSession, runs: Mapping[str, tuple[LoadedModel, Solver]]
) -> dict[str, float]:
    """Processor times of runs, s: medians of a few rounds in which they take turns."""
    found: dict[str, list[float]] = {name: [] for name in runs}
    for count in range(_ROUNDS):
        for name, (model, method) in runs.items():
            if count and session.left < 0:
                continue
            limit = max(session.left, 10.0)
            run = timed_run(model, method, session.times, accounts=False, limit=limit)
            if run.status == DONE:
                found[name].append(run.seconds)
    return {name: statistics.median(seconds) for name, seconds in found.items() if seconds}
