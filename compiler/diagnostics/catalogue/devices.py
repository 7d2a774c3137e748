"""Diagnostics: device drivers."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, listed, nearest
from bgc.diagnostics.source import Span


@error(
    "BG012: `{path}` cannot be used as a driver: {reason}",
    "compile it with the `bgc_device.h` of this bgc; `bgc devices --example DIR` writes "
    "a driver with its Makefile",
)
def driver_not_loaded(path: str, reason: str) -> None: ...
@error(
    "BG013: `{given}` does not choose a device",
    'write `--device hand=./mine.so`, `--device "hand=udp(port=5005)"` or `--device '
    "hand=motion.csv`",
)
def bad_device_option(given: str) -> None: ...
@error("BG014: the scene has no device `{name}`", "{there}")
def no_such_device(name: str, have: Sequence[str]) -> Values:
    there = f"its devices are {listed(have)}" if have else "a `device` statement declares one"
    return {"there": there, **nearest(name, have)}


@error(
    "BG015: device `{device}` would load machine code from `{path}`",
    "if you trust that file, list its folder in {variable}, or give `--device {device}={path}`",
)
def driver_not_allowed(device: str, path: str, variable: str) -> None: ...
@error(
    "BG016: `driver` needs the path of a shared object", 'write `driver("./mine.so", key = value)`'
)
def no_driver_path(span: Span) -> None: ...
