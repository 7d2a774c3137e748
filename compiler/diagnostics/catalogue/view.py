"""Diagnostics: the page of `bgc view`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, quoted, warning


@error(
    "BG007: the page of `bgc view` was not bundled when bgc was installed",
    "with a network, run `python .build/bgc_build.py` in the checkout (it needs npm), or "
    "install bgc again",
)
def page_not_bundled() -> None: ...
@error(
    "BG008: port {port} is not available: {reason}",
    "give another `--port`, or omit it for a free one",
)
def cannot_listen(port: int, reason: str) -> None: ...
@error(
    "BG009: `{name}` is not a recorded run: {reason}",
    "record one with `bgc run FILE --shapes --out run.npz`",
)
def not_a_result(name: str, reason: str) -> None: ...
@error(
    "BG755: the run cannot go on with the new value of `{name}`: {reason}",
    "reset the run and give the value before it starts",
)
def parameter_not_applied(name: str, reason: str) -> None: ...
@error("BG756: {problem}")
def device_not_steered(name: str, driver: str, known: Sequence[str]) -> Values:
    if driver:
        return {
            "problem": f"the page cannot steer `{name}`, which has the driver `{driver}`",
            "help": f"start with `--device {name}=pointer`",
        }
    there = f"; it has {quoted(known)}" if known else ""
    return {"problem": f"the scene has no device `{name}`{there}"}


@error(
    "BG754: the compilation beside the run ended without a result",
    "the terminal of `bgc view` shows the reason",
)
def aside_failed() -> None: ...
@warning(
    "BG758: the files of the model have changed since this run was compiled",
    "start `bgc view` again to see the bond graph of the files as they are now",
)
def file_changed() -> None: ...
@error(
    "BG659: the modes of scene `{scene}` cannot be shown: {text}",
    "add a `shape` to a part that moves, or list the modes with `bgc modes`",
)
def no_mode_moves(scene: str, modes: int) -> Values:
    return {"text": f"none of its {modes} modes moves a shape" if modes else "it has no modes"}
