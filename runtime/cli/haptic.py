"""Run 3: run a scene in real time with its devices."""

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bgc.language.scene import Scene
from bgc.runtime.cli.command import command, option, require
from bgc.runtime.cli.command_server import announce, prepare_serving, serving
from bgc.runtime.cli.keys import MOST_CHOICES, Choice, Menu, terminal_keys
from bgc.runtime.cli.options import ASSIGNED, TABLE, Devices, SceneOptions, SolverOptions, option_of
from bgc.runtime.cli.printing import AT_FAULT, print_diagnostics, print_text
from bgc.runtime.cli.realtime import LimitOptions, follow, print_couplings
from bgc.runtime.running.device_drivers import read_choices
from bgc.runtime.view.page import bundle

if TYPE_CHECKING:
    from bgc.runtime.realtime.loop import Realtime
    from bgc.runtime.view.loop_view import LoopFollower


@command()
def haptic(
    scene: SceneOptions,
    devices: Devices,
    *,
    duration: float | None = option_of(
        Scene, "duration", "Simulated time; by default until Ctrl-C."
    ),
    method: SolverOptions,
    record: str | None = option(
        "Record the motion: .csv, which `trace` replays.", type=TABLE, metavar="FILE"
    ),
    exchanges: tuple[str, ...] = option(
        "Scene, or NAME=VALUE, to which a key switches the running loop. May be repeated.",
        "--exchange",
        metavar="SCENE",
    ),
    view: bool = option("Show the loop in the browser, in 3D with plots."),
    port: int = option("Port of --view; a free one if omitted.", within=(0, 65535), default=0),
    no_browser: bool = option("Print the address of --view, open no browser."),
    quiet: bool = option("Show no live view and no report.", "--quiet", "-q"),
    limits: LimitOptions,
) -> int:
    """Run a scene of FILE in step with the clock, with its devices.

    The force goes to zero on any fault (status 1), and falls to zero after Ctrl-C, which ends the
    loop. With --view the loop is shown as `bgc view` shows a run; the loop does not wait for pages.
    """
    require(len(exchanges) < MOST_CHOICES, f"--exchange may be repeated {MOST_CHOICES - 1} times")
    if view:
        bundle()  # reports first that there is no page
        prepare_serving("`bgc haptic --view`")
    model = scene.model(quiet, shapes=view)
    choices = [Choice(scene.scene or model.facts.name, model, {})]
    for text in exchanges:
        if "=" in text:
            choices.append(Choice(text, model, dict([ASSIGNED.convert(text, None, None)])))
        else:
            choices.append(Choice(text, replace(scene, scene=text).model(quiet, shapes=view), {}))
    follower = _follower(scene.file.name, dict(devices), method.arguments) if view else None
    loop = model.realtime(
        duration,
        devices=dict(devices),
        options=limits.options,
        record=record,
        keep=1,
        on_records=None if follower is None else follower.take,
        **method.arguments,
    )
    with ExitStack() as opened:
        opened.callback(loop.stop, at_once=True)  # where it has not ended before
        print_couplings(loop, quiet)
        keys = opened.enter_context(terminal_keys()) if exchanges else None
        require(
            keys is not None or not exchanges,
            "--exchange needs a terminal, whose keys choose the scene",
        )
        menu = None if keys is None else Menu(loop, choices, keys, method.arguments)
        if follower is not None:
            opened.enter_context(_shown(loop, follower, port, no_browser))
        report = follow(loop, quiet, menu)
        if follower is not None:
            follower.end(report)
    problem = [report.problem] if report.problem is not None else []
    refused = [] if menu is None else menu.refused
    print_diagnostics([*problem, *refused, *report.warnings(), *loop.warnings])
    if not quiet:
        print_text("\n".join(report.lines()))
    late = any(warning.code == "BG779" for warning in loop.warnings)
    return AT_FAULT if report.failed or late else 0


def _follower(name: str, devices: Mapping[str, str], method: Mapping[str, Any]) -> "LoopFollower":
    # The page of a loop is loaded where it is asked for.
    from bgc.runtime.view.loop_view import LoopFollower

    return LoopFollower(name, read_choices(devices), **method)


@contextmanager
def _shown(
    loop: "Realtime", follower: "LoopFollower", port: int, no_browser: bool
) -> Iterator[None]:
    """Show a loop that has not started on pages, as long as the block runs."""
    # Needs aiohttp, which is optional.
    from bgc.runtime.view.server import Server

    server = Server(*follower.describe(loop.course.model))
    server.attach(follower)
    with serving(server, port):
        follower.follow(loop, server.publish)
        announce(server, no_browser)
        yield
