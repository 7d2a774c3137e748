"""An instance with the values of its sampled parts as further states, for a start at rest.

A sampled part is at rest where the next instant changes none of its values. With the values s that
it holds, their updates g(t, x, s) and the period T, these are the zeros of

    s' = (g(t, x, s) - s)/T

the mean rate of s over a period: the sum of a digital integrator moves as the integral of an
analogue one. The values of sampled ports stay at their start.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bgc.language.scene import Sampled
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.structures import Status

_PART = 1e-6  # of the scale of a state, for a difference quotient


class Resting:
    """The states of an instance that has been reset, (n,), and what sampled parts hold, (m,)."""

    def __init__(self, instance: Instance, sampled: tuple[Sampled, ...]) -> None:
        self.instance = instance
        model = instance.library.model
        self.own = model.n_state  # n
        self.size = self.own + len(sampled)
        info = model.state
        self.names = [text(info[k].name) for k in range(self.own)] + [s.name for s in sampled]
        self.units = [text(info[k].unit) for k in range(self.own)] + [s.unit for s in sampled]
        self.numbers = [s.number for s in sampled]
        self.places = instance.library.held_inputs[self.numbers]
        self.scale: Array = np.concatenate([instance.scale, np.ones(len(sampled))])
        if sampled:
            self.scale[self.own :] = self._sizes()

    @property
    def state(self) -> Array:
        """The states and the sampled values, a copy."""
        return np.concatenate([self.instance.state, self.instance.input[self.places]])

    def put(self, state: Array) -> None:
        """Set the states and the sampled values."""
        self.instance.state[:] = state[: self.own]
        if self.numbers:
            self.instance.input[self.places] = state[self.own :]

    def rates(self) -> tuple[Status, Array]:
        """The rates of the states, then those of the sampled values."""
        status, rates = self.instance.rhs()
        if status is Status.OK and self.numbers:
            status, updates, periods = self._updates()
            rates = np.concatenate([rates, (updates - self.state[self.own :]) / periods])
        return status, rates

    def slope(self) -> tuple[Status, Array]:
        """Derivatives of the rates; those of and by sampled values are central differences."""
        status, by_state, _ = self.instance.jacobian()
        if status is not Status.OK or not self.numbers:
            return status, by_state
        found = np.zeros((self.size, self.size))
        found[:, self.own :] = self._differences(self.rates, range(self.own, self.size))
        found[self.own :, : self.own] = self._by_state() / self._updates()[2][:, None]
        found[: self.own, : self.own] = by_state
        return (Status.OK if np.isfinite(found).all() else Status.NOT_FINITE), found

    def mass(self) -> tuple[Status, Array]:
        """M of the states, and the identity."""
        status, mass = self.instance.mass()
        found = np.eye(self.size)
        found[: self.own, : self.own] = mass
        return status, found

    def chain_rows(self) -> tuple[Status, Array, Array]:
        """The rows that keep chains closed, and their derivatives."""
        status, values, slopes = self.instance.chain_rows()
        return status, values, np.pad(slopes, ((0, 0), (0, len(self.numbers))))

    def _updates(self) -> tuple[Status, Array, Array]:
        status, values, periods = self.instance.next_held()
        return status, values[self.numbers], periods[self.numbers]

    def _by_state(self) -> Array:
        return self._differences(lambda: self._updates()[:2], range(self.own))

    def _sizes(self) -> Array:
        """Natural sizes: as at the start, or as states move the values by their scales."""
        _, updates, _ = self._updates()
        moved = np.abs(self._by_state() * self.scale[: self.own]).max(axis=1, initial=0.0)
        sizes = np.max([np.abs(updates), np.abs(self.state[self.own :]), moved], axis=0)
        return np.where((sizes > 0) & np.isfinite(sizes), sizes, 1.0)

    def _differences(self, function: Callable[[], tuple[Status, Array]], places: range) -> Array:
        """Central differences of a function by some states; NaN where it is undefined."""
        state = self.state
        columns = []
        for k in places:
            part = _PART * max(float(self.scale[k]), abs(float(state[k])))
            values = []
            for sign in (1, -1):
                moved = state.copy()
                moved[k] += sign * part
                self.put(moved)
                status, value = function()
                values.append(value if status is Status.OK else np.full_like(value, np.nan))
            columns.append((values[0] - values[1]) / (2 * part))
        self.put(state)
        rows = self.size if places.start else len(self.numbers)
        return np.stack(columns, axis=1) if columns else np.zeros((rows, 0))
