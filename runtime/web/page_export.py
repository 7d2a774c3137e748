"""Write a page that runs its model: one HTML file, which requests nothing."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter
from typing import Any, Final

from bgc.building.cache import open_cache
from bgc.diagnostics.catalogue.live_pages import page_without_graph
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.driver import Stages, compile_scene
from bgc.options import Options
from bgc.record_class import dataclass, field, replace
from bgc.runtime.results.files import written_whole
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.view.graph_page import metered_stages
from bgc.runtime.view.meter import Meter
from bgc.runtime.view.page import bundle, page
from bgc.runtime.web.content import page_content, run_settings
from bgc.runtime.web.module import METER, emitted_module, packed, require_zig

MOST_BONDS: Final = 5_000  # the layout of 6,000 takes 10 s, that of 18,000 more than eight minutes

# The page itself refuses requests. Its model runs in a worker that it makes of its own text.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; connect-src data: blob:; "
    "base-uri 'none'; form-action 'none'"
)


@dataclass(frozen=True)
class LivePage:
    """A model that runs in its page: the document, and the warnings and notices about it.

    In a notebook it is shown where it stands, in a frame `height` pixels high. `seconds` are those
    that the stages of its compilation took.
    """

    title: str
    document: str
    notices: tuple[Diagnostic, ...] = ()
    height: int = 520
    seconds: Mapping[str, float] = field(default_factory=dict)

    def save(self, path: str | Path) -> Path:
        """Write the page to a file, whole or not at all; BG055 where it cannot be written."""
        with written_whole(path) as aside:
            aside.write_text(self.document, "utf-8")
        return Path(path)

    def __repr__(self) -> str:
        return f"<bgc live page of {self.title}: {len(self.document) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        content = html.escape(self.document)
        style = f"width:100%;height:{self.height}px;border:0"
        allow = "gamepad; gyroscope; accelerometer"
        frame = f'title="{html.escape(self.title)}" style="{style}" allow="{allow}"'
        return f'<iframe {frame} srcdoc="{content}"></iframe>'


def live_page(file: Path, options: Options) -> LivePage:
    """Compile a scene to its page.

    Raises BgError: BG545 and BG547 where the module cannot be compiled, the faults of
    `run_settings`, and those of the model.
    """
    require_zig()
    bundle()  # reports first that there is no page
    options = replace(options, shapes=True)
    stages = compile_scene(file, options)
    model = LoadedModel(stages.built, file.absolute().parent, (file, options))
    return page_of(model, stages)


def page_of(model: LoadedModel, stages: Stages, height: int = 520) -> LivePage:
    """Make the page of a model that was compiled with shapes, with its present parameters.

    It has the bond graph of a model with bonds, unless these are more than `MOST_BONDS` (BG544).
    """
    require_zig()
    script = bundle()
    seconds = dict(stages.seconds)
    begin = perf_counter()
    settings, notices = run_settings(model)
    seconds["start"] = perf_counter() - begin
    begin = perf_counter()
    module = emitted_module(stages.emitted, open_cache())
    seconds["WebAssembly"] = perf_counter() - begin
    name = model.source_for("page")[0].name
    content = page_content(model, stages.built.places, name, settings, module)
    bonds = len(stages.graph.bonds)
    if bonds > MOST_BONDS:
        notices = (*notices, page_without_graph(bonds, MOST_BONDS))
    elif bonds:
        begin = perf_counter()
        content["graph"] = graph_content(model)
        seconds["graph"] = perf_counter() - begin
    data = json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    document = page(model.facts.name, script, data, kind="model", policy=_POLICY)
    return LivePage(model.facts.name, document, (*model.warnings, *notices), height, seconds)


def graph_content(model: LoadedModel) -> dict[str, Any]:
    """Prepare the graph of a model for the page, as data for JSON.

    The module is a second model, in which all bonds are observed; it follows the states, inputs and
    parameters of the run, as `bgc.runtime.view.meter` does beside the page of `bgc view`. A page
    has no compiler, so its graph has no slots.

    Raises BgError: the faults of the model, BG545 and BG547.
    """
    stages, description = metered_stages(*model.source_for("graph"))
    meter = Meter(stages.built, model)
    known = {name: k for k, name in enumerate(meter.parameters)}
    return {
        **meter.places,
        "description": {**description, "slots": [], "absent": meter.absent},
        "parameters": [known.get(name, -1) for name in model.parameters],
        "module": packed(emitted_module(stages.emitted, open_cache(), METER)),
    }
