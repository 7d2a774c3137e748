"""BG007-BG010, BG754-BG756, BG758: the page of `bgc view`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic


def page_not_bundled() -> Diagnostic:
    """BG007: the page of `bgc view` was not bundled"""
    return error(
        "BG007",
        "the page of `bgc view` was not bundled when bgc was installed",
        help="with a network, run `python .build/bgc_build.py` in the checkout (it needs npm), or "
        "install bgc again",
    )


def cannot_listen(port: int, reason: str) -> Diagnostic:
    """BG008: the port of `bgc view` is not available"""
    return error(
        "BG008",
        f"port {port} is not available: {reason}",
        help="give another `--port`, or omit it for a free one",
    )


def not_a_result(name: str, reason: str) -> Diagnostic:
    """BG009: a file that is not a recorded run"""
    return error(
        "BG009",
        f"`{name}` is not a recorded run: {reason}",
        help="record one with `bgc run FILE --shapes --out run.npz`",
    )


def parameter_not_applied(name: str, reason: str) -> Diagnostic:
    """BG755: a running model cannot take a parameter value"""
    return error(
        "BG755",
        f"the run cannot go on with the new value of `{name}`: {reason}",
        help="reset the run and give the value before it starts",
    )


def device_not_steered(name: str, driver: str, known: Sequence[str]) -> Diagnostic:
    """BG756: a page cannot steer a device"""
    if not driver:
        there = f"; it has {', '.join(f'`{n}`' for n in known)}" if known else ""
        return error("BG756", f"the scene has no device `{name}`{there}")
    return error(
        "BG756",
        f"the page cannot steer `{name}`, which has the driver `{driver}`",
        help=f"start with `--device {name}=pointer`",
    )


def aside_failed() -> Diagnostic:
    """BG754: a compilation beside a live run failed"""
    return error(
        "BG754",
        "the compilation beside the run ended without a result",
        help="the terminal of `bgc view` shows the reason",
    )


def file_changed() -> Diagnostic:
    """BG758: the file of a live run has changed since it was compiled"""
    return warning(
        "BG758",
        "the files of the model have changed since this run was compiled",
        help="start `bgc view` again to see the bond graph of the files as they are now",
    )


def no_mode_moves(scene: str, modes: int) -> Diagnostic:
    """BG659: no mode of a scene moves a shape"""
    text = f"none of its {modes} modes moves a shape" if modes else "it has no modes"
    return error(
        "BG659",
        f"the modes of scene `{scene}` cannot be shown: {text}",
        help="add a `shape` to a part that moves, or list the modes with `bgc modes`",
    )
