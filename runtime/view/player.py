"""The thread that advances a live run in pace with the clock."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from queue import Empty, Queue
from threading import Thread
from time import monotonic
from typing import Any, Final

import numpy as np

from bgc.diagnostics.catalogue.view import aside_failed, file_changed
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.render import excerpt
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import text
from bgc.runtime.view.aside import Answer
from bgc.runtime.view.history import Rows, as_rows
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.meter import Meter
from bgc.runtime.view.part_exchange import Exchange, Prepared, carried

FRAME: Final = 1 / 60  # s of the clock between two frames
SPEEDS: Final = (1e-6, 100.0)  # simulated seconds for each second of the clock
METERING: Final = 1 / 15  # s of the clock between two readings of the bonds
_MOST_ROWS: Final = 16  # in a frame
_LATE: Final = 0.1  # s behind the clock after which the lost time is given up
_SHARE: Final = 0.8  # of a frame that computing may take before the chunks become shorter
_FREQUENT: Final = ("hand",)  # commands that come each frame; others are answered by the state
_SLOWEST_FRAME: Final = 1 / 15  # s of computing in a frame of a run that cannot keep up

Publish = Callable[[str, Any], None]
"""Called in the thread of the player with `rows`, `state`, `values` or `fault`."""


class Player:
    """A live run with the buttons of a player.

    `publish` gets `("rows", (epoch, rows))`, `("state", {..})`, `("values", [..])`,
    `("fault", {..})`, `("graph", {..})`, `("powers", (epoch, row))`, and `("scene", (description,
    meshes))` when the model is exchanged; the epoch counts the resets. Commands are queued and take
    effect between two frames.
    """

    def __init__(
        self,
        run: LiveRun,
        publish: Publish,
        duration: float | None = None,
        every: float | None = None,
        exchange: Exchange[Prepared] | None = None,
    ) -> None:
        """Prepare a player, which pauses first after `duration`, by default the scene's, s.

        `every` is the longest interval between two rows, by default the scene's, s. `exchange`
        compiles the graph, and other parts in slots.
        """
        duration = duration or run.model.facts.duration
        every = every or run.model.facts.every
        self._run = run
        self._publish = publish
        self._commands: Queue[Mapping[str, Any]] = Queue()
        self._thread = Thread(target=self._loop, daemon=True, name="bgc view")
        self._duration = duration or math.inf
        self._every = every or math.inf
        self.speed = usual_speed(duration)
        self.playing = False
        self.ended = False
        self.epoch = 0
        self._exchange = exchange
        self._meter: Meter | None = None
        self._graph: dict[str, Any] | None = None
        self._is_watched = False
        self._metered = 0.0
        self._ready = False
        self._pause_at = self._duration
        self._ratio = math.inf  # simulated seconds for each second of computing, smoothed
        self._actual = 0.0

    @property
    def state(self) -> dict[str, Any]:
        """The state of the player, for clients."""
        return {
            "playing": self.playing,
            "speed": self.speed,
            "actual": self._actual,
            "ended": self.ended,
            "epoch": self.epoch,
            "ready": self._ready,
            "held": self._run.hands.held,
            "busy": self._exchange.busy if self._exchange is not None else "",
        }

    def start(self, first: Array) -> None:
        """Begin with the row of a run that has been reset, and keep the clock."""
        self._ready = True
        self._emit(np.zeros(1), first[None])
        self._thread.start()

    def command(self, command: Mapping[str, Any]) -> None:
        """Queue a command of a client: a checked message of `protocol`."""
        self._commands.put(command)
        if command["type"] == "reset":
            self._run.stop()

    def close(self) -> None:
        """End the run and the thread; devices have zero force afterwards."""
        if self._exchange is not None:
            self._exchange.close()
        self._commands.put({"type": "close"})
        self._run.stop()
        if self._thread.is_alive():
            self._thread.join(timeout=2)

    # --- the thread -----------------------------------------------------------------------

    def _loop(self) -> None:
        due = monotonic()
        measured = due, self._run.time
        while True:
            if not self.playing:
                if not self._obey(None):
                    break
                due = monotonic()
                measured = due, self._run.time
                continue
            if not self._obey(max(0.0, due - monotonic())):
                break
            if monotonic() < due or not self.playing:
                continue
            due = due + FRAME if monotonic() - due < _LATE else monotonic() + FRAME
            self._guard(self._advance)
            self._guard(self._read_meter)
            now = monotonic()
            if now - measured[0] > 0.5:
                self._actual = (self._run.time - measured[1]) / (now - measured[0])
                measured = now, self._run.time
                self._publish("state", self.state)
        self._run.close()

    def _obey(self, wait: float | None) -> bool:
        """Wait for a command, and obey it; False for that to close."""
        try:
            command = self._commands.get(timeout=wait)
        except Empty:
            return True
        if command["type"] == "close":
            return False
        before = self.state
        self._guard(lambda: getattr(self, f"_on_{command['type']}")(command))
        if command["type"] not in _FREQUENT or self.state != before:
            self._publish("state", self.state)
        if command["type"] not in _FREQUENT:
            self._metered = 0.0
            self._guard(self._read_meter)
        return True

    def _guard(self, work: Callable[[], None]) -> None:
        """Do work; a fault of bgc itself stops the run and is shown, but the thread goes on."""
        try:
            work()
        except Exception as problem:
            self.playing = False
            self._publish("fault", described_bug(problem, self._run.time))

    def _on_play(self, command: Mapping[str, Any]) -> None:
        if self.ended:
            self._pause_at = math.inf  # on beyond the end of the scene
        self.ended = False
        self.playing = self._ready

    def _on_pause(self, command: Mapping[str, Any]) -> None:
        self.playing = False
        self._actual = 0.0

    def _on_step(self, command: Mapping[str, Any]) -> None:
        self.playing = False
        self._actual = 0.0
        if self._ready:
            self._advance(min(self._every, self.speed * FRAME))

    def _on_speed(self, command: Mapping[str, Any]) -> None:
        self.speed = min(max(command["value"], SPEEDS[0]), SPEEDS[1])

    def _on_reset(self, command: Mapping[str, Any]) -> None:
        self.epoch += 1
        self._pause_at = self._duration
        self.ended = False
        self._actual = 0.0
        try:
            row = self._run.reset()
        except BgError as problem:
            self._ready = self.playing = False
            self._fail(problem.diagnostics)
            return
        self._ready = True
        self._emit(np.zeros(1), row[None])
        self._publish("values", self._run.values())

    def _on_set(self, command: Mapping[str, Any]) -> None:
        try:
            self._run.set_parameter(command["name"], command["value"])
        except BgError as problem:
            self._fail(problem.diagnostics, stopped=False)
        self._publish("values", self._run.values())

    def _on_hand(self, command: Mapping[str, Any]) -> None:
        if self._ready:
            self._steer(lambda: self._run.hand(command["device"], command))

    def _on_let_go(self, command: Mapping[str, Any]) -> None:
        """Centre the hand of a page that has gone while it held a device."""
        if self._ready and command["device"] in self._run.hands.held:
            self._on_hand({**command, "position": [0.0, 0.0, 0.0]})

    def _on_leave(self, command: Mapping[str, Any]) -> None:
        if self._ready:
            self._steer(lambda: self._run.leave(command["device"]))

    def _steer(self, work: Callable[[], None]) -> None:
        try:
            work()
        except BgError as problem:
            self._fail(problem.diagnostics, stopped=False)

    # --- graph and slots ------------------------------------------------------------------

    def _on_graph(self, command: Mapping[str, Any]) -> None:
        if self._graph is not None:
            self._publish("graph", self._graph)
        elif self._exchange is not None:
            self._exchange.graph(self._commands.put)

    def _on_watch(self, command: Mapping[str, Any]) -> None:
        self._is_watched = command["value"]

    def _on_use(self, command: Mapping[str, Any]) -> None:
        if self._exchange is not None:
            self._exchange.model(command["slot"], command["part"], self._commands.put)

    def _built(self, answer: Answer) -> bool:
        """Take the answer of a compilation beside the run; False where it failed."""
        assert self._exchange is not None
        self._exchange.busy = ""
        if answer.result is None:
            self._fail(answer.diagnostics or [aside_failed()], stopped=False)
        return answer.result is not None

    def _on_built_graph(self, command: Mapping[str, Any]) -> None:
        answer: Answer = command["answer"]
        if not self._built(answer):
            return
        meter = Meter(answer.result.built, self._run.model)
        if meter.source == text(self._run.model.library.model.hash):
            self._meter = meter
            self._graph = {**answer.result.description, "absent": meter.absent}
            self._publish("graph", self._graph)
        else:
            self._fail([file_changed()], stopped=False)

    def _on_built_model(self, command: Mapping[str, Any]) -> None:
        """Exchange the model: its run starts again, and plays if the one before did."""
        answer: Answer = command["answer"]
        if not self._built(answer):
            return
        assert self._exchange is not None
        try:
            found = self._exchange.take(answer.result, command["options"])
            found.run.given.update(carried(self._run.given, found.run.model))
            row = found.run.reset()
        except BgError as problem:
            self._fail(problem.diagnostics, stopped=False)
            return
        self._run.close()
        self._run, self._meter, self._graph = found.run, None, None
        self.epoch += 1
        self._pause_at, self._ratio = self._duration, math.inf
        self.ended, self._ready = False, True
        self._publish("scene", (found.description, found.meshes))
        self._emit(np.zeros(1), row[None])
        self._publish("values", self._run.values())

    def _read_meter(self) -> None:
        """Publish efforts and flows of the bonds where a page watches them."""
        now = monotonic()
        if self._meter is None or not self._is_watched or not self._ready:
            return
        if now - self._metered < METERING:
            return
        self._metered = now
        given = {**self._run.given, **self._run.varied}
        values = self._meter.read(*self._run.snapshot(), self._run.time, given)
        self._publish("powers", (self.epoch, as_rows(np.array([self._run.time]), values[None])))

    def _advance(self, step: float | None = None) -> None:
        """Compute the next frame: less simulated time where the model is slower than the clock."""
        if step is None:
            step = self.speed * FRAME
            if self._ratio * FRAME * _SHARE < step:
                step = min(step, self._ratio * _SLOWEST_FRAME)
        end = min(self._run.time + step, self._pause_at)
        count = min(_MOST_ROWS, max(1, math.ceil((end - self._run.time) / self._every - 1e-9)))
        times = np.linspace(self._run.time, end, count + 1)[1:]
        before, start = self._run.time, monotonic()
        rows, fault = self._run.advance(times)
        spent, gone = monotonic() - start, self._run.time - before
        if gone > 0:
            ratio = gone / max(spent, 1e-6)
            self._ratio = ratio if math.isinf(self._ratio) else 0.8 * self._ratio + 0.2 * ratio
        self._emit(times[: len(rows)], rows)
        if fault is not None:
            self.playing = False
            self._fail([fault])
        elif self._run.time >= self._pause_at:
            self.playing, self.ended = False, True
            self._publish("state", self.state)

    def _emit(self, times: Array, rows: Array) -> None:
        if len(rows):
            packed: tuple[int, Rows] = self.epoch, as_rows(times, rows)
            self._publish("rows", packed)

    def _fail(self, diagnostics: Sequence[Diagnostic], stopped: bool = True) -> None:
        self._publish("fault", described_fault(diagnostics, self._run.time, stopped))


def described_fault(
    diagnostics: Sequence[Diagnostic], time: float, stopped: bool
) -> dict[str, Any]:
    """Describe a failure for the page: its messages, each with the lines at fault."""
    return {
        "time": time,
        "stopped": stopped,
        "messages": [
            {"code": d.code, "text": d.message, "help": d.help or "", "excerpt": excerpt(d)}
            for d in diagnostics
        ],
    }


def described_bug(problem: Exception, time: float) -> dict[str, Any]:
    """Describe a fault of bgc itself for the page."""
    text = f"this is a bug in bgc: {type(problem).__name__}: {problem}"
    message = {"code": "", "text": text, "help": "", "excerpt": ""}
    return {"time": time, "stopped": True, "messages": [message]}


def usual_speed(duration: float | None) -> float:
    """The speed at which a scene is shown first: real time if it lasts 2 s to 10 min.

    Others take some 10 s of the clock, at a speed of 1, 2 or 5 times a power of ten.
    """
    if duration is None or 2 <= duration <= 600:
        return 1.0
    wanted = min(max(duration / 10, SPEEDS[0]), SPEEDS[1])
    decade = 10.0 ** math.floor(math.log10(wanted))
    return max((m * decade for m in (1, 2, 5) if m * decade <= wanted * 1.0001), default=decade)
