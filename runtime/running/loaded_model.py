"""A compiled model in memory: library, parameters, facts of the scene, initial state."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from bgc.building.build_result import ENERGY_ACCOUNTS, Built, Places, RunFacts
from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.arguments import wrong_state
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.methods import METHODS
from bgc.language.solver import Solver
from bgc.options import Options
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.rest_report import AtRest
from bgc.runtime.running.binding import Instance, Library, text
from bgc.runtime.running.device_drivers import NO_CHOICES, Choices, open_devices
from bgc.runtime.running.failures import explain, require
from bgc.runtime.running.parameters import Parameters, ParameterValue
from bgc.runtime.running.port_bounds import require_ports
from bgc.runtime.running.rest import go_to_rest
from bgc.runtime.running.run import set_method, start
from bgc.runtime.running.structures import Status, VarInfo
from bgc.values.shown_units import Shown, shown_by


@dataclass(frozen=True, slots=True)
class Variable:
    """A state or an output: its name and its SI unit.

    `written` is the unit in which tables and plots show it, None for the SI unit.
    """

    name: str
    unit: str
    written: Shown | None = None

    @property
    def shown(self) -> Shown:
        """The unit in which its values are shown."""
        return self.written or Shown(self.unit)


@dataclass(frozen=True, slots=True)
class Selection:
    """The places of the outputs in a row that C writes, and the units of the numbers there.

    An output is the number at its place divided by its factor. C writes energy accounts in J and
    all other columns in their own units, so that only accounts have a factor other than 1.
    """

    places: tuple[int, ...]
    factors: tuple[float, ...]

    def of(self, rows: Array) -> Array:
        """The outputs, (.., outputs), of rows, (.., width)."""
        if self.places == tuple(range(rows.shape[-1])) and not self._converts:
            return rows
        found = rows[..., list(self.places)]
        return found / np.array(self.factors) if self._converts else found

    def column(self, rows: Array, output: int) -> Array:
        """One output of rows, (rows, width); a view of them where it needs no conversion."""
        found = rows[:, self.places[output]]
        return found if self.factors[output] == 1.0 else found / self.factors[output]

    def fill(self, rows: Array, outputs: Array) -> None:
        """Write outputs back to their places in rows."""
        rows[..., list(self.places)] = outputs * np.array(self.factors)

    @property
    def _converts(self) -> bool:
        return any(factor != 1.0 for factor in self.factors)


class LoadedModel:
    """A loaded model. Runs share nothing: each starts from the initial state.

    Attributes
    ----------
    parameters
        Run-time parameters by name; set one with `model.parameters["boom.mass"] = "7 t"`.
    states, outputs
        Names and units of the states and of the quantities that the scene observes.
    accounts
        Columns of the energy accounts that it observes: `{"residual": "energy.residual"}`; the
        first of each.
    facts
        The scene's statements about its run.
    warnings
        Warnings of the compiler.
    measured
        Columns of the rows that C writes, without accounts: the observed quantities and those
        that `require` names.
    folder
        The scene file's folder, to which the paths of device files are relative.
    origin
        The compiled file and its options; None for a model without a source.
    places
        The places in the source that a run may report.
    warm
        Whether the model was loaded from the cache, with nothing compiled.
    """

    def __init__(
        self,
        built: Built,
        folder: Path = Path(),
        origin: tuple[Path, Options] | None = None,
    ) -> None:
        self.folder = folder
        self.origin = origin
        self.library = Library(built.library, built.facts.fmus)
        self.places: Places = built.places
        self.facts: RunFacts = built.facts
        self.warnings: tuple[Diagnostic, ...] = built.warnings
        self.warm = built.warm
        self.parameters = Parameters(
            self.library, built.facts.folded, shown_by(built.facts.shown.parameters)
        )
        model = self.library.model
        states, outputs = shown_by(self.facts.shown.states), shown_by(self.facts.shown.outputs)
        self.states = tuple(_variable(model.state[k], states) for k in range(model.n_state))
        self.measured = tuple(_variable(model.output[k], outputs) for k in range(model.n_output))
        self.accounts: dict[str, str] = {}
        for found in self.facts.accounts:
            self.accounts.setdefault(found.account, found.column)
        known = {variable.name: variable for variable in self.measured}
        units = {found.column: found.unit for found in self.facts.accounts}
        self.outputs = tuple(
            known.get(column) or Variable(column, units[column]) for column in self.facts.columns
        )

    def __repr__(self) -> str:
        return (
            f"<bgc model {self.facts.name}: {counted(len(self.states), 'state')}, "
            f"{counted(len(self.parameters), 'parameter')}, "
            f"{counted(len(self.outputs), 'output')}>"
        )

    def source_for(self, what: str) -> tuple[Path, Options]:
        """The compiled file and its options, for `what`, which a model without them does not have.

        Raises ValueError for such a model.
        """
        if self.origin is None:
            raise ValueError(f"a model without its source has no {what}")
        return self.origin

    @property
    def solvers(self) -> tuple[str, ...]:
        """Names of the integration methods."""
        return tuple(METHODS)

    @property
    def row_width(self) -> int:
        """Numbers in a row of a run: the measured columns, then the energy accounts if any."""
        return len(self.measured) + (len(ENERGY_ACCOUNTS) if self.accounts else 0)

    def selection(self) -> Selection:
        """The outputs in a row of a run, whose energy accounts are in J."""
        count = len(self.measured)
        place = {v.name: (k, 1.0) for k, v in enumerate(self.measured)}
        for found in self.facts.accounts:
            index = count + ENERGY_ACCOUNTS.index(found.account)
            place[found.column] = (index, found.factor)
        chosen = [place[variable.name] for variable in self.outputs]
        return Selection(tuple(k for k, _ in chosen), tuple(factor for _, factor in chosen))

    @contextmanager
    def started(
        self,
        method: Solver,
        accounts: bool,
        parameters: Mapping[str, ParameterValue] | None = None,
        noted: Callable[[AtRest], None] | None = None,
        devices: Choices = NO_CHOICES,
        errors: bool = False,
    ) -> Iterator[Instance]:
        """Yield an instance at the initial state, its devices open, ready to run with a method.

        `accounts` says whether its rows end with the energy accounts. The scene's `settle` holds
        unless the method has its own. `noted` is called with a start at rest, if it is one.
        `devices` override drivers of the scene. With `errors` rows have those of the outputs at
        their end.
        """
        instance = self.parameters.instance(parameters or {})
        require(instance, set_method(instance, method, accounts, errors))
        with open_devices(instance, self.folder, devices):
            status, at_rest = start(instance, method, self.facts)
            require(instance, status, self.places)
            require_ports(instance, self.facts, self.places)
            if at_rest is not None and noted is not None:
                noted(at_rest)
            yield instance

    def instance_at(
        self,
        state: Array | None,
        time: float,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> Instance:
        """Make an instance at a time and a state, (n,) SI; by default the initial state."""
        instance = self.parameters.instance(parameters or {})
        checked = state is None and self.facts.rest is None
        require(instance, instance.reset(time, checked=checked), self.places)
        if state is not None:
            if np.shape(state) != instance.state.shape:
                raise BgError([wrong_state(np.shape(state), len(self.states))])
            instance.state[:] = state
        elif self.facts.rest is not None:
            status, _ = go_to_rest(instance, self.facts.rest)
            require(instance, status, self.places)
        return instance

    def change_parameters(
        self, instance: Instance, time: float, values: Mapping[str, float]
    ) -> Status:
        """Set parameters to `values`, SI, at a time that an instance has just reached; restart it.

        The state stays, and the energy accounts start again at zero. Where the run cannot go on,
        the status says why and the caller restores what it saved.
        """
        state = instance.state_at(time)
        if not np.isfinite(state).all():
            state, time = instance.state.copy(), instance.time
        inputs = instance.input.copy()
        self.parameters.set_in(instance, values)
        status = instance.reset(time, checked=False)
        if status is Status.OK:
            instance.state[:] = state
            instance.input[:] = inputs
            status = instance.restart()
        return status

    def explain(self, instance: Instance, status: Status) -> Diagnostic:
        """Explain the failure of one of this model's instances."""
        return explain(instance, status, self.places)


def _variable(info: VarInfo, shown: Mapping[str, Shown]) -> Variable:
    name = text(info.name)
    return Variable(name, text(info.unit), shown.get(name))
