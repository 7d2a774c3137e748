"""BG012-BG019: drivers of devices, as the command line and scenes name them."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def driver_not_loaded(path: str, reason: str) -> Diagnostic:
    """BG012: a shared object without a usable driver

    What: the file that a device names could not be loaded as a driver.

    Why: it does not exist, was compiled for another machine, lacks a library, does not export
    `bgc_device_driver`, or was compiled with another version of `bgc_device.h`.

    Example: `--device hand=./mine.so` before `make`.

    Way out: compile it again with the `bgc_device.h` of this bgc (`bgc devices --example DIR`
    writes a driver with its Makefile).
    """
    return error(
        "BG012",
        f"`{path}` cannot be used as a driver: {reason}",
        help="compile it with the `bgc_device.h` of this bgc; `bgc devices --example DIR` writes "
        "a driver with its Makefile",
    )


def bad_device_option(given: str) -> Diagnostic:
    """BG013: a `--device` that cannot be read

    What: the choice of a device has no name, no driver, or an option without a value.

    Why: the form is `NAME=DRIVER(key=value, ..)`.

    Example: `--device trace`.

    Way out: `--device hand=./mine.so`, `--device "hand=udp(port=5005)"` or
    `--device hand=motion.csv`.
    """
    return error(
        "BG013",
        f"`{given}` does not choose a device",
        help='write `--device hand=./mine.so`, `--device "hand=udp(port=5005)"` or '
        "`--device hand=motion.csv`",
    )


def no_such_device(name: str, have: Sequence[str]) -> Diagnostic:
    """BG014: a `--device` that the scene does not have

    What: a driver was chosen for a device that the scene does not declare.

    Why: the name is misspelt, or the scene has no device at all.

    Example: `--device hnad=motion.csv`.

    Way out: name one of the scene's devices; `device hand = trace(..);` declares one.
    """
    return error(
        "BG014",
        f"the scene has no device `{name}`",
        help=did_you_mean(name, have)
        or (f"its devices are {listed(have)}" if have else "a `device` statement declares one"),
    )


def driver_not_allowed(device: str, path: str, variable: str) -> Diagnostic:
    """BG015: a shared object that a scene may not load

    What: the scene names a driver by its path, which would run machine code of that file.

    Why: a model may come from anybody, so a scene alone does not load code.

    Example: `device hand = driver("./mine.so");`.

    Way out: list the folder in the environment variable `BGC_DRIVERS`, or give
    `--device hand=./mine.so` for one run.
    """
    return error(
        "BG015",
        f"device `{device}` would load machine code from `{path}`",
        help=f"if you trust that file, list its folder in {variable}, or give "
        f"`--device {device}={path}`",
    )


def no_driver_path(span: Span) -> Diagnostic:
    """BG016: a driver without the path of its shared object

    What: a device has `driver(..)` without a path.

    Why: `driver` loads a shared object, which its first argument names.

    Example: `device hand = driver(port = 3);`.

    Way out: write `device hand = driver("./mine.so", port = 3);`.
    """
    return error(
        "BG016",
        "`driver` needs the path of a shared object",
        span,
        help='write `driver("./mine.so", key = value)`',
    )
