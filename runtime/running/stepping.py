"""A run that a program advances piece by piece, reading it in between."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from types import TracebackType

import numpy as np

from bgc.diagnostics.catalogue.arguments import run_is_over
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.doors import with_doors
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.quantity import Quantity, in_si
from bgc.runtime.running.run import Method, run_watched
from bgc.runtime.running.structures import Status


@with_doors
class Stepping:
    """A run under way, from `model.step()`; use it in a `with` statement, which closes devices.

    Attributes
    ----------
    time
        The time reached, s.
    """

    def __init__(
        self, model: LoadedModel, method: Method, parameters: Mapping[str, ParameterValue]
    ) -> None:
        self._model = model
        self._stack = ExitStack()
        begun = model.started(method, bool(model.accounts), parameters)
        self._instance: Instance | None = self._stack.enter_context(begun)
        self._time = self._instance.time
        self._row = self._read(self._instance, self._time)

    def __enter__(self) -> Stepping:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "over" if self._instance is None else f"at {self.time:g} s"
        return f"<bgc run of {self._model.facts.scene}, {state}>"

    @property
    def time(self) -> float:
        """The time reached, s."""
        self._running()
        return self._time

    @property
    def state(self) -> Array:
        """The state at that time, (n,) SI, in the order of `model.states`; a copy."""
        instance = self._running()
        at_end = instance.time == self._time
        return instance.state.copy() if at_end else instance.state_at(self._time)

    @property
    def values(self) -> dict[str, float]:
        """The observed values at the time reached, in the units of `model.outputs`."""
        names = (variable.name for variable in self._model.outputs)
        return dict(zip(names, self._model.selection().of(self._row).tolist(), strict=True))

    def __getitem__(self, name: str) -> float:
        return self.values[name]

    def advance(self, interval: Quantity) -> dict[str, float]:
        """Run on by an interval, s or a text such as `"10 ms"`, and return the observed values.

        Raises
        ------
        BgError
            The run could not be continued; it is over then.
        """
        instance = self._running()
        length = in_si(interval, "interval", "s")
        assert length is not None
        try:
            self._row = self._read(instance, self._time + length)
            self._time += length
        except BgError:
            self.close()
            raise
        return self.values

    def close(self) -> None:
        """End the run and close its devices."""
        self._instance = None
        self._stack.close()

    def _running(self) -> Instance:
        if self._instance is None:
            raise BgError([run_is_over()])
        return self._instance

    def _read(self, instance: Instance, time: float) -> Array:
        """Run to a time, and return the row there."""
        times = np.array([time])
        rows = np.full((1, self._model.row_width), np.nan)
        status, _, interrupted = run_watched(instance, times, rows, progress=False)
        if interrupted:
            raise KeyboardInterrupt
        if status is not Status.OK:
            raise BgError([self._model.explain(instance, status)])
        row: Array = rows[0]
        return row
