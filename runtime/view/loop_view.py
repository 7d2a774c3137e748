"""The page of a loop in real time: what it shows, and what its pages hand to the loop.

The loop never waits for a page: rows come from the records that Python takes beside it, and poses
go to its pointers without waiting.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from threading import Thread
from typing import Any, Final

import numpy as np

from bgc.runtime.realtime.course import Course
from bgc.runtime.realtime.loop import Realtime
from bgc.runtime.realtime.loop_records import rows_of
from bgc.runtime.realtime.loop_report import Report
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.device_drivers import NO_CHOICES, Choices
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.poses import FED
from bgc.runtime.view.hands import pose_in
from bgc.runtime.view.history import as_rows
from bgc.runtime.view.part_exchange import Exchange, carried
from bgc.runtime.view.scene_description import Description, describe_model, meshes_of
from bgc.runtime.view.steered import Publish, Steered

_REPORTING: Final = 0.5  # s of simulated time between two states of the loop
_QUEUED: Final = ("set", "reset", "graph", "use")  # commands that take their time
_CENTRED: Final = {"position": [0.0, 0.0, 0.0]}


class LoopFollower(Steered[LoadedModel]):
    """A loop as pages see it: rows about 100 times a second, its state, and its commands.

    It publishes the events of a `Player`. Poses go to devices with the drivers `pointer` and
    `gamepad` alone: those of a real hand stay with it. A parameter that is set holds from the next
    reset, which exchanges the model for itself: the force falls, the model starts again, and the
    force rises. So does another part in a slot, which is compiled in a process of its own.
    """

    def __init__(self, name: str, choices: Choices = NO_CHOICES, **arguments: Any) -> None:
        """Prepare the page of a file `name`; `arguments` are those of `Realtime.exchange`."""
        super().__init__(lambda kind, content: None, None)
        self._name, self._choices, self._arguments = name, choices, arguments
        self._loop: Realtime | None = None
        self._course: Course | None = None
        self._report: Report | None = None
        self._reported = 0.0
        self._set: dict[str, float] = {}
        self._held: set[str] = set()
        self._thread = Thread(target=self._obey_all, daemon=True, name="bgc haptic: page")

    def describe(self, model: LoadedModel) -> tuple[Description, list[Path]]:
        """Describe a model that was compiled with shapes, and find its meshes."""
        description = describe_model(model, self._name, self._choices)
        for device in description["devices"]:
            device["free"] = device["driver"] in FED
        return {**description, "realtime": True}, meshes_of(description, model.folder)

    def follow(self, loop: Realtime, publish: Publish) -> None:
        """Publish what a loop does, which has `take` as its `on_records` and has not started."""
        self._loop, self._publish = loop, publish
        self._begin(loop.course)
        self._thread.start()

    def end(self, report: Report) -> None:
        """Publish how the loop has ended."""
        self._commands.put({"type": "close"})
        if self._exchange is not None:
            self._exchange.close()
        self._report = report
        if report.problem is not None:
            self._reported = report.time
            self._fail([report.problem])
        self._publish("state", self.state)

    # --- what the loop gives, in the thread that takes its records ----------------------------

    def take(self, records: Array) -> None:
        """Publish the last of new records, and now and then the state of the loop."""
        self._guard(lambda: self._take(records))

    def _take(self, records: Array) -> None:
        loop = self._loop
        assert loop is not None
        if loop.course is not self._course:
            self._begin(loop.course)
        time = float(records[-1, 0])
        rows = rows_of(records[-1:], len(loop.devices))
        self._publish("rows", (self.epoch, as_rows(np.array([time]), rows)))
        if self._report is None or not 0.0 <= time - self._reported < _REPORTING:
            self._reported, self._report = time, loop.report
            self._publish("state", self.state)

    def _begin(self, course: Course) -> None:
        """Go on with another course of the loop."""
        before, self._course, model = self._course, course, course.model
        if before is not None:
            self.epoch += 1
            self._set = carried(self._set, model)
            if before.model is not model:
                self._publish("scene", self.describe(model))
        if (before is None or before.model is not model) and model.origin is not None:
            if self._exchange is not None:
                self._exchange.close()
            self._exchange, self._graph = Exchange(*model.origin, lambda taken: taken), None
        self._publish("values", model.parameters.values_in(course.instance))

    @property
    def state(self) -> dict[str, Any]:
        """The state of the loop, as that of a player; `loop` has its report."""
        report = self._report
        runs = report is not None and report.is_running
        return {
            "playing": runs,
            "speed": 1.0,
            "actual": 0.0,
            "ended": report is not None and not runs,
            "epoch": self.epoch,
            "ready": True,
            "held": sorted(self._held),
            "busy": self._busy,
            "loop": None if report is None else _loop_state(report),
        }

    # --- what the pages give ------------------------------------------------------------------

    def command(self, command: Mapping[str, Any]) -> None:
        """Hand a pose on at once; queue what takes longer. Others mean nothing to a loop."""
        kind = command["type"]
        if kind == "hand":
            self._guard(lambda: self._hand(command))
        elif kind in ("leave", "let_go"):
            self._guard(lambda: self._let_go(command["device"]))
        elif kind in _QUEUED:
            self._commands.put(command)

    def _hand(self, command: Mapping[str, Any]) -> None:
        assert self._loop is not None
        self._loop.pointer(**pose_in(command), device=command["device"])
        if command["device"] not in self._held:
            self._held.add(command["device"])
            self._publish("state", self.state)

    def _let_go(self, device: str) -> None:
        """Centre a device that no page holds any more."""
        if device in self._held:
            self._hand({**_CENTRED, "device": device})
            self._held.discard(device)
            self._publish("state", self.state)

    def _obey_all(self) -> None:
        while (command := self._commands.get())["type"] != "close":
            self._obey(command)
            self._publish("state", self.state)

    def _on_set(self, command: Mapping[str, Any]) -> None:
        parameters = self._present.model.parameters
        try:
            self._set.update(parameters.checked(command["name"], command["value"]))
        finally:  # the page takes back what was refused
            instance = parameters.instance(self._given())
            self._publish("values", parameters.values_in(instance))

    def _on_reset(self, command: Mapping[str, Any]) -> None:
        self._begin_with(self._present.model)

    def _begin_with(self, model: LoadedModel) -> None:
        assert self._loop is not None
        given = carried(self._given(), model)
        self._loop.exchange(model, parameters=given, wait=False, **self._arguments)

    @property
    def _present(self) -> Course:
        assert self._course is not None
        return self._course

    def _given(self) -> dict[str, float]:
        """The parameters that the present course was given, and those set since, SI."""
        return {**self._present.model.parameters.given(self._present.given), **self._set}

    def _now(self) -> float:
        return self._reported

    # --- slots --------------------------------------------------------------------------------

    def _on_built_graph(self, command: Mapping[str, Any]) -> None:
        self._graph = {**self._built(command["answer"]).description, "absent": []}
        self._publish("graph", self._graph)

    def _on_built_model(self, command: Mapping[str, Any]) -> None:
        self._begin_with(self._exchanged(command))


def _loop_state(report: Report) -> dict[str, Any]:
    """The state of a loop for its page: a short label, and the lines of its report."""
    if not report.is_running:
        words = "the loop has ended"
    elif report.released:
        words = "real time, button free"
    else:
        force = round(100 * report.gain)
        words = "real time" if force == 100 else f"real time, force {force} %"
    return {"words": words, "lines": list(report.lines())}
