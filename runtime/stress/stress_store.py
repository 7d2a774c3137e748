"""Judged points kept between runs of `bgc stress`, so that an interrupted map can continue."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass, field

from bgc.building.record_json import from_json, to_json
from bgc.language.solver import Solver
from bgc.runtime.measuring.judging import Accuracy, Note, note_of
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.stress.stress_judge import Judgement

_EVERY = 1.0  # s between two writes

Settings = tuple[tuple[str, float], ...]


@dataclass(slots=True)
class Store:
    """The judged points of one scene, by settings and duration.

    `nominal` has the seconds and steps of the unchanged scene, and the part of its duration that is
    run: it is stored so that the next run of the command uses the same part.
    """

    note: Note
    nominal: tuple[float, float, float] | None = None
    points: dict[str, Judgement] = field(default_factory=dict)
    written: float = -_EVERY

    def found(self, settings: Settings, end: float) -> Judgement | None:
        """Return the stored judgement of a point, if there is one."""
        return self.points.get(_name(settings, end))

    def keep(self, settings: Settings, end: float, judgement: Judgement) -> None:
        """Store the judgement of a point."""
        self.points[_name(settings, end)] = judgement
        if time.monotonic() - self.written > _EVERY:
            self.write()

    def write(self) -> None:
        """Write all points; a full disk is ignored."""
        points = {name: to_json(found) for name, found in self.points.items()}
        self.note.write({"nominal": self.nominal, "points": points})
        self.written = time.monotonic()


def open_store(
    model: LoadedModel, method: Solver, tolerance: Accuracy, duration: float | None, fresh: bool
) -> Store:
    """Open the store of a scene with its present parameters, a method and a tolerance."""
    store = Store(note_of(model, "stress", (method, tolerance, duration)))
    if fresh:
        return store
    with suppress(TypeError, KeyError, ValueError):  # nothing, or damaged
        value = store.note.read()
        points = {name: from_json(Judgement, found) for name, found in value["points"].items()}
        seconds, steps, part = map(float, value["nominal"])
        store.nominal, store.points = (seconds, steps, part), points
    return store


def _name(settings: Settings, end: float) -> str:
    return repr((settings, end))
