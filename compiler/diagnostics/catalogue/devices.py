"""BG012-BG019: drivers of devices, as the command line and scenes name them."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def driver_not_loaded(path: str, reason: str) -> Diagnostic:
    """BG012: a shared object without a usable driver"""
    return error(
        "BG012",
        f"`{path}` cannot be used as a driver: {reason}",
        help="compile it with the `bgc_device.h` of this bgc; `bgc devices --example DIR` writes "
        "a driver with its Makefile",
    )


def bad_device_option(given: str) -> Diagnostic:
    """BG013: a `--device` that cannot be read"""
    return error(
        "BG013",
        f"`{given}` does not choose a device",
        help='write `--device hand=./mine.so`, `--device "hand=udp(port=5005)"` or '
        "`--device hand=motion.csv`",
    )


def no_such_device(name: str, have: Sequence[str]) -> Diagnostic:
    """BG014: a `--device` that the scene does not have"""
    return error(
        "BG014",
        f"the scene has no device `{name}`",
        help=did_you_mean(name, have)
        or (f"its devices are {listed(have)}" if have else "a `device` statement declares one"),
    )


def driver_not_allowed(device: str, path: str, variable: str) -> Diagnostic:
    """BG015: a shared object that a scene may not load"""
    return error(
        "BG015",
        f"device `{device}` would load machine code from `{path}`",
        help=f"if you trust that file, list its folder in {variable}, or give "
        f"`--device {device}={path}`",
    )


def no_driver_path(span: Span) -> Diagnostic:
    """BG016: a driver without the path of its shared object"""
    return error(
        "BG016",
        "`driver` needs the path of a shared object",
        span,
        help='write `driver("./mine.so", key = value)`',
    )
