"""The bond graph of a page that runs its model, and the module that measures its bonds."""

from __future__ import annotations

from typing import Any

from bgc.building.cache import open_cache
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.view.graph_page import metered_stages
from bgc.runtime.view.meter import Meter
from bgc.runtime.web.module import METER, emitted_module, packed


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
