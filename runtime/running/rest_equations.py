"""The equations of a start at rest at a point z, and their slopes.

z holds the states in their scales, then the parameters that are varied.
"""

from __future__ import annotations

import numpy as np

from bgc.language.scene import Rest
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.relations import Undefined
from bgc.runtime.running.rest_instance import Resting
from bgc.runtime.running.structures import Status

_PART = 1e-6  # of a state's scale or a parameter, for a difference quotient


class RestEquations:
    """The equations of one instance, which is put at the points where they are evaluated."""

    def __init__(self, instance: Instance, rest: Rest) -> None:
        self.instance, self.time = instance, instance.time
        model = instance.library.model
        self.resting = Resting(instance, rest.sampled)
        self.size = self.resting.size
        outputs = [text(model.output[k].name) for k in range(model.n_output)]
        self.held = [outputs.index(name) for name in rest.hold]
        parameters = [text(model.param[k].name) for k in range(model.n_param)]
        self.varied = [parameters.index(name) for name in rest.vary]
        self.given_by = rest.given  # of each state, what the model gives
        self.switches = rest.switches  # of each switch, the element in whose law it stands
        self.scale = self.resting.scale
        self.start: Array = self.resting.state / self.scale
        self.given = np.array([instance.parameter(k) for k in self.varied])
        self.of_parameters = np.where(self.given != 0, np.abs(self.given), 1.0)
        self.declared = self.start  # y0 at the present parameters
        begin = np.concatenate([self.start, self.given / self.of_parameters])
        self.wanted = self.outputs(begin)[self.held] if self.held else np.empty(0)

    def go(self, z: Array) -> None:
        """Put the instance at z."""
        instance = self.instance
        if self.varied:
            values = z[self.size :] * self.of_parameters
            if not np.array_equal(values, [instance.parameter(k) for k in self.varied]):
                info = instance.library.model.param
                for index, value in zip(self.varied, values.tolist(), strict=True):
                    if not info[index].low <= value <= info[index].high:
                        raise Undefined(Status.BAD_ARGUMENT)
                    instance.set_parameter(index, value)
                require_ok(instance.reset(self.time, checked=False))
                self.declared = self.resting.state / self.scale
        self.resting.put(z[: self.size] * self.scale)

    def outputs(self, z: Array) -> Array:
        """The outputs at z."""
        self.go(z)
        status, found = self.instance.outputs()
        require_ok(status)
        return found

    def residuals(self, z: Array) -> Array:
        """All equations at z, not scaled by rows; rates are in scales of their states."""
        self.go(z)
        status, rates = self.resting.rates()
        require_ok(status)
        status, values, _ = self.resting.chain_rows()
        require_ok(status)
        held = self.outputs(z)[self.held] - self.wanted if self.held else np.empty(0)
        found: Array = np.concatenate([rates / self.scale, values, held])
        if not np.isfinite(found).all():
            raise Undefined(Status.NOT_FINITE)
        return found

    def by_state(self, y: Array) -> Array:
        """Derivatives of the rates by the states, at the present parameters."""
        self.resting.put(y * self.scale)
        status, by_state = self.resting.slope()
        require_ok(status)
        found: Array = by_state * self.scale / self.scale[:, None]
        return found

    def slopes(self, z: Array) -> tuple[Array, Array]:
        """Derivatives of the residuals by z, and of y0 by the parameters."""
        self.go(z)
        rates = self.by_state(z[: self.size])
        status, _, by_place = self.resting.chain_rows()
        require_ok(status)
        states = np.vstack([rates, by_place * self.scale, self._held_slopes(z)])
        starts = np.zeros((self.size, len(self.varied)))
        columns = np.zeros((len(states), len(self.varied)))
        for k in range(len(self.varied)):
            moved = z.copy()
            found = []
            for sign in (1, -1):
                moved[self.size + k] = z[self.size + k] + sign * _PART
                found.append((self.residuals(moved), self.declared.copy()))
            (above, later), (below, earlier) = found
            columns[:, k] = (above - below) / (2 * _PART)
            starts[:, k] = (later - earlier) / (2 * _PART)
        self.go(z)
        return np.hstack([states, columns]), starts

    def _held_slopes(self, z: Array) -> Array:
        slopes = np.zeros((len(self.held), self.size))
        if self.held:
            moved = z.copy()
            for k in range(self.size):
                part = _PART * max(1.0, abs(z[k]))
                moved[k] = z[k] + part
                above = self.outputs(moved)[self.held]
                moved[k] = z[k] - part
                slopes[:, k] = (above - self.outputs(moved)[self.held]) / (2 * part)
                moved[k] = z[k]
        return slopes


def require_ok(status: Status) -> None:
    """Raise `Undefined` unless the status is OK."""
    if status is not Status.OK:
        raise Undefined(status)
