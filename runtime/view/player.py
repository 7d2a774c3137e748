"""The thread that advances a live run in pace with the clock."""

from __future__ import annotations

import math
from collections.abc import Mapping
from queue import Empty
from threading import Thread
from time import monotonic
from typing import Any, Final

import numpy as np

from bgc.diagnostics.catalogue.view import file_changed
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import text
from bgc.runtime.view.history import Rows, as_rows
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.meter import Meter
from bgc.runtime.view.part_exchange import Exchange, Prepared, carried
from bgc.runtime.view.steered import Publish, Steered

FRAME: Final = 1 / 60  # s of the clock between two frames
SPEEDS: Final = (1e-6, 100.0)  # simulated seconds for each second of the clock
METERING: Final = 1 / 15  # s of the clock between two readings of the bonds
_MOST_ROWS: Final = 16  # in a frame
_LATE: Final = 0.1  # s behind the clock after which the lost time is given up
_SHARE: Final = 0.8  # of a frame that computing may take before the chunks become shorter
_FREQUENT: Final = ("hand",)  # commands that come each frame; others are answered by the state
_SLOWEST_FRAME: Final = 1 / 15  # s of computing in a frame of a run that cannot keep up


class Player(Steered[Prepared]):
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
        super().__init__(publish, exchange)
        self._run = run
        self._thread = Thread(target=self._loop, daemon=True, name="bgc view")
        self._duration = duration or math.inf
        self._every = every or math.inf
        self.speed = usual_speed(duration)
        self.playing = False
        self.ended = False
        self._meter: Meter | None = None
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
            "busy": self._busy,
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
                if not self._take(None):
                    break
                due = monotonic()
                measured = due, self._run.time
                continue
            if not self._take(max(0.0, due - monotonic())):
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

    def _take(self, wait: float | None) -> bool:
        """Wait for a command, and obey it; False for that to close."""
        try:
            command = self._commands.get(timeout=wait)
        except Empty:
            return True
        if command["type"] == "close":
            return False
        before = self.state
        self._obey(command)
        if command["type"] not in _FREQUENT or self.state != before:
            self._publish("state", self.state)
        if command["type"] not in _FREQUENT:
            self._metered = 0.0
            self._guard(self._read_meter)
        return True

    def _now(self) -> float:
        return self._run.time

    def _halt(self) -> bool:
        self.playing = False
        return True

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
        finally:  # the page takes back what was refused
            self._publish("values", self._run.values())

    def _on_hand(self, command: Mapping[str, Any]) -> None:
        if self._ready:
            self._run.hand(command["device"], command)

    def _on_let_go(self, command: Mapping[str, Any]) -> None:
        """Centre the hand of a page that has gone while it held a device."""
        if self._ready and command["device"] in self._run.hands.held:
            self._on_hand({**command, "position": [0.0, 0.0, 0.0]})

    def _on_leave(self, command: Mapping[str, Any]) -> None:
        if self._ready:
            self._run.leave(command["device"])

    # --- graph and slots ------------------------------------------------------------------

    def _on_watch(self, command: Mapping[str, Any]) -> None:
        self._is_watched = command["value"]

    def _on_built_graph(self, command: Mapping[str, Any]) -> None:
        found = self._built(command["answer"])
        meter = Meter(found.built, self._run.model)
        if meter.source != text(self._run.model.library.model.hash):
            raise BgError([file_changed()])
        self._meter = meter
        self._graph = {**found.description, "absent": meter.absent}
        self._publish("graph", self._graph)

    def _on_built_model(self, command: Mapping[str, Any]) -> None:
        """Exchange the model: its run starts again, and plays if the one before did."""
        found = self._exchanged(command)
        found.run.given.update(carried(self._run.given, found.run.model))
        row = found.run.reset()
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


def usual_speed(duration: float | None) -> float:
    """The speed at which a scene is shown first: real time if it lasts 2 s to 10 min.

    Others take some 10 s of the clock, at a speed of 1, 2 or 5 times a power of ten.
    """
    if duration is None or 2 <= duration <= 600:
        return 1.0
    wanted = min(max(duration / 10, SPEEDS[0]), SPEEDS[1])
    decade = 10.0 ** math.floor(math.log10(wanted))
    return max((m * decade for m in (1, 2, 5) if m * decade <= wanted * 1.0001), default=decade)
