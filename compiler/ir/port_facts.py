"""Facts about the sampled ports, devices and FMUs of a compiled model, in plain values."""

from __future__ import annotations

from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class PortFacts:
    """A sampled port: the inputs of C that hold its effort, and the states that it moves.

    Both are empty where slicing removed the bond, since nothing reads it.
    """

    name: str
    efforts: tuple[int, ...] = ()
    moved: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class ForceFacts:
    """The force on a device: what makes it from the position of that device.

    `ports` are the sampled ports and `observers` the paths of the observers that read the position
    of the device and act on it. `whole` is true where nothing else does: the force depends on no
    other state or pose. `periods` are those of the sampled parts between position and force: the
    name of a parameter, or a number in s.
    """

    device: str
    ports: tuple[str, ...] = ()
    observers: tuple[str, ...] = ()
    whole: bool = False
    periods: tuple[str | float, ...] = ()


@dataclass(frozen=True, slots=True)
class FmuFacts:
    """An FMU of another tool: its file, and what a run needs to open it.

    `file` is its name in messages, `path` where it lay, `digest` a hash of its content, `version`
    that of FMI, `identifier` the name of its binaries. `once` tells that a process may hold one
    instance.
    """

    name: str
    file: str
    path: str
    digest: str
    version: int
    identifier: str
    once: bool
