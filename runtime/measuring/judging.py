"""What studies of errors share: methods of references, acceptable errors, notes in the cache."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from bgc.building.cache import digest_of, open_cache, read_note, write_note
from bgc.diagnostics.catalogue.arguments import no_duration
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.runtime.measuring.errors import Quantity, quantities_of
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.identity import scene_identity
from bgc.runtime.running.loaded_model import LoadedModel

METHODS = ("radau5", "rodas5p", "rodas4p2", "dopri5")
"""Methods of references; those that come first complete most runs."""

RTOLS = (1e-8, 1e-10, 1e-12)
"""Tolerances of references, each tried where the one before is not enough."""

AT_THE_REFERENCE = 3.0
"""Times the accuracy of a reference: smaller errors may be its own."""


@dataclass(frozen=True, slots=True)
class Accuracy:
    """The acceptable error: the `requirements` of a scene, or else `within`, a part of the range.

    The error is that of the worst quantity, over its requirement or its range.
    """

    within: float
    requirements: tuple[tuple[str, float], ...] = ()

    @property
    def required(self) -> bool:
        """True if the scene has requirements."""
        return bool(self.requirements)

    @property
    def limit(self) -> float:
        """The largest acceptable error."""
        return 1.0 if self.required else self.within

    def quantities(self, model: LoadedModel, reference: Array) -> tuple[Quantity, ...]:
        """The observed quantities with the scales of their errors; `reference` is (n, m)."""
        return quantities_of(model.measured, reference, dict(self.requirements))


def duration_of(
    model: LoadedModel, duration: float | None, unobserved: Callable[[str], Diagnostic]
) -> float:
    """The time of the runs of a study, s: the given one, else that of the scene.

    Raises BgError where neither is known, and `unobserved` where the scene observes nothing.
    """
    end = model.facts.duration if duration is None else duration
    if end is None:
        raise BgError([no_duration(model.facts.name)])
    if not model.measured:
        raise BgError([unobserved(model.facts.name)])
    return end


@dataclass(frozen=True, slots=True)
class Note:
    """A JSON value in the cache that belongs to a scene as it is compiled, with its parameters."""

    key: str

    def read(self) -> Any:
        """The value; None where there is none or it is damaged."""
        return read_note(open_cache().root, self.key)

    def write(self, value: object) -> None:
        """Keep the value; a full disk is ignored, since a study can be repeated."""
        with suppress(OSError):
            write_note(open_cache().root, self.key, value)


def note_of(model: LoadedModel, study: str, *facts: object) -> Note:
    """The note of a study of a scene; `facts` are what its results depend on besides."""
    return Note(digest_of((study, *scene_identity(model), *map(repr, facts))))
