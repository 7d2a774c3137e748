"""A run that is advanced piece by piece, and whose parameters may change while it runs."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.view import parameter_not_applied
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.solver import Solver
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.device_drivers import NO_CHOICES, Choices
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.port_bounds import require_ports
from bgc.runtime.running.structures import Status
from bgc.runtime.view.hands import Hands


class LiveRun:
    """One run of a model at a time, from its initial state; not safe for several threads.

    Attributes
    ----------
    time
        The time of the last row, s; after a failure that of the last good state.
    hands
        The devices that a page holds. A reset gives them back to the scene.
    given
        Parameter values that were set, SI; they hold for this run and after each reset.
    """

    def __init__(
        self,
        model: LoadedModel,
        method: Solver,
        parameters: Mapping[str, ParameterValue],
        devices: Choices = NO_CHOICES,
    ) -> None:
        """Prepare a run, with other `devices` than the scene's if given; `reset` starts it."""
        self.model = model
        self.method = method
        self.given: dict[str, float] = model.parameters.given(parameters)
        self.time = 0.0
        self._devices = devices
        self.hands = Hands(model, devices)
        self._open = ExitStack()
        self._instance: Instance | None = None

    def close(self) -> None:
        """End the run: the forces of its devices become zero."""
        self._instance = None
        self._open.close()

    def reset(self) -> Array:
        """Start from the initial state, and return its row, (width,).

        Raises BgError where a parameter, a device or the start is at fault; there is no run then.
        """
        self.close()
        self._open = ExitStack()
        accounts = bool(self.model.accounts)
        started = self.model.started(self.method, accounts, self.given, devices=self._devices)
        self._instance = self._open.enter_context(started)
        self.hands.forget()
        self.time = 0.0
        rows, fault = self.advance(np.zeros(1))
        if fault is not None:
            raise BgError([fault])
        first: Array = rows[0]
        return first

    def advance(self, times: Array) -> tuple[Array, Diagnostic | None]:
        """Integrate to all times, s, and return their rows.

        After a failure the rows up to there are returned with the reason. A call of `stop` in
        another thread ends it early, without a reason.
        """
        instance = self._running()
        rows = np.full((len(times), self.model.row_width), np.nan)
        status, done = instance.run(times, rows)
        if done:
            self.time = float(times[done - 1])
        if status is not Status.OK:
            # Its last good state lies behind the last row: the next one follows it.
            self.time = max(self.time, instance.time)
        failed = status not in (Status.OK, Status.INTERRUPTED)
        return rows[:done], self.model.explain(instance, status) if failed else None

    def snapshot(self) -> tuple[Array, Array]:
        """The state at the present time, and the inputs."""
        instance = self._running()
        state = instance.state_at(self.time)
        return (state if np.isfinite(state).all() else instance.state), instance.input

    @property
    def varied(self) -> dict[str, float]:
        """The present values, SI, of the parameters that a start at rest has found."""
        rest = self.model.facts.rest_for(self.method.start)
        if rest is None:
            return {}
        index = {name: k for k, name in enumerate(self.model.parameters)}
        return {name: self._running().parameter(index[name]) for name in rest.vary}

    def hand(self, device: str, pose: Mapping[str, Any]) -> None:
        """Hand a pose of the page to a device: it holds from the next sample.

        Raises BgError BG756 where the page may not steer it.
        """
        self.hands.feed(self._running(), device, pose)

    def leave(self, device: str) -> None:
        """Give a device back to the driver of the scene. Raises BgError where that fails."""
        self.hands.leave(self._running(), device)

    def stop(self) -> None:
        """End an `advance` in another thread after its present step."""
        if (instance := self._instance) is not None:
            instance.stop()

    def values(self) -> list[float]:
        """The values of all parameters, SI, in the order of the model's."""
        parameters = self.model.parameters
        instance = self._instance or parameters.instance(self.given)
        return parameters.values_in(instance)

    def set_parameter(self, name: str, value: ParameterValue) -> None:
        """Give a parameter a value, now and for later runs. The state stays.

        A parameter that only the initial state reads takes effect at the next reset. Values that
        sampled parts hold stay too; the energy accounts start again at zero.

        Raises BgError if there is no such parameter, if the value is out of range (the run goes
        on with the earlier value), or if the run cannot go on with it (BG755, likewise).
        """
        changes = self.model.parameters.checked(name, value)
        if self._instance is not None:
            self._change(self._instance, changes)
        self.given.update(changes)

    def _change(self, instance: Instance, values: Mapping[str, float]) -> None:
        """Set parameters in the middle of a run: reset at its time, then restore its state."""
        saved = instance.save()
        status = self.model.change_parameters(instance, self.time, values)
        if status is not Status.OK:
            reason = self.model.explain(instance, status)
            instance.restore(saved)
            raise BgError([parameter_not_applied(", ".join(values), reason.message)])
        try:
            require_ports(instance, self.model.facts, self.model.places)
        except BgError:
            instance.restore(saved)
            raise

    def _running(self) -> Instance:
        if self._instance is None:
            raise RuntimeError("the run has no initial state: call `reset`")
        return self._instance
