"""Runs that pages steer: what the player of a live run and a loop in real time share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from queue import Queue
from typing import Any, Generic

from bgc.diagnostics.catalogue.view import aside_failed
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.render import excerpt
from bgc.runtime.view.aside import Answer
from bgc.runtime.view.part_exchange import Exchange, Taken
from bgc.runtime.view.scene_description import Description

Publish = Callable[[str, Any], None]
"""Called with `rows`, `state`, `values`, `fault`, `graph`, `powers` or `scene`, and its content."""


class Steered(ABC, Generic[Taken]):
    """A run that obeys the commands of pages one by one, each by the method `_on_NAME`.

    `epoch` counts its resets. A command that fails publishes the reason as a fault.
    """

    def __init__(self, publish: Publish, exchange: Exchange[Taken] | None) -> None:
        """Prepare a run; `exchange` compiles the graph of its scene, and other parts in slots."""
        self.epoch = 0
        self._publish = publish
        self._exchange = exchange
        self._graph: Description | None = None
        self._commands: Queue[Mapping[str, Any]] = Queue()

    @property
    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Its state, for pages."""

    @abstractmethod
    def command(self, command: Mapping[str, Any]) -> None:
        """Take a checked message of `protocol`; does not wait."""

    @abstractmethod
    def _now(self) -> float:
        """The time of a fault, s."""

    def _halt(self) -> bool:
        """Stop after a bug of bgc; False for a run that goes on."""
        return False

    @property
    def _busy(self) -> str:
        """What is being compiled beside the run."""
        return "" if self._exchange is None else self._exchange.busy

    def _obey(self, command: Mapping[str, Any]) -> None:
        self._guard(lambda: getattr(self, f"_on_{command['type']}")(command))

    def _guard(self, work: Callable[[], None]) -> None:
        """Do work. If it fails, publish the reason; the thread goes on."""
        try:
            work()
        except BgError as problem:
            self._fail(problem.diagnostics, stopped=False)
        except Exception as problem:
            text = f"this is a bug in bgc: {type(problem).__name__}: {problem}"
            message = {"code": "", "text": text, "help": "", "excerpt": ""}
            self._publish_fault([message], self._halt())

    def _fail(self, diagnostics: Sequence[Diagnostic], stopped: bool = True) -> None:
        """Publish a failure: its messages, each with the lines at fault."""
        messages = [
            {"code": d.code, "text": d.message, "help": d.help or "", "excerpt": excerpt(d)}
            for d in diagnostics
        ]
        self._publish_fault(messages, stopped)

    def _publish_fault(self, messages: Sequence[Mapping[str, str]], stopped: bool) -> None:
        self._publish("fault", {"time": self._now(), "stopped": stopped, "messages": messages})

    # --- graph and slots ------------------------------------------------------------------

    def _on_graph(self, command: Mapping[str, Any]) -> None:
        """Compile the scene with its graph, whose description has the slots."""
        if self._graph is not None:
            self._publish("graph", self._graph)
        elif self._exchange is not None:
            self._exchange.graph(self._commands.put)

    def _on_use(self, command: Mapping[str, Any]) -> None:
        if self._exchange is not None:
            self._exchange.model(command["slot"], command["part"], self._commands.put)

    def _built(self, answer: Answer) -> Any:
        """The result of a compilation beside the run. Raises BgError where it failed."""
        assert self._exchange is not None
        self._exchange.busy = ""
        if answer.result is None:
            raise BgError(answer.diagnostics or [aside_failed()])
        return answer.result

    def _exchanged(self, command: Mapping[str, Any]) -> Taken:
        """What `exchange` prepares of the model that was compiled; BgError where it cannot."""
        built = self._built(command["answer"])
        assert self._exchange is not None
        return self._exchange.take(built, command["options"])
