"""`bgc haptic`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bgc.options import Options
from bgc.runtime.cli.app import AT_FAULT, print_diagnostics
from bgc.runtime.cli.keys import MOST_CHOICES, Choice, Menu, terminal_keys
from bgc.runtime.cli.options import (
    device_option,
    model_file,
    read_assignments,
    read_devices,
    read_solver,
    read_uses,
    scene_option,
    set_option,
    solver_options,
    use_option,
)
from bgc.runtime.cli.realtime import LiveView, print_couplings, read_limits, realtime_options
from bgc.runtime.cli.serving import announcing, require_aiohttp, serving_beside
from bgc.runtime.cli.signals import outlive_clients
from bgc.runtime.model import Model
from bgc.runtime.running.compiling import load_as
from bgc.runtime.running.devices import read_choices
from bgc.runtime.running.progress import CompilingLine
from bgc.runtime.running.quantity import read_quantity
from bgc.runtime.view.page import bundle

if TYPE_CHECKING:
    from bgc.runtime.realtime.loop import Realtime
    from bgc.runtime.view.following import LoopFollower


@click.command()
@model_file
@scene_option
@set_option
@use_option
@device_option
@click.option("--time", "duration", metavar="TIME", help="Simulated time; by default until Ctrl-C.")
@solver_options(step='Step and period of the loop: "1 ms".')
@click.option("--record", metavar="FILE", help="Record the motion: .csv, which `trace` replays.")
@click.option(
    "--exchange",
    "exchanges",
    multiple=True,
    metavar="SCENE",
    help="Scene, or NAME=VALUE, to which a key switches the running loop. May be repeated.",
)
@click.option("--view", is_flag=True, help="Show the loop in the browser, in 3D with plots.")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    help="Port of --view; a free one if omitted.",
)
@click.option("--no-browser", is_flag=True, help="Print the address of --view, open no browser.")
@click.option("--quiet", "-q", is_flag=True, help="Show no live view and no report.")
@realtime_options
@click.pass_context
def haptic(
    context: click.Context,
    /,
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    devices: tuple[str, ...],
    duration: str | None,
    record: str | None,
    exchanges: tuple[str, ...],
    view: bool,
    port: int,
    no_browser: bool,
    quiet: bool,
    **others: Any,
) -> None:
    """Run a scene of FILE in step with the clock, with its devices.

    The force goes to zero on any fault (status 1), and falls to zero after Ctrl-C, which ends the
    loop. With --view the loop is shown as `bgc view` shows a run; the loop does not wait for pages.
    """
    if view:
        bundle()  # reports first that there is no page
        require_aiohttp("`bgc haptic --view`")
        outlive_clients()
    chosen = read_devices(devices)
    options = Options(scene, uses=read_uses(uses), shapes=view)
    given = dict(read_assignments(assignments))
    with CompilingLine(file.name, wanted=not quiet) as line:
        model = load_as(Model, file, options, given, line)
        choices = [Choice(scene or model.facts.name, model, {})]
        for text in exchanges:
            if "=" in text:
                choices.append(Choice(text, model, dict(read_assignments((text,)))))
            else:
                other = load_as(Model, file, replace(options, scene=text), given, line)
                choices.append(Choice(text, other, {}))
    if len(choices) > MOST_CHOICES:
        raise click.UsageError(f"--exchange may be repeated {MOST_CHOICES - 1} times")
    print_diagnostics([warning for choice in choices for warning in choice.model.warnings])
    method = read_solver(others)
    follower = _follower(file.name, chosen, method) if view else None
    loop = model.realtime(
        None if duration is None else read_quantity(duration, "--time", "s"),
        devices=chosen,
        options=read_limits(others),
        record=record,
        keep=1,
        on_records=None if follower is None else follower.take,
        **method,
    )
    with ExitStack() as opened:
        opened.callback(loop.stop, at_once=True)  # where it has not ended before
        print_couplings(loop, quiet)
        keys = opened.enter_context(terminal_keys()) if exchanges else None
        if exchanges and keys is None:
            raise click.UsageError("--exchange needs a terminal, whose keys choose the scene")
        menu = None if keys is None else Menu(loop, choices, keys, method)
        if follower is not None:
            opened.enter_context(_shown(loop, follower, port, no_browser))
        with LiveView(loop, wanted=not quiet, menu=menu) as live:
            loop.start()
            report = live.follow()
        if follower is not None:
            follower.end(report)
    problem = [report.problem] if report.problem is not None else []
    refused = [] if menu is None else menu.refused
    print_diagnostics([*problem, *refused, *report.warnings(), *loop.warnings])
    if not quiet:
        click.echo("\n".join(report.lines()))
    if report.failed or any(warning.code == "BG779" for warning in loop.warnings):
        context.exit(AT_FAULT)


def _follower(name: str, devices: Mapping[str, str], method: Mapping[str, Any]) -> LoopFollower:
    # The page of a loop is loaded where it is asked for.
    from bgc.runtime.view.following import LoopFollower

    return LoopFollower(name, read_choices(devices), **method)


@contextmanager
def _shown(loop: Realtime, follower: LoopFollower, port: int, no_browser: bool) -> Iterator[None]:
    """Show a loop that has not started on pages, as long as the block runs."""
    # Needs aiohttp, which is optional.
    from bgc.runtime.view.server import Server

    server = Server(*follower.describe(loop.course.model))
    server.attach(follower)
    with serving_beside(partial(server.serve, port)):
        follower.follow(loop, server.publish)
        announcing(server, no_browser)()
        yield
