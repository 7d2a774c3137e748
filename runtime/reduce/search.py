"""The search for the coarsest scene that meets its requirements."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from bgc.elaboration.scenes.variants import Change
from bgc.record_class import dataclass, field
from bgc.runtime.reduce.ladders import Form, Ladder
from bgc.runtime.reduce.trial import Trial, Trials

MODEL_SHARE = 0.8
"""Share of the requirement that the model may use; the method has the rest."""

FAINT = 1e-3
"""Share of the activity up to which parts are changed together before each by itself."""

_AT_ONCE = 0.25  # of the error that is left: a change that takes more waits for the others
_HOPELESS = 30.0  # times the requirement: the error of a form whose part is given up soon
_MOST_HOPELESS = 2  # such forms of a part
_WORTHWHILE = 0.99  # of the work: a change has to go below it


@dataclass(frozen=True, slots=True)
class Stage:
    """Changes that were accepted, with the trials before and after them."""

    changes: tuple[Change, ...]
    before: Trial
    after: Trial


@dataclass(slots=True)
class Search:
    """Gives parts coarser forms as long as the scene stays within its requirements.

    Parts with little activity come first, all together, and by halves where that is too much; then
    the others, those first that save most, each from its coarsest form on. A form that would take
    more than a quarter of the error that is left waits until all parts had their turn.

    `shares` are the shares of the activity by part; parts without one count as active. `is_over`
    ends the search with what is accepted, and `ended` says that it did.
    """

    trials: Trials
    shares: Mapping[str, float]
    is_over: Callable[[], bool]
    watch: Callable[[Trial], None] = lambda trial: None
    stages: list[Stage] = field(default_factory=list)
    ended: bool = False
    _accepted: dict[str, Form] = field(default_factory=dict)
    _waiting: list[tuple[float, Ladder, Form]] = field(default_factory=list)

    @property
    def best(self) -> Trial:
        """The trial of all accepted changes."""
        return self.trials.of(_joined(self._accepted.values()))

    def run(self, ladders: Sequence[Ladder]) -> Trial:
        """Search, and return the trial of all accepted changes."""
        shares = {ladder.part: self.shares.get(ladder.part, 1.0) for ladder in ladders}
        faint = sorted(
            (ladder for ladder in ladders if shares[ladder.part] <= FAINT),
            key=lambda ladder: shares[ladder.part],
        )
        self._together(faint)
        others = [ladder for ladder in ladders if ladder not in faint]
        for ladder in sorted(others, key=lambda ladder: -ladder.forms[0].saved):
            self._descend(ladder)
        self._return_to_waiting()
        return self.best

    def _together(self, ladders: Sequence[Ladder]) -> None:
        """Give parts their coarsest forms together, or each half of them by itself."""
        free = [ladder for ladder in ladders if self._is_free(ladder.forms[0])]
        if len(free) < 2:
            for ladder in free:
                self._descend(ladder)
            return
        forms = {ladder.part: ladder.forms[0] for ladder in _apart(free)}
        trial = self._tried(forms)
        if trial is None or self._take(forms, trial, _AT_ONCE):
            return
        half = len(free) // 2
        self._together(free[:half])
        self._together(free[half:])

    def _descend(self, ladder: Ladder) -> None:
        """Try the forms of a part, the coarsest first, until one is accepted."""
        hopeless = 0
        for form in ladder.forms:
            trial = self._tried({ladder.part: form}) if self._is_free(form) else None
            if trial is None or self._take({ladder.part: form}, trial, _AT_ONCE):
                return
            if trial.error <= MODEL_SHARE:
                self._waiting.append((trial.error - self.best.error, ladder, form))
            hopeless += trial.error > _HOPELESS
            if hopeless == _MOST_HOPELESS:
                return

    def _return_to_waiting(self) -> None:
        """Try the forms that waited, those first that save most for their error."""
        for _, ladder, form in sorted(self._waiting, key=lambda each: each[0] / each[2].saved):
            present = self._accepted.get(ladder.part)
            if present is not None and present.saved >= form.saved:
                continue
            if present is None and not self._is_free(form):
                continue
            trial = self._tried({ladder.part: form})
            if trial is None:
                return
            self._take({ladder.part: form}, trial, 1.0)

    def _tried(self, forms: Mapping[str, Form]) -> Trial | None:
        """The trial with these forms besides what is accepted; None where the search is over."""
        if self.ended or self.is_over():
            self.ended = True
            return None
        trial = self.trials.of(_joined({**self._accepted, **forms}.values()))
        self.watch(trial)
        return trial

    def _take(self, forms: Mapping[str, Form], trial: Trial, share: float) -> bool:
        """Accept forms whose error is at most a share of what is left, if they save work."""
        before = self.best
        allowed = before.error + share * max(MODEL_SHARE - before.error, 0.0)
        if trial.error > allowed or trial.work > _WORTHWHILE * before.work:
            return False
        self._accepted.update(forms)
        self.stages.append(Stage(_joined(forms.values()), before, trial))
        return True

    def _is_free(self, form: Form) -> bool:
        """Return whether no accepted change replaces the part around, or a part inside."""
        return not any(_exclude(form, other) for other in self._accepted.values())


def _joined(forms: Iterable[Form]) -> tuple[Change, ...]:
    return tuple(dict.fromkeys(change for form in forms for change in form.changes))


def _apart(ladders: Sequence[Ladder]) -> list[Ladder]:
    """Leave out those whose coarsest form excludes one before."""
    found: list[Ladder] = []
    for ladder in ladders:
        if not any(_exclude(ladder.forms[0], other.forms[0]) for other in found):
            found.append(ladder)
    return found


def _exclude(form: Form, other: Form) -> bool:
    return any(one.excludes(two) for one in form.changes for two in other.changes)
