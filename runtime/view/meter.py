"""Efforts and flows of all bonds at the state of a live run, from a model that observes them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from bgc.building.build_result import Built
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.structures import Status
from bgc.runtime.view.scene_description import Description

METERED: Final = "meter of bond"
"""Prefix of the columns with efforts and flows; names in a scene contain no blanks."""

_NONE: Final = -1


@dataclass(frozen=True, slots=True)
class GraphOfScene:
    """The description of a bond graph, and the build whose rows hold its efforts and flows."""

    description: Description
    built: Built


class Meter:
    """A metered model that follows a live one by the names of states, inputs and parameters.

    Attributes
    ----------
    width
        Numbers of a reading: effort and flow of each bond.
    absent
        States that the live model does without. They stand at their initial values.
    """

    def __init__(self, built: Built, live: LoadedModel) -> None:
        self._model = LoadedModel(built, live.folder)
        self._columns = [
            k for k, v in enumerate(self._model.measured) if v.name.startswith(METERED)
        ]
        self.width = len(self._columns)
        known = {variable.name: k for k, variable in enumerate(live.states)}
        places = [known.get(variable.name, _NONE) for variable in self._model.states]
        self._states = np.array(places, dtype=int)
        self.absent = [
            variable.name
            for variable, place in zip(self._model.states, places, strict=True)
            if place == _NONE
        ]
        inputs = {key: k for k, key in enumerate(_inputs(live))}
        self._inputs = [
            (k, inputs[key]) for k, key in enumerate(_inputs(self._model)) if key in inputs
        ]
        self._instance: Instance | None = None
        self._given: dict[str, float] = {}

    @property
    def source(self) -> str:
        """The hash of the source from which its model was compiled."""
        return text(self._model.library.model.hash)

    @property
    def places(self) -> dict[str, list[Any]]:
        """The places in its model of what another host than this class has to give and to read.

        `states` has for each of its states that of the live model, or -1; `inputs` has pairs of
        its own and the live one; `columns` are efforts and flows in its rows.
        """
        return {
            "states": self._states.tolist(),
            "inputs": [list(pair) for pair in self._inputs],
            "columns": list(self._columns),
        }

    @property
    def parameters(self) -> list[str]:
        """The names of its parameters, in order."""
        return list(self._model.parameters)

    def read(self, state: Array, inputs: Array, time: float, given: Mapping[str, float]) -> Array:
        """Read e1, f1, e2, f2 .. at a state of the live run; NaN where that fails."""
        if self._instance is None or self._given != given:
            self._given = dict(given)
            known = self._model.parameters
            mine = {name: value for name, value in given.items() if name in known}
            self._instance = known.instance(mine)
        instance = self._instance
        status = instance.reset(time, checked=False)
        here = self._states >= 0
        instance.state[here] = state[self._states[here]]
        for mine_at, live_at in self._inputs:
            instance.input[mine_at] = inputs[live_at]
        if status is Status.OK:
            status = instance.restart()
        values = instance.outputs()[1][self._columns]
        if status is not Status.OK:
            values[:] = np.nan
        return values


def _inputs(model: LoadedModel) -> list[tuple[str, int, int]]:
    """Name each input of a model: its device, channel and component, or its number alone."""
    table = model.library.model
    uses = [table.input[k] for k in range(table.n_input)]
    names = ["" if use.device < 0 else text(table.device[use.device].name) for use in uses]
    return [
        (name, use.channel, use.component) if name else ("", _NONE, k)
        for k, (name, use) in enumerate(zip(names, uses, strict=True))
    ]
