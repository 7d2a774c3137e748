"""`bgc view`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from bgc.options import Options
from bgc.runtime.cli.app import AT_FAULT, print_diagnostics
from bgc.runtime.cli.options import (
    check_target,
    device_option,
    method_options,
    point_options,
    preview_option,
    read_assignments,
    read_devices,
    read_method,
    read_point,
    read_uses,
    scene_option,
    set_option,
    strict_option,
    use_option,
    whole_option,
)
from bgc.runtime.cli.serving import announcing, require_aiohttp, run_until_signal
from bgc.runtime.cli.signals import outlive_clients
from bgc.runtime.model import Model
from bgc.runtime.results.files import written_whole
from bgc.runtime.running.compiling import load_as
from bgc.runtime.running.devices import Choices, read_choices
from bgc.runtime.running.failures import SimulationError
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.progress import CompilingLine
from bgc.runtime.running.simulate import method_of, times_of
from bgc.runtime.view.description import describe_model, meshes_of
from bgc.runtime.view.exchange import Exchange, Prepared
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.page import bundle, page, replay_data
from bgc.runtime.view.player import Player
from bgc.runtime.view.recording import RESULTS, Recording, read_recording, recorded

_PAGES = (".html", ".htm")


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@scene_option
@set_option
@use_option
@whole_option
@strict_option
@preview_option
@device_option
@method_options
@click.option(
    "--export", metavar="FILE", help="Write a replay as one HTML file, and serve nothing."
)
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Port; a free one if omitted."
)
@click.option("--modes", is_flag=True, help="Show the modes of the linear form, one by one.")
@point_options
@click.option("--no-browser", is_flag=True, help="Print the address and open no browser.")
@click.option("--quiet", "-q", is_flag=True, help="Print no progress.")
def view(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    whole: bool,
    strict: bool,
    preview: bool,
    export: str | None,
    port: int,
    modes: bool,
    at: str | None,
    steady: bool,
    no_browser: bool,
    quiet: bool,
    devices: tuple[str, ...],
    **method: Any,
) -> None:
    """Show a scene of FILE in the browser: its shapes in 3D, its plots, sliders for its parameters.

    FILE may also be a recorded run, which is replayed: the .npz file of `bgc run FILE --shapes
    --out run.npz`, or a .csv file, which has plots only.

    The page is served to this machine alone, behind a token, until Ctrl-C ends the command.
    `--export` runs the scene and writes its replay as one file that needs no server.

    `--modes` shows the modes at the initial state, at a time (--at) or in equilibrium (--steady),
    with frequencies and damping ratios; the page animates the shapes in one of them.
    """
    check_target(export, _PAGES)
    if (at is not None or steady) and not modes:
        raise click.UsageError("--at and --steady need --modes")
    where = read_point(at, steady)
    bundle()  # reports first that there is no page
    if file.suffix.lower() in RESULTS:
        recording = read_recording(file)
        if export is not None:
            _export(recording, export, quiet)
        else:
            _serve_recording(recording, port, no_browser)
        return
    arguments = read_method(method)
    chosen = read_devices(devices)
    options = Options(
        scene, strict=strict, whole=whole, uses=read_uses(uses), preview=preview, shapes=True
    )
    if export is None:
        require_aiohttp("`bgc view`")
        outlive_clients()
    with CompilingLine(file.name, wanted=not quiet) as line:
        model = load_as(Model, file, options, dict(read_assignments(assignments)), line)
    print_diagnostics(model.warnings)
    if modes:
        # Loads the compiler, which a model from the cache does without.
        from bgc.runtime.view.modes import record_modes

        found = record_modes(model, file, options, where)
        if export is not None:
            _export(found, export, quiet)
        else:
            _serve_recording(found, port, no_browser)
    elif export is not None:
        _export_run(model, file, {**arguments, "devices": chosen}, export, quiet)
    else:
        _serve_model(model, file, arguments, read_choices(chosen), port, no_browser)


def _export_run(
    model: Model, file: Path, arguments: dict[str, Any], export: str, quiet: bool
) -> None:
    """Run a scene and write its replay; after a failure the rows up to there."""
    try:
        result = model.simulate(**arguments, progress=not quiet)
    except SimulationError as problem:
        print_diagnostics(problem.diagnostics)
        _export(recorded(problem.result, file.name, model.folder), export, quiet)
        sys.exit(AT_FAULT)
    print_diagnostics(result.warnings)
    _export(recorded(result, file.name, model.folder), export, quiet)


def _export(recording: Recording, export: str, quiet: bool) -> None:
    data = replay_data(recording.description, recording.rows, recording.meshes)
    with written_whole(export) as aside:
        aside.write_text(page(recording.description["scene"], bundle(), data), "utf-8")
    if not quiet:
        size = Path(export).stat().st_size / 1e6
        click.echo(f"wrote {export} ({size:.1f} MB, {len(recording.rows):,} rows)")


def _serve_recording(recording: Recording, port: int, no_browser: bool) -> None:
    require_aiohttp("`bgc view`")
    outlive_clients()
    # Needs aiohttp, which is optional.
    from bgc.runtime.view.server import Server

    server = Server(recording.description, recording.meshes, recording.rows)
    run_until_signal(server.serve(port, announcing(server, no_browser)))


def _serve_model(
    model: Model,
    file: Path,
    arguments: dict[str, Any],
    devices: Choices,
    port: int,
    no_browser: bool,
) -> None:
    # Needs aiohttp, which is optional.
    from bgc.runtime.view.server import Server

    duration, every = arguments.pop("duration"), arguments.pop("every")
    start, solver = arguments.pop("start"), arguments.pop("solver")

    def prepare(model: LoadedModel) -> Prepared:
        method, notices = method_of(model, solver, arguments)
        method = method.started(start)
        print_diagnostics(notices)
        if duration or model.facts.duration:
            times = times_of(model, method, duration, every)
            method = method.with_capped_step(times, model.facts.timed)
        description = describe_model(model, file.name, devices)
        meshes = meshes_of(description, model.folder)
        return Prepared(LiveRun(model, method, {}, devices), description, meshes)

    prepared = prepare(model)
    run = prepared.run
    server = Server(prepared.description, prepared.meshes)
    assert model.origin is not None
    exchange = Exchange(*model.origin, prepare)
    player = Player(run, server.publish, duration, every, exchange)
    try:
        first = run.reset()
        server.attach(player)

        def ready() -> None:
            player.start(first)
            announcing(server, no_browser)()

        run_until_signal(server.serve(port, ready))
    finally:
        player.close()
        run.close()
