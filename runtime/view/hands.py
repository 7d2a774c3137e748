"""Devices of a live run that the page takes in its hand, and gives back to the scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from bgc.diagnostics.catalogue.arguments import device_not_opened
from bgc.diagnostics.catalogue.view import device_not_steered
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.device_drivers import (
    NO_CHOICES,
    Choices,
    DeviceChoice,
    FoundDriver,
    find_drivers,
)
from bgc.runtime.running.failures import quotable
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.poses import FED, pose_words
from bgc.runtime.running.structures import Status

REACH: Final = 0.06
"""The displacement at the end of a stick where the driver has no option `reach`, m."""
_TAKEN: Final = (*FED, "trace", "spring_hand")
"""Drivers that the page may replace: those without hardware."""
_CHANNELS: Final = {  # those that models read, as bgc_channel of bgc.h
    0: "position",
    1: "orientation",
    2: "velocity",
    3: "angular_velocity",
    4: "gripper",
    5: "buttons",
    9: "held_force",
    10: "age",
}
_POSITION: Final = 0  # BGC_POSITION


class Hands:
    """The devices of a run: which the page holds, and the drivers that they have otherwise."""

    def __init__(self, model: LoadedModel, choices: Choices = NO_CHOICES) -> None:
        self._model, self._choices = model, choices
        self._held: set[str] = set()
        self.names = device_names(model)

    @property
    def held(self) -> list[str]:
        """Names of the devices whose pose the page gives."""
        return sorted(self._held)

    def forget(self) -> None:
        """Forget what the page holds: the devices have been opened again."""
        self._held.clear()

    def feed(self, instance: Instance, name: str, pose: Mapping[str, Any]) -> None:
        """Hand a pose to a device, which gets the driver `pointer` unless it has it.

        Raises BgError BG756 where the scene has no such device, or one of a real hand.
        """
        if name not in self._held:
            self._take(instance, name)
        instance.feed_pointer(self.names.index(name), pose_words(**pose_in(pose)))

    def leave(self, instance: Instance, name: str) -> None:
        """Open the scene's own driver again. Raises BgError where that fails."""
        if name in self._held:
            self._held.discard(name)
            self._open(instance, self._found(instance, self._choices)[name])

    def _take(self, instance: Instance, name: str) -> None:
        if name not in self.names:
            raise BgError([device_not_steered(name, "", self.names)])
        found = self._found(instance, self._choices)[name]
        if found.driver not in _TAKEN:
            raise BgError([device_not_steered(name, found.driver, self.names)])
        if found.driver not in FED:
            fed = {**self._choices, name: DeviceChoice(FED[0])}
            self._open(instance, self._found(instance, fed)[name])
        self._held.add(name)

    def _found(self, instance: Instance, choices: Choices) -> dict[str, FoundDriver]:
        return {d.name: d for d in find_drivers(instance, self._model.folder, choices)}

    def _open(self, instance: Instance, device: FoundDriver) -> None:
        index = self.names.index(device.name)
        status, message = instance.open_device(index, device.address, device.options)
        if status is not Status.OK:
            reason = quotable(message)
            raise BgError([device_not_opened(device.name, device.driver, reason)])


def pose_in(message: Mapping[str, Any]) -> dict[str, Any]:
    """The pose in a message of a page, as the arguments of `pose_words` and of a loop's pointer."""
    turned = np.asarray(message.get("orientation", (1.0, 0.0, 0.0, 0.0)), dtype=float)
    return {
        "position": message["position"],
        "orientation": turned / np.linalg.norm(turned),
        "gripper": message.get("gripper", 0.0),
        "buttons": message.get("buttons", ()),
    }


def device_names(model: LoadedModel) -> list[str]:
    """Names of the devices of a model, in its order."""
    table = model.library.model
    return [text(table.device[k].name) for k in range(table.n_device)]


def describe_devices(model: LoadedModel, choices: Choices = NO_CHOICES) -> list[dict[str, Any]]:
    """Describe the devices for the page.

    Each has its name, its driver, whether the page may take it (`free`), its reach, m, and the
    channels that the model reads.
    """
    table = model.library.model
    described = []
    for index, name in enumerate(device_names(model)):
        info = table.device[index]
        choice = choices.get(name) or DeviceChoice(text(info.driver), text(info.options))
        uses = [table.input[k] for k in range(table.n_input)]
        channels = sorted({use.channel for use in uses if use.device == index})
        described.append(
            {
                "name": name,
                "driver": choice.driver,
                "free": choice.driver in _TAKEN,
                "reach": _reach(choice.options),
                "reads": [_CHANNELS[channel] for channel in channels],
            }
        )
    return described


def _reach(options: str) -> float:
    for line in options.splitlines():
        key, _, value = line.partition("=")
        if key == "reach":
            return float(value)
    return REACH


def handle_devices(
    model: LoadedModel, columns: Mapping[str, list[int]]
) -> dict[str, tuple[str, list[int]]]:
    """Find the device that moves each handle, and the axes of its position that do (from 0).

    `columns` are the places in a row of the position of each handle. One position at a time is
    varied. A handle that reads several devices belongs to the first.
    """
    if not columns:
        return {}
    table = model.library.model
    instance = model.parameters.instance({})
    instance.reset(0.0, checked=False)
    at_rest = instance.outputs()[1]
    found: dict[str, tuple[str, list[int]]] = {}
    for k in range(table.n_input):
        use = table.input[k]
        if use.device < 0 or use.channel != _POSITION:
            continue
        before = instance.input[k]
        instance.input[k] = before + 0.01
        moved = instance.outputs()[1]
        instance.input[k] = before
        for handle, places in columns.items():
            name = text(table.device[use.device].name)
            differs = np.any(at_rest[places] != moved[places])
            if differs and np.isfinite(moved[places]).all():
                device, axes = found.setdefault(handle, (name, []))
                if device == name:
                    axes.append(use.component)
    return found
