"""Find the drivers and haptic devices of a machine, and the reasons why one cannot be opened."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path

from bgc.building.build import driver_names
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.running.allowed_folders import ALLOWED
from bgc.runtime.running.device_drivers import load_driver

PURPOSES = {
    "trace": "plays a recorded motion: trace(file = motion.csv)",
    "udp": "a device on another machine or in another program, by datagrams",
    "pointer": "the mouse on the page of `bgc view`, or Python: realtime.pointer(position=..)",
    "gamepad": "a gamepad at the browser that shows the page of `bgc view`",
    "spring_hand": "a simulated hand that holds the handle: mass, damping, intention",
    "haply": "Inverse3 and Minverse through the maker's Inverse Service",
    "forcedimension": "omega, sigma, lambda, delta and Falcon through the maker's SDK",
}
"""A line on each driver of the runtime."""

_INVERSE_PORT = 10001
_USB = Path("sys/bus/usb/devices")
_NODES = Path("dev/bus/usb")
_RULES = (Path("etc/udev/rules.d"), Path("lib/udev/rules.d"), Path("usr/lib/udev/rules.d"))


@dataclass(frozen=True, slots=True)
class Hardware:
    """Devices of one maker: USB vendor ids, the library that opens them, and where it may lie.

    `variable` is the environment variable with the folder of the SDK.
    """

    driver: str
    maker: str
    vendors: tuple[str, ...]
    library: str
    variable: str
    source: str


HARDWARE = (
    Hardware(
        "forcedimension",
        "Force Dimension",
        ("1451",),
        "libdrd.so",
        "FDSDK",
        "the Force Dimension SDK, https://www.forcedimension.com/software/sdk",
    ),
)
_SUBFOLDERS = ("", "lib", "lib/release/lin-x86_64-gcc", "lib/release/lin-*")
_FOLDERS = ("~/.local/lib", "/usr/local/lib", "/usr/lib", "/usr/lib/*-linux-gnu")


@dataclass(frozen=True, slots=True)
class Finding:
    """A driver or a device: whether it can be used, what was found, and the way out if not."""

    name: str
    usable: bool
    text: str
    remedy: str = ""


def find_all(root: Path = Path("/")) -> list[Finding]:
    """Examine the drivers of the runtime, those in the user's folders, and USB devices.

    `root` is the root of the file system.
    """
    hardware = {item.driver: item for item in HARDWARE}
    found = []
    for name in driver_names():
        if name in hardware:
            found += list(_examine(hardware[name], root))
        elif name == "haply":
            found.append(_examine_service())
        else:
            found.append(Finding(name, True, PURPOSES.get(name, "a driver of the runtime")))
    return [*found, *_own_drivers()]


def find_library(item: Hardware, root: Path = Path("/")) -> Path | None:
    """Find the maker's library: in the SDK's folder, else where libraries lie; newest first."""
    given = os.environ.get(item.variable)
    inside = [f"{given}/{sub}" for sub in _SUBFOLDERS] if given else []
    for folder in (*inside, *_FOLDERS):
        path = Path(folder).expanduser()
        base = path if inside and folder in inside else root / path.relative_to("/")
        for place in _expanded(base):
            if matches := sorted(place.glob(f"{item.library}*"), reverse=True):
                return matches[0]
    return None


def _expanded(folder: Path) -> list[Path]:
    """The folders that a path with a pattern names."""
    if "*" not in str(folder):
        return [folder]
    return sorted(Path(folder.anchor).glob(str(folder.relative_to(folder.anchor))))


def _examine(item: Hardware, root: Path) -> Iterator[Finding]:
    library = find_library(item, root)
    if library is None:
        places = f"${item.variable}, ~/.local/lib and /usr/local/lib"
        remedy = f"install {item.source}, and set {item.variable} to its folder"
        yield Finding(item.driver, False, f"{item.library} is not in {places}", remedy)
    else:
        yield Finding(item.driver, True, f"{PURPOSES[item.driver]} ({library})")
    connected = list(_connected(item, root))
    for port in connected:
        yield _examine_port(item, port, root)
    if not connected:
        ids = " or ".join(f"{vendor}:*" for vendor in item.vendors)
        text = f"no device with the USB id {ids} is connected"
        yield Finding(f"  {item.maker}", False, text, "connect it and switch it on")


def _examine_service() -> Finding:
    """Say whether Haply's Inverse Service runs on this machine."""
    try:
        with socket.create_connection(("127.0.0.1", _INVERSE_PORT), timeout=0.2):
            return Finding("haply", True, PURPOSES["haply"])
    except OSError:
        text = f"no Inverse Service answers at port {_INVERSE_PORT} of this machine"
        remedy = "start the Haply Hub or the Inverse Service, https://docs.haply.co/inverseSDK"
        return Finding("haply", False, text, remedy)


def _connected(item: Hardware, root: Path) -> Iterator[Path]:
    """The USB ports with a device of the maker."""
    for vendor in sorted((root / _USB).glob("*/idVendor")):
        if _content(vendor) in item.vendors:
            yield vendor.parent


def _examine_port(item: Hardware, port: Path, root: Path) -> Finding:
    """Say whether the user may open a connected device."""
    product = _content(port / "product") or "a device"
    name = f"  {item.maker}"
    usb = f"{_content(port / 'idVendor')}:{_content(port / 'idProduct')}"
    numbers = [_content(port / part).zfill(3) for part in ("busnum", "devnum")]
    node = root / _NODES / "/".join(numbers)
    if os.access(node, os.R_OK | os.W_OK):
        return Finding(name, True, f"{product} (USB {usb}, {node})")
    rule = f'SUBSYSTEM=="usb", ATTR{{idVendor}}=="{item.vendors[0]}", MODE="0666", TAG+="uaccess"'
    if _has_rule(item, root):
        text = f"{product} (USB {usb}) has a udev rule, but {node} is not writable"
        return Finding(name, False, text, "unplug it and plug it in again, or log in again")
    text = f"{product} (USB {usb}) has no udev rule, so {node} is not writable"
    return Finding(name, False, text, f"write to /etc/udev/rules.d/80-haptic.rules: {rule}")


def _has_rule(item: Hardware, root: Path) -> bool:
    files = [path for folder in _RULES for path in (root / folder).glob("*.rules")]
    return any(vendor in _content(path) for path in files for vendor in item.vendors)


def _content(path: Path) -> str:
    try:
        return path.read_text("utf-8", "replace").strip()
    except OSError:
        return ""


def _own_drivers() -> Iterator[Finding]:
    """Drivers in the folders from which scenes may load them."""
    for folder in filter(None, os.environ.get(ALLOWED, "").split(os.pathsep)):
        if not Path(folder).is_dir():
            yield Finding(folder, False, f"{ALLOWED} lists it, but there is no such folder")
        for path in sorted(Path(folder).glob("*.so")):
            try:
                load_driver(path)
            except BgError as problem:
                (diagnostic,) = problem.diagnostics
                yield Finding(str(path), False, diagnostic.message, diagnostic.help)
            else:
                yield Finding(str(path), True, "a driver of your own")
