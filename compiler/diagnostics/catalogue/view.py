"""BG007-BG010, BG754-BG756, BG758: the page of `bgc view`."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic


def page_not_bundled() -> Diagnostic:
    """BG007: the page of `bgc view` was not bundled

    What: the script of the page is not part of this installation.

    Why: npm bundles it when bgc is installed from its source, and npm or its packages could not be
    reached then. Everything else was installed.

    Example: `pip install .` without a network, then `bgc view crane.bg`.

    Way out: install again with a network, `pip install --force-reinstall --no-deps .`, or in a
    checkout run `python .build/bgc_build.py`. A wheel of bgc contains the script.
    """
    return error(
        "BG007",
        "the page of `bgc view` was not bundled when bgc was installed",
        help="with a network, run `python .build/bgc_build.py` in the checkout (it needs npm), or "
        "install bgc again",
    )


def cannot_listen(port: int, reason: str) -> Diagnostic:
    """BG008: the port of `bgc view` is not available

    What: the page cannot be served at this port.

    Why: usually another program listens there, for example another `bgc view`. Ports below 1024
    belong to the system.

    Example: two commands `bgc view crane.bg --port 8000`.

    Way out: give another port, or omit `--port`: a free port is chosen then.
    """
    return error(
        "BG008",
        f"port {port} is not available: {reason}",
        help="give another `--port`, or omit it for a free one",
    )


def not_a_result(name: str, reason: str) -> Diagnostic:
    """BG009: a file that is not a recorded run

    What: the file does not contain the rows of a run.

    Why: `bgc view` replays the files that `bgc run --out` writes, `.npz` and `.csv`; others do not
    have their columns.

    Example: `bgc view weights.npz` with an archive of another program.

    Way out: record a run with `bgc run FILE --shapes --out run.npz`.
    """
    return error(
        "BG009",
        f"`{name}` is not a recorded run: {reason}",
        help="record one with `bgc run FILE --shapes --out run.npz`",
    )


def parameter_not_applied(name: str, reason: str) -> Diagnostic:
    """BG755: a running model cannot take a parameter value

    What: a value was given to a parameter of a running model, which cannot go on with it from its
    present state. It goes on with the earlier value.

    Why: the state contradicts the new value. A closed chain no longer closes when the length of one
    of its bars changes, for example, or an algebraic equation has no solution.

    Example: the slider of a bar's length in a four-bar linkage.

    Way out: reset the run, which then starts with the new value, or change the value by less.
    """
    return error(
        "BG755",
        f"the run cannot go on with the new value of `{name}`: {reason}",
        help="reset the run and give the value before it starts",
    )


def device_not_steered(name: str, driver: str, known: Sequence[str]) -> Diagnostic:
    """BG756: a page cannot steer a device

    What: a page gave a pose to a device that the scene does not have, or that has the driver of a
    real hand.

    Why: the page takes over devices that are simulated: those with the drivers `pointer`,
    `gamepad`, `trace` and `spring_hand`. A device that a person holds is not taken away from them.

    Example: the handle on the page is dragged while `--device hand=forcedimension` moves the crane.

    Way out: `bgc view FILE --device hand=pointer`; in real time, `bgc haptic FILE
    --view` shows what the device of a hand does.
    """
    if not driver:
        there = f"; it has {', '.join(f'`{n}`' for n in known)}" if known else ""
        return error("BG756", f"the scene has no device `{name}`{there}")
    return error(
        "BG756",
        f"the page cannot steer `{name}`, which has the driver `{driver}`",
        help=f"start with `--device {name}=pointer`",
    )


def aside_failed() -> Diagnostic:
    """BG754: a compilation beside a live run failed

    What: the process that compiles the bond graph of a page, or the model with another part in a
    slot, ended without a result. The run goes on as it was.

    Why: the process was killed, for example for lack of memory, or bgc has a fault. The terminal of
    `bgc view` shows what it wrote.

    Example: a machine without free memory.

    Way out: try again, or start the command with the part, as `bgc view FILE --use slot=Part`.
    """
    return error(
        "BG754",
        "the compilation beside the run ended without a result",
        help="the terminal of `bgc view` shows the reason",
    )


def file_changed() -> Diagnostic:
    """BG758: the file of a live run has changed since it was compiled

    What: the bond graph was asked for on a page, and the files of the model are not those from
    which its run was compiled. No graph is shown, since its powers would not be those of the run.

    Why: a file of the model, or a data file that it reads, was edited while `bgc view` ran.

    Example: another mass was written into `crane.bg` between the start of `bgc view crane.bg` and a
    click on Bond graph.

    Way out: end the command and start it again, or choose a part in a slot, which compiles the
    files as they are then.
    """
    return warning(
        "BG758",
        "the files of the model have changed since this run was compiled",
        help="start `bgc view` again to see the bond graph of the files as they are now",
    )


def no_mode_moves(scene: str, modes: int) -> Diagnostic:
    """BG659: no mode of a scene moves a shape

    What: `bgc view --modes` shows how the shapes of a scene move in its modes, and there is none
    that moves one.

    Why: the scene has no states, no shapes, or shapes that depend on no state.

    Example: an electric circuit.

    Way out: give a part a `shape`, or list the modes as a table: `bgc modes FILE`.
    """
    text = f"none of its {modes} modes moves a shape" if modes else "it has no modes"
    return error(
        "BG659",
        f"the modes of scene `{scene}` cannot be shown: {text}",
        help="add a `shape` to a part that moves, or list the modes with `bgc modes`",
    )
