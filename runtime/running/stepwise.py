"""A run that a program advances piece by piece, reading it in between."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from types import TracebackType

import numpy as np

from bgc.building.build_result import ENERGY_ACCOUNTS
from bgc.diagnostics.catalogue.arguments import run_is_over
from bgc.diagnostics.catalogue.inputs import function_in_steps, not_an_open_input
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.public import public_class
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.failures import require
from bgc.runtime.running.input_models import compiled_again
from bgc.runtime.running.inputs import Inputs, array_of, drives_of, literal, nested, pair_of
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.quantity import Quantity, in_si
from bgc.runtime.running.run import run_watched
from bgc.runtime.running.run_warnings import run_warnings, start_warnings


@public_class
class Stepping:
    """A run under way, from `model.step()`; use it in a `with` statement, which closes devices.

    Attributes
    ----------
    time
        The time reached, s.
    """

    def __init__(
        self,
        model: LoadedModel,
        method: Solver,
        parameters: Mapping[str, ParameterValue],
        inputs: Sequence[str] = (),
        notices: Sequence[Diagnostic] = (),
    ) -> None:
        """Begin at the start; `inputs` are the parameters that `advance` may change.

        `notices` are warnings about the method.
        """
        self._model = model
        self._inputs = inputs
        self._accounts = np.zeros(len(ENERGY_ACCOUNTS))  # at the last change of an input
        self._stack = ExitStack()
        begun = model.started(method, bool(model.accounts), parameters)
        self._instance: Instance | None = self._stack.enter_context(begun)
        self._time = self._instance.time
        self._method = method
        checked = start_warnings(model, self._instance, method)
        self._warnings = self._notices = (*notices, *checked)
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
        return f"<bgc run of {self._model.facts.name}, {state}>"

    @property
    def time(self) -> float:
        """The time reached, s."""
        self._running()
        return self._time

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """Warnings about the run so far, as those of a `Result`; also when it is over."""
        if self._instance is not None:
            about_run = run_warnings(self._model, self._instance, self._method)
            self._warnings = (*self._notices, *about_run)
        return self._warnings

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

    def advance(
        self, interval: Quantity, inputs: Mapping[str, ParameterValue] | None = None
    ) -> dict[str, float]:
        """Run on by an interval, s or a text such as `"10 ms"`, and return the observed values.

        `inputs` are new values of inputs that `model.step(inputs={..})` gave a value: they hold
        from the present time on.

        Raises
        ------
        BgError
            An input or its value is wrong (BG564); or the run could not be continued, and it is
            over then.
        """
        instance = self._running()
        length = in_si(interval, "interval", "s")
        assert length is not None
        changes = self._checked(inputs or {})
        try:
            if changes:
                self._change(instance, changes)
            self._row = self._read(instance, self._time + length)
            self._time += length
        except BgError:
            self.close()
            raise
        return self.values

    def _checked(self, inputs: Mapping[str, ParameterValue]) -> dict[str, float]:
        """SI values of the inputs that change, by the names of their components."""
        found: dict[str, float] = {}
        for name, value in inputs.items():
            if name not in self._inputs:
                raise BgError([not_an_open_input(name, self._inputs)])
            for parameter, number in _spread(self._model, name, value).items():
                found.update(self._model.parameters.checked(parameter, number))
        return found

    def _change(self, instance: Instance, values: Mapping[str, float]) -> None:
        """Give inputs new values at the present time; the energy accounts go on."""
        if self._model.accounts:
            self._accounts = self._row[len(self._model.measured) :].copy()
        status = self._model.change_parameters(instance, self._time, values)
        require(instance, status, self._model.places)

    def close(self) -> None:
        """End the run and close its devices."""
        _ = self.warnings  # kept: the instance is about to go
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
        require(instance, status, self._model.places)
        row: Array = rows[0]
        if self._model.accounts:
            row[len(self._model.measured) :] += self._accounts
        return row


@dataclass(frozen=True, slots=True)
class Opened:
    """A model whose inputs can be set: their names, and the parameters that give their values."""

    model: LoadedModel
    inputs: tuple[str, ...] = ()
    values: Mapping[str, ParameterValue] = field(default_factory=dict)


def opened(model: LoadedModel, inputs: Inputs) -> Opened:
    """Compile a model whose inputs can be set; pairs are compiled in.

    Raises BG563 for a function, and the errors of `drives_of`.
    """
    if not inputs:
        return Opened(model)
    values: dict[str, ParameterValue] = {}
    drives: dict[str, str] = {}
    for name, value in inputs.items():
        if callable(value):
            raise BgError([function_in_steps(name)])
        pair = pair_of(value)
        if pair is None:
            array = array_of(name, value)
            drives[name] = nested(array, lambda _: "0")
            for item in array.flat:
                literal(name, item, None)  # checks it
            values[name] = value
        else:
            ((_, drives[name]),) = drives_of({name: pair}, np.zeros(1))
    found = compiled_again(model, tuple(drives.items()), open_inputs=tuple(values))
    spread = (_spread(found, name, value) for name, value in values.items())
    return Opened(found, tuple(values), {n: v for each in spread for n, v in each.items()})


def _spread(model: LoadedModel, name: str, value: ParameterValue) -> Mapping[str, ParameterValue]:
    """A value of an input as values of parameters: one number is for all components."""
    parts = [known for known in model.parameters if known.startswith(f"{name}[")]
    one = isinstance(value, str) or np.ndim(value) == 0
    return dict.fromkeys(parts, value) if one and parts else {name: value}
