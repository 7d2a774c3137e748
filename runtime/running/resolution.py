"""The resolution of what a scene observes: its change where states change by their scales."""

from __future__ import annotations

import numpy as np

from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.structures import Status


def observed_scales(model: LoadedModel) -> Array:
    """The change of each observed quantity where every state changes by its scale, at the start.

    A tolerance of the states times this is that of the quantity. Zero where there is no start.
    """
    instance = model.parameters.instance({})
    found = np.zeros(len(model.measured))
    if instance.reset(checked=False) is not Status.OK:
        return found
    _, start = instance.outputs()
    for k, size in enumerate(instance.scale.tolist()):
        present = instance.state[k]
        instance.state[k] = present + size
        _, moved = instance.outputs()
        instance.state[k] = present
        change = np.abs(moved - start)
        found += np.where(np.isfinite(change), change, 0.0)
    return found
