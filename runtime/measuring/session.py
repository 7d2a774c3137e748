"""The session of a study: what `bgc trade`, `bgc stress` and `bgc activity` have in common.

A study runs a scene and changes of it within a budget, compares the runs, and keeps what it found.
What it varies, and how it judges, is added by each study.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from bgc.elaboration.scenes.variants import Change, with_changes
from bgc.record_class import dataclass, replace
from bgc.runtime.measuring.judging import Accuracy
from bgc.runtime.measuring.measured_store import Store
from bgc.runtime.measuring.timed_run import Budget
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.model_loading import load_model
from bgc.runtime.running.parameters import NOTHING, ParameterValue

_Record = TypeVar("_Record")


@dataclass(kw_only=True)
class Session:
    """Runs of a scene over `duration` seconds, and of changes of it, within a budget.

    `accuracy` is the acceptable error, `store` keeps what was found, and `progress` asks for a bar
    on a terminal.
    """

    model: LoadedModel
    duration: float
    accuracy: Accuracy
    store: Store
    budget: Budget
    progress: bool = False

    @property
    def left(self) -> float:
        """Seconds of the budget that are left."""
        return self.budget.left

    def kept(
        self,
        kind: type[_Record],
        find: Callable[[], _Record],
        *key: object,
        final: Callable[[_Record], bool] = lambda record: True,
    ) -> _Record:
        """Return the record that was kept under a key, or find it now, and keep it if `final`."""
        if (stored := self.store.read(kind, *key)) is not None:
            return stored
        found = find()
        if final(found):
            self.store.keep(found, *key)
        return found


def changed_model(
    model: LoadedModel,
    changes: Sequence[Change] = (),
    values: Mapping[str, ParameterValue] = NOTHING,
    **options: Any,
) -> LoadedModel:
    """Load the scene of a model with changed lines, values of parameters and compiler options.

    All other parameters have the values that are set in the model. Warnings do not refuse a change.
    Raises ValueError for a model without its source, and the errors of compilation.
    """
    path, given = model.source_for("variants")
    given = replace(with_changes(given, changes), strict=False, **options)
    found = load_model(path, given, values)
    found.parameters.take(model.parameters, but={*values, *(change.name for change in changes)})
    return found
