"""Compile beside a live run: its graph with meters at the bonds, or other parts in its slots."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Generic, TypeVar

from bgc.building.build_result import Built
from bgc.options import Options
from bgc.record_class import dataclass, replace
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.view.aside import Answer, Aside, Request
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.scene_description import Description

Taken = TypeVar("Taken")
Post = Callable[[dict[str, Any]], None]
"""Queue of commands that takes an answer, `built_graph` or `built_model`, from another thread."""


@dataclass(frozen=True, slots=True)
class Prepared:
    """A run of a model that is ready to be reset, and what the page has to know of it."""

    run: LiveRun
    description: Description
    meshes: list[Path]


class Exchange(Generic[Taken]):
    """Compilations beside a run: at most one at a time.

    Attributes
    ----------
    busy
        What is being compiled: `graph`, `model`, or nothing (an empty text).
    """

    def __init__(
        self, path: Path, options: Options, prepare: Callable[[LoadedModel], Taken]
    ) -> None:
        """Start from a file and the options of the present model.

        `prepare` makes of a model what `take` returns: a run as that of the command.
        """
        self.busy = ""
        self._path, self._options = path, options
        self._prepare = prepare
        self._aside = Aside()

    def graph(self, post: Post) -> None:
        """Compile the present scene with meters, unless something is being compiled."""
        if not self.busy:
            self._ask("graph", self._options, post)

    def model(self, slot: str, part: str, post: Post) -> None:
        """Compile the scene with another part in a slot."""
        inner = f"{slot}."
        uses = self._options.uses
        kept = [use for use in uses if use[0] != slot and not use[0].startswith(inner)]
        options = replace(self._options, uses=(*kept, (slot, part)))
        self._ask("model", options, post)

    def _ask(self, kind: str, options: Options, post: Post) -> None:
        self.busy = kind

        def done(answer: Answer) -> None:
            post({"type": f"built_{kind}", "answer": answer, "options": options})

        self._aside.ask(Request(kind, self._path, options), done)

    def take(self, built: Built, options: Options) -> Taken:
        """Make a run of a model that was compiled; BgError where it cannot be prepared."""
        model = LoadedModel(built, self._path.absolute().parent, (self._path, options))
        prepared = self._prepare(model)
        self._options = options
        return prepared

    def close(self) -> None:
        """End what is being compiled."""
        self._aside.end()


def carried(values: dict[str, float], model: LoadedModel) -> dict[str, float]:
    """The parameter values of an earlier run that a model can take too."""
    known = [model.parameters[name] for name in values if name in model.parameters]
    return {p.name: values[p.name] for p in known if p.low <= values[p.name] <= p.high}
