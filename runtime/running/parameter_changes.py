"""Parameters that change in the middle of a run, while the state stays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bgc.runtime.running.binding import Instance
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.structures import Status


def change_parameters(
    model: LoadedModel, instance: Instance, time: float, values: Mapping[str, float]
) -> Status:
    """Set parameters, SI, at a time that the instance has just reached, and restart it there.

    The energy accounts start again at zero. Where the run cannot go on, the status says why and
    the caller restores what it saved.
    """
    state = instance.state_at(time)
    if not np.isfinite(state).all():
        state, time = instance.state.copy(), instance.time
    inputs = instance.input.copy()
    model.parameters.set_in(instance, values)
    status = instance.reset(time, checked=False)
    if status is Status.OK:
        instance.state[:] = state
        instance.input[:] = inputs
        status = instance.restart()
    return status
