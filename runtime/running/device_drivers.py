"""Open the devices of a scene: drivers by name or by the path of a shared object."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import MappingProxyType

from bgc.building.build import driver_names
from bgc.diagnostics.catalogue.arguments import device_not_opened, unknown_driver
from bgc.diagnostics.catalogue.devices import (
    bad_device_option,
    driver_not_allowed,
    driver_not_loaded,
    no_such_device,
)
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.running.allowed_folders import ALLOWED, is_allowed
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.failures import quotable
from bgc.runtime.running.quantity import read_number
from bgc.runtime.running.run import interruptible
from bgc.runtime.running.structures import Status

BY_PATH = "driver"
"""The name by which a scene opens a driver of a shared object: `driver("./mine.so")`."""
_ABI = 2  # BGC_DEVICE_ABI of bgc_device.h
_LINE_BREAK = "the scene's folder has a line break in its name, which ends an option"
_CHOICE = re.compile(r"(?P<what>[^()]+?)\s*(?:\((?P<options>.*)\))?", re.DOTALL)


@dataclass(frozen=True, slots=True)
class DeviceChoice:
    """A driver by its name, or by the path of a shared object, and `key=value` lines for it."""

    driver: str
    options: str = ""
    path: Path | None = None


@dataclass(frozen=True, slots=True)
class FoundDriver:
    """A device of the scene with the driver that it is to have.

    `address` is that of the `bgc_driver`; `library` keeps the shared object that holds it.
    """

    name: str
    driver: str
    address: int
    options: str
    library: ctypes.CDLL | None = None


Choices = Mapping[str, DeviceChoice]
NO_CHOICES: Choices = MappingProxyType({})


def read_choice(given: str) -> tuple[str, DeviceChoice]:
    """Read `hand=NAME(key=value, ..)`, `hand=./mine.so(..)` or `hand=motion.csv`.

    Paths start at the working directory. A table (`.csv`) is played by `trace`.

    Raises BgError: BG013 where it has another form.
    """
    name, equals, rest = given.partition("=")
    found = _CHOICE.fullmatch(rest.strip())
    if not (name.strip() and equals and found):
        raise BgError([bad_device_option(given)])
    what = found["what"].strip()
    lines = [_option(given, part) for part in (found["options"] or "").split(",") if part.strip()]
    if what.lower().endswith(".csv"):
        lines.insert(0, f"file={Path(what).absolute()}\n")
        what = "trace"
    path = Path(what).absolute() if "/" in what or what.endswith(".so") else None
    return name.strip(), DeviceChoice(what, "".join(lines), path)


def read_choices(given: Mapping[str, str]) -> dict[str, DeviceChoice]:
    """Read drivers by the names of their devices, in the form of `read_choice`."""
    return dict(read_choice(f"{name}={driver}") for name, driver in given.items())


def _option(given: str, part: str) -> str:
    """One option as a line; a number with a unit becomes SI."""
    key, equals, value = (piece.strip() for piece in part.partition("="))
    if not (key and equals and value):
        raise BgError([bad_device_option(given)])
    value = value.strip("\"'")
    if key == "file":
        return f"{key}={Path(value).absolute()}\n"
    number = read_number(value) if " " in value else None
    return f"{key}={value if number is None else repr(number)}\n"


def find_drivers(instance: Instance, folder: Path, choices: Choices) -> list[FoundDriver]:
    """Find the driver of each device of the scene; `choices` override those of the scene.

    `folder` is that of the scene's file: paths of its device files are relative to it.

    Raises BgError: BG012 for a shared object without a driver, BG014 for a choice without its
    device, BG015 for a shared object that a scene may not load, BG073 for an unknown driver.
    """
    model = instance.library.model
    names = [text(model.device[index].name) for index in range(model.n_device)]
    if unknown := [name for name in choices if name not in names]:
        raise BgError([no_such_device(unknown[0], names)])
    return [
        _find_driver(instance, name, choices.get(name) or _of_scene(instance, index, folder))
        for index, name in enumerate(names)
    ]


def _of_scene(instance: Instance, index: int, folder: Path) -> DeviceChoice:
    """The driver that the scene names."""
    info = instance.library.model.device[index]
    driver, given = text(info.driver), text(info.options)
    located = _located(given, folder)
    if located is None:
        raise BgError([device_not_opened(text(info.name), driver, _LINE_BREAK)])
    if driver != BY_PATH:
        return DeviceChoice(driver, located)
    lines = located.splitlines(keepends=True)
    file = next(line for line in lines if line.startswith("file="))
    path = Path(file.rstrip("\n").partition("=")[2])
    if not is_allowed(path):
        raise BgError([driver_not_allowed(text(info.name), str(path), ALLOWED)])
    return DeviceChoice(driver, "".join(line for line in lines if line is not file), path)


def _find_driver(instance: Instance, name: str, choice: DeviceChoice) -> FoundDriver:
    if choice.path is not None:
        library, address = load_driver(choice.path)
        return FoundDriver(name, str(choice.path), address, choice.options, library)
    address = instance.find_driver(choice.driver.encode()) or 0
    if not address:
        known = [each for each in driver_names() if instance.find_driver(each.encode()) is not None]
        raise BgError([unknown_driver(name, choice.driver, known)])
    return FoundDriver(name, choice.driver, address, choice.options)


def load_driver(path: Path) -> tuple[ctypes.CDLL, int]:
    """Load a shared object with a driver; return it with the address of its `bgc_driver`.

    Raises BgError BG012 where it cannot be loaded, has no driver, or one of another version.
    """
    try:
        library = ctypes.CDLL(str(path))
        function = library.bgc_device_driver
    except (OSError, AttributeError) as problem:
        no_file = not path.is_file()
        absent = "there is no such file" if no_file else quotable(str(problem))
        lacks = "it exports no function `bgc_device_driver`"
        reason = lacks if isinstance(problem, AttributeError) else absent
        raise BgError([driver_not_loaded(str(path), reason)]) from problem
    function.restype = ctypes.c_void_p
    address = function()
    if not address:
        raise BgError([driver_not_loaded(str(path), "its `bgc_device_driver` returns NULL")])
    version = ctypes.c_uint32.from_address(address).value
    if version != _ABI:
        reason = f"it was compiled for version {version} of bgc_device.h, this bgc has {_ABI}"
        raise BgError([driver_not_loaded(str(path), reason)])
    return library, address


@contextmanager
def open_devices(instance: Instance, folder: Path, choices: Choices = NO_CHOICES) -> Iterator[None]:
    """Open the scene's devices; on exit set their forces to zero and close them, also after errors.

    `folder` is that of the scene's file: paths of device files are relative to it. `choices`
    override drivers of the scene.
    """
    found = find_drivers(instance, folder, choices)
    try:
        for index, device in enumerate(found):
            work = partial(instance.open_device, index, device.address, device.options)
            status, message = interruptible(work)
            if status is not Status.OK:
                raise BgError([device_not_opened(device.name, device.driver, quotable(message))])
        yield
    finally:
        instance.close_devices()


def _located(options: str, folder: Path) -> str | None:
    """Make the path of a device's file relative to the scene's folder.

    None where that folder has a line break, which would end the option.
    """
    # Drivers end an option at "\n" alone, so `splitlines` would find more options than they do.
    lines = [line.partition("=") for line in options.split("\n") if line]
    located = [(key, str(folder / value) if key == "file" else value) for key, _, value in lines]
    if any("\n" in value for _, value in located):
        return None
    return "".join(f"{key}={value}\n" for key, value in located)
