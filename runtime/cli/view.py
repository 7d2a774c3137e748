"""Run 2: show a scene in the browser, live, or a recorded run."""

from pathlib import Path
from typing import Any

from bgc.runtime.cli.command import Target, command, option, require
from bgc.runtime.cli.command_server import announce, prepare_serving, serving, wait_for
from bgc.runtime.cli.options import (
    Devices,
    Errors,
    MethodOptions,
    PointOptions,
    Preview,
    SceneOptions,
    Strict,
    Whole,
)
from bgc.runtime.cli.printing import attempt, print_diagnostics, print_text, write_file
from bgc.runtime.model import Model
from bgc.runtime.running.arguments import read_solver
from bgc.runtime.running.device_drivers import Choices, read_choices
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.run import with_capped_step
from bgc.runtime.running.simulate import method_of, times_of
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.page import bundle, page, replay_data
from bgc.runtime.view.part_exchange import Exchange, Prepared
from bgc.runtime.view.player import Player
from bgc.runtime.view.recording import RESULTS, Recording, read_recording, recorded
from bgc.runtime.view.scene_description import describe_model, meshes_of


@command()
def view(
    scene: SceneOptions,
    whole: Whole,
    strict: Strict,
    preview: Preview,
    devices: Devices,
    method: MethodOptions,
    error: Errors,
    *,
    export: str | None = option(
        "Write a replay as one HTML file, and serve nothing.", type=Target(".html", ".htm")
    ),
    port: int = option("Port; a free one if omitted.", within=(0, 65535), default=0),
    modes: bool = option("Show the modes of the linear form, one by one."),
    point: PointOptions,
    no_browser: bool = option("Print the address and open no browser."),
    quiet: bool = option("Print no progress.", "--quiet", "-q"),
) -> int:
    """Show a scene of FILE in the browser: its shapes in 3D, its plots, sliders for its parameters.

    FILE may also be a recorded run, which is replayed: the .npz file of `bgc run FILE --shapes
    --out run.npz`, or a .csv file, which has plots only.

    The page is served to this machine alone, behind a token, until Ctrl-C ends the command.
    `--export` runs the scene and writes its replay as one file that needs no server.

    `--modes` shows the modes at the initial state, at a time (--at) or in equilibrium (--steady),
    with frequencies and damping ratios; the page animates the shapes in one of them.
    """
    require(modes or not point.is_given, "--at and --steady need --modes")
    bundle()  # reports first that there is no page
    status, recording = 0, None
    if scene.file.suffix.lower() in RESULTS:
        recording = read_recording(scene.file)
    if export is None:
        prepare_serving("`bgc view`")
    if recording is None:
        model = scene.model(quiet, whole=whole, strict=strict, preview=preview, shapes=True)
        if modes:
            # Loads the compiler, which a model from the cache does without.
            from bgc.runtime.view.mode_shapes import record_modes

            assert model.origin is not None
            recording = record_modes(model, *model.origin, point.point)
        elif export is None:
            _serve_model(model, read_choices(dict(devices)), port, no_browser, **method.arguments)
            return 0
        else:
            result, status = attempt(
                lambda: model.simulate(
                    **method.arguments,
                    progress=not quiet,
                    devices=dict(devices),
                    error=error is not False,
                )
            )
            print_diagnostics(result.warnings)
            recording = recorded(result, scene.file.name, model.folder)
    if export is None:
        _serve_recording(recording, port, no_browser)
    else:
        _export(recording, export, quiet)
    return status


def _export(recording: Recording, export: str, quiet: bool) -> None:
    data = replay_data(recording.description, recording.rows, recording.meshes)
    write_file(export, page(recording.description["scene"], bundle(), data))
    if not quiet:
        size = Path(export).stat().st_size / 1e6
        print_text(f"wrote {export} ({size:.1f} MB, {len(recording.rows):,} rows)")


def _serve_recording(recording: Recording, port: int, no_browser: bool) -> None:
    # Needs aiohttp, which is optional.
    from bgc.runtime.view.server import Server

    server = Server(recording.description, recording.meshes, recording.rows)
    with serving(server, port) as thread:
        announce(server, no_browser)
        wait_for(thread)


def _serve_model(
    model: Model,
    devices: Choices,
    port: int,
    no_browser: bool,
    *,
    duration: float | None,
    every: float | None,
    **solver: Any,
) -> None:
    # Needs aiohttp, which is optional.
    from bgc.runtime.view.server import Server

    assert model.origin is not None
    name = model.origin[0].name

    def prepare(model: LoadedModel) -> Prepared:
        method, notices = method_of(model, read_solver(solver))
        print_diagnostics(notices)
        if duration or model.facts.duration:
            times = times_of(model, method, duration, every)
            method = with_capped_step(method, times, model.facts.timed)
        description = describe_model(model, name, devices)
        meshes = meshes_of(description, model.folder)
        return Prepared(LiveRun(model, method, {}, devices), description, meshes)

    prepared = prepare(model)
    server = Server(prepared.description, prepared.meshes)
    exchange = Exchange(*model.origin, prepare)
    player = Player(prepared.run, server.publish, duration, every, exchange)
    try:
        first = prepared.run.reset()
        server.attach(player)
        with serving(server, port) as thread:
            player.start(first)
            announce(server, no_browser)
            wait_for(thread)
    finally:
        player.close()
        prepared.run.close()
