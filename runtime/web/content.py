"""The data of a page that runs its model: the scene, the module, and the settings of its run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from bgc.building.backends import BACKENDS
from bgc.building.build_result import Places
from bgc.diagnostics.catalogue.arguments import device_not_opened
from bgc.diagnostics.catalogue.fmu_parts import fmu_left_out
from bgc.diagnostics.catalogue.live_pages import solver_not_in_page
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.solver import Solver
from bgc.runtime.running.binding import text
from bgc.runtime.running.device_drivers import Choices, DeviceChoice
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.poses import FED
from bgc.runtime.running.run import option_values, with_capped_step
from bgc.runtime.running.simulate import method_of, times_of
from bgc.runtime.view.page import data_url
from bgc.runtime.view.player import usual_speed
from bgc.runtime.view.scene_description import describe_model, meshes_of
from bgc.runtime.web.faults import fault_messages
from bgc.runtime.web.module import DRIVERS, packed

Content = dict[str, Any]

_HAND: Final = "pointer"


def run_settings(model: LoadedModel) -> tuple[Content, tuple[Diagnostic, ...]]:
    """Prepare the settings of the runs of a page, and the notices about its method.

    A start that has to be searched for is found here: the page starts from the states found.

    Raises BgError: BG548 for a solver of another package, BG674 for an FMU in the model, BG074 for
    a recorded motion that cannot be read, and all faults of a start.
    """
    method, notices = method_of(model)
    if method.name in BACKENDS:
        raise BgError([solver_not_in_page(method.name, model.solvers)])
    if model.facts.fmus:
        way = "a page runs in a browser, which has no place for its program: use `bgc view`"
        raise BgError([fmu_left_out("a page", model.facts.fmus[0].name, way)])
    if model.facts.duration:
        method = with_capped_step(method, times_of(model, method), model.facts.timed)
    drivers = _drivers(model)
    start = _start(model, method, drivers)  # refuses files that are not a recorded motion
    instance = model.parameters.instance({})
    settings = {
        "method": method.name,
        "options": list(option_values(method, bool(model.accounts)).values()),
        "every": model.facts.every,
        "speed": usual_speed(model.facts.duration),
        "given": _indexed(model, model.parameters.given({})),
        "values": model.parameters.values_in(instance),
        "start": start,
        "states": [state.name for state in model.states],
        "devices": [_with_file(device, model.folder) for device in drivers],
    }
    return settings, notices


def page_content(
    model: LoadedModel, places: Places, name: str, settings: Content, module: bytes
) -> Content:
    """Prepare the data of a page for JSON.

    The model was compiled with shapes; `name` is that of its file, `module` its WebAssembly.
    """
    description = describe_model(model, name, _replaced(model, settings["devices"]))
    return {
        **settings,
        "description": description,
        "meshes": [data_url(path) for path in meshes_of(description, model.folder)],
        "module": packed(module),
        "faults": fault_messages(model, places),
    }


def _indexed(model: LoadedModel, values: Mapping[str, float]) -> list[tuple[int, float]]:
    """Values of parameters by their indices."""
    index = {name: k for k, name in enumerate(model.parameters)}
    return [(index[name], value) for name, value in values.items()]


def _drivers(model: LoadedModel) -> list[dict[str, str]]:
    """The devices with the drivers and options that they have in the page.

    `gamepad` differs from `pointer` for the page alone. A driver that a browser does not have is
    replaced by the hand of the page.
    """
    table = model.library.model
    found = []
    for k in range(table.n_device):
        info = table.device[k]
        driver, options = text(info.driver), text(info.options)
        driver = _HAND if driver in FED else driver
        kept = (driver, options) if driver in DRIVERS else (_HAND, "")
        found.append({"name": text(info.name), "driver": kept[0], "options": kept[1]})
    return found


def _with_file(device: dict[str, str], folder: Path) -> dict[str, str]:
    """Add the file that a device reads: its name in the options, and its text."""
    for line in device["options"].split("\n"):
        key, _, value = line.partition("=")
        if key == "file":
            try:
                return {**device, "file": value, "text": (folder / value).read_text("utf-8")}
            except (OSError, UnicodeDecodeError) as problem:
                reason = f"{value}: {problem}"
                name, driver = device["name"], device["driver"]
                raise BgError([device_not_opened(name, driver, reason)]) from problem
    return device


def _replaced(model: LoadedModel, drivers: Sequence[Mapping[str, str]]) -> Choices:
    """The drivers other than the scene's."""
    table = model.library.model
    own = (text(table.device[k].driver) for k in range(table.n_device))
    return {
        d["name"]: DeviceChoice(d["driver"], d["options"])
        for driver, d in zip(own, drivers, strict=True)
        if driver not in (d["driver"], *FED)
    }


def _start(model: LoadedModel, method: Solver, drivers: list[dict[str, str]]) -> Content | None:
    """The state of a start that is searched for, and the parameters that it varies.

    None where the start follows from the parameters. The model is started in any case, so that a
    scene that cannot start is refused here and not in the page.
    """
    choices = _replaced(model, drivers)
    rest = model.facts.rest_for(method.start)
    with model.started(method, bool(model.accounts), devices=choices) as instance:
        if rest is None and not (method.settle or model.facts.solver.settle):
            return None
        names = list(model.parameters)
        varied = [names.index(name) for name in (rest.vary if rest is not None else ())]
        return {
            "state": instance.start_values().tolist(),
            "varied": varied,
            "values": [instance.parameter(k) for k in varied],
        }
