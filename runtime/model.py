"""A compiled model, as Python sees it: parameters, simulation, linearisation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from bgc.building.backends import BACKENDS
from bgc.building.built import ENERGY_ACCOUNTS, Built, RunFacts
from bgc.diagnostics.catalogue.arguments import no_duration
from bgc.diagnostics.catalogue.physics import negative_value
from bgc.diagnostics.catalogue.run import step_too_long
from bgc.diagnostics.catalogue.trade import nothing_measured
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.options import Options
from bgc.runtime.linear.state_space import Linearisation, Mode, modes_of, pencil_eigenvalues
from bgc.runtime.results.arrays import Array, Complex
from bgc.runtime.results.result import Result
from bgc.runtime.running.binding import Instance, Library, Status, VarInfo, text
from bgc.runtime.running.failures import RunInterrupted, SimulationError, explain, require
from bgc.runtime.running.parameters import Parameters, Quantity
from bgc.runtime.running.rows import row_times
from bgc.runtime.running.run import (
    Method,
    choose_method,
    open_devices,
    run_watched,
    set_method,
    start,
)

if TYPE_CHECKING:
    from bgc.runtime.results.ensemble import Ensemble
    from bgc.runtime.running.many import Sets


@dataclass(frozen=True, slots=True)
class Variable:
    """A state or an output: its name and its SI unit."""

    name: str
    unit: str


class Model:
    """A loaded model. Runs do not share anything: each starts from the initial state.

    Attributes
    ----------
    parameters
        Run-time parameters by name; set one with `model.parameters["boom.mass"] = "7 t"`.
    states, outputs
        Names and units of the states and of what the scene observes.
    accounts
        Columns of the energy accounts that it observes: `{"residual": "energy.residual"}`.
    facts
        What the scene says about its run.
    warnings
        What the compiler had to say.
    measured
        What rows of a run hold: the observed, without accounts, and what `require` names.
    folder
        Where the files of devices are named from.
    """

    def __init__(
        self,
        built: Built,
        folder: Path = Path(),
        origin: tuple[Path, Options] | None = None,
    ) -> None:
        """Load a build; files of devices are named from `folder`, that of the scene's file.

        `origin` is what was compiled, which `linearise` needs.
        """
        self.folder = folder
        self.origin = origin
        self.library = Library(built.library)
        self._places = built.places
        self.facts: RunFacts = built.facts
        self.warnings: tuple[Diagnostic, ...] = built.warnings
        self.warm = built.warm
        self.parameters = Parameters(self.library, built.facts.folded)
        model = self.library.model
        self.states = tuple(_variable(model.state[k]) for k in range(model.n_state))
        self.measured = tuple(_variable(model.output[k]) for k in range(model.n_output))
        self.accounts = _account_columns(self.facts, self.measured)
        units = {v.name: v.unit for v in self.measured}
        self.outputs = tuple(Variable(c, units.get(c, "J")) for c in self.facts.columns)

    def __repr__(self) -> str:
        return (
            f"<bgc model {self.facts.scene}: {len(self.states)} states, "
            f"{len(self.parameters)} parameters, {len(self.outputs)} outputs>"
        )

    @property
    def solvers(self) -> tuple[str, ...]:
        """Names of the integration methods."""
        return self.library.methods()

    def simulate(
        self,
        duration: float | None = None,
        *,
        every: float | None = None,
        solver: str | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        step: float | None = None,
        settle: float | None = None,
        parameters: Mapping[str, Quantity] | None = None,
        progress: bool = False,
    ) -> Result:
        """Run from the initial state and return the observed values.

        Parameters
        ----------
        duration, every
            End time and interval between rows, s; by default the scene's. Without an interval
            there is a row for each step of a fixed-step method, else there are 1,000 intervals.
            Where the time itself stands in the model, adaptive methods take no step longer than
            five rows, unless the scene says `max_step`.
        solver, rtol, atol, step
            Method and its options; by default the scene's, else `rodas5p`, or `ros34prw` where
            the scene gives a step. `atol` is one for all states, SI; without it each state has
            its own, from its unit's scale.
        settle
            A frequency in Hz: modes faster than that start at rest, stiff springs under their
            loads, and energy is counted from there. By default the scene's, else none.
        parameters
            Values for this run alone, SI numbers or texts with a unit.
        progress
            Show a progress bar on a terminal when the run takes longer than a second.

        Raises
        ------
        SimulationError
            The run could not be completed; its `result` holds the rows up to there.
        RunInterrupted
            Ctrl-C; its `result` holds the rows up to there.
        BgError
            An argument or a parameter is at fault.
        """
        asked = choose_method(self.library, self.facts, solver, rtol, atol, step, settle, BACKENDS)
        method, notices = self._settled(asked, parameters or {})
        width = len(self.measured) + (len(ENERGY_ACCOUNTS) if self.accounts else 0)
        times = self._row_times(duration, every, method, width)
        rows = np.full((len(times), width), np.nan)
        with self.started(
            method.seeing(times, self.facts.timed), bool(self.accounts), parameters
        ) as instance:
            status, done, interrupted = run_watched(instance, times, rows, progress)
        result = self._result(times[:done], rows[:done], method, instance, notices)
        if interrupted or status is Status.INTERRUPTED:
            diagnostic = explain(instance, Status.INTERRUPTED)
            raise RunInterrupted(diagnostic, result.ended("interrupted", diagnostic.message))
        if status is not Status.OK:
            diagnostic = self.explain(instance, status)
            raise SimulationError(diagnostic, result.ended("failed", diagnostic.message))
        return result

    def simulate_many(
        self,
        parameters: Sets,
        duration: float | None = None,
        *,
        every: float | None = None,
        solver: str | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        step: float | None = None,
        settle: float | None = None,
        progress: bool = False,
        vectorised: bool = True,
    ) -> Ensemble:
        """Run many parameter sets at once, and return what they observe as one array.

        Several instances go in one vector register (eight with AVX-512), and batches of these on
        all processors. Instances in a batch take the same steps: under error control the ones
        that the most demanding of them needs. What batches do not serve (`running.many`) is
        run one by one, and `Ensemble.alone` says why. The first call compiles what it needs, once
        and for all.

        Parameters
        ----------
        parameters
            A mapping `{"m": values, "k": values}` with one value for each instance (a number or
            a text with a unit is for all; of a vector, one vector for each), or a list of
            mappings as `simulate` takes them, one for each instance.
        duration, every, solver, rtol, atol, step, settle
            As for `simulate`.
        progress
            Show a progress bar on a terminal when it takes longer than a second.
        vectorised
            Whether to use vector registers; without, instances are run one by one.

        Returns
        -------
        Ensemble
            Also where instances failed: its `status` and `failures` tell which and why.

        Raises
        ------
        EnsembleInterrupted
            Ctrl-C; its `result` holds what was computed up to there.
        BgError
            An argument or a parameter is at fault.
        """
        from bgc.runtime.running.many import parameter_sets, simulate_many

        sets = parameter_sets(parameters)
        asked = choose_method(self.library, self.facts, solver, rtol, atol, step, settle, BACKENDS)
        method, notices = self._settled(asked, {})
        width = len(self.measured) + (len(ENERGY_ACCOUNTS) if self.accounts else 0)
        times = self._row_times(duration, every, method, width * len(sets))
        return simulate_many(
            self, method.seeing(times, self.facts.timed), sets, times, progress, vectorised, notices
        )

    def _row_times(
        self, duration: float | None, every: float | None, method: Method, columns: int
    ) -> Array:
        """Times of the rows of a run: what the caller asks for, else what the scene says."""
        facts = self.facts
        end = facts.duration if duration is None else duration
        if end is None:
            raise BgError([no_duration(facts.scene)])
        interval = facts.every if every is None else every
        return row_times(end, interval, method.step if method.fixed else None, columns)

    @contextmanager
    def started(
        self, method: Method, accounts: bool, parameters: Mapping[str, Quantity] | None = None
    ) -> Iterator[Instance]:
        """An instance at the initial state, its devices open, ready to run with a method."""
        instance = self.parameters.instance(parameters or {})
        require(instance, set_method(instance, method, accounts))
        with open_devices(instance, self.folder):
            asked = dict(self.facts.solver_options).get("settle", 0.0)
            settled = method if method.settle > 0 else replace(method, settle=asked)
            require(instance, start(instance, settled), self._places)
            yield instance

    def explain(self, instance: Instance, status: Status) -> Diagnostic:
        """Say what went wrong with one of this model's instances."""
        return explain(instance, status, self._places)

    def _settled(
        self, method: Method, parameters: Mapping[str, Quantity]
    ) -> tuple[Method, tuple[Diagnostic, ...]]:
        """The method that a run takes; for `solver auto` what `bgc trade` stored, if it did."""
        if not method.measured:
            return method, ()
        from bgc.runtime.trade.auto import stored_method

        stored = stored_method(self, parameters)
        if stored is not None:
            return stored, ()
        return method, (nothing_measured(self.facts.scene, method.name),)

    def _result(
        self,
        times: Array,
        rows: Array,
        method: Method,
        instance: Instance,
        notices: tuple[Diagnostic, ...],
    ) -> Result:
        """Name the columns of the rows, in the scene's order."""
        accounts = (self.accounts.get(account, "") for account in ENERGY_ACCOUNTS)
        names = (*(v.name for v in self.measured), *accounts)
        place = {name: k for k, name in enumerate(names)}
        counts = instance.counts
        notices = (*notices, *self._oddities(instance, counts, method))
        return Result(
            scene=self.facts.scene,
            time=times,
            columns={v.name: rows[:, place[v.name]] for v in self.outputs},
            units={v.name: v.unit for v in self.outputs},
            solver=method.name,
            counts=counts,
            panels=self.facts.panels,
            accounts=self.accounts,
            notices=notices,
        )

    def _oddities(
        self, instance: Instance, counts: Mapping[str, float], method: Method
    ) -> Iterator[Diagnostic]:
        """What a run has to say of its parameters and of its steps: BG460, BG719."""
        for name, what, element in self.facts.passive:
            value = self.parameters.turned_negative(instance, name)
            if value is not None:
                yield negative_value(None, element, what, value, f", as `{name}` is given")
        if counts["coarsest"] > 0:
            state = self.states[int(counts["coarsest_state"])].name
            yield step_too_long(counts["coarsest_at"], state, counts["coarsest"], method.step)

    def initial_state(self, parameters: Mapping[str, Quantity] | None = None) -> Array:
        """The state at time 0, SI, in the order of `states`."""
        return self._instance_at(None, 0.0, parameters).state.copy()

    def rhs(
        self,
        state: Array | None = None,
        time: float = 0.0,
        parameters: Mapping[str, Quantity] | None = None,
    ) -> Array:
        """f of `M y' = f(t, y)`, by default at the initial state."""
        instance = self._instance_at(state, time, parameters)
        status, f = instance.rhs()
        require(instance, status)
        return f

    def jacobian(
        self,
        state: Array | None = None,
        time: float = 0.0,
        parameters: Mapping[str, Quantity] | None = None,
    ) -> Array:
        """df/dy, dense (n, n), by default at the initial state."""
        instance = self._instance_at(state, time, parameters)
        status, dense, _ = instance.jacobian()
        require(instance, status)
        return dense

    def observe(
        self,
        state: Array | None = None,
        time: float = 0.0,
        parameters: Mapping[str, Quantity] | None = None,
    ) -> dict[str, float]:
        """The observed values, by default at the initial state; no energy accounts."""
        instance = self._instance_at(state, time, parameters)
        status, values = instance.outputs()
        require(instance, status)
        pairs = zip(self.measured, values.tolist(), strict=True)
        return {v.name: value for v, value in pairs if v.name in self.facts.columns}

    def linearise(
        self,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        *,
        at: float | Literal["steady"] | None = None,
        state: Array | None = None,
        time: float = 0.0,
        parameters: Mapping[str, Quantity] | None = None,
    ) -> Linearisation:
        """Linearise about an operating point: `dx' = A dx + B du`, `dy = C dx + D du`.

        Derivatives are exact. Usable as `scipy.signal.StateSpace(lin.A, lin.B, lin.C, lin.D)`.

        Parameters
        ----------
        inputs
            What is varied: a source's effort or flow (`"supply.e"`), a parameter (`"F"`), a
            device's channel (`"hand.position[3]"`); by default all channels of the devices.
        outputs
            Names that the scene observes, or any expressions; by default all it observes.
        at
            A time in s up to which to simulate, or `"steady"` for an equilibrium near the
            initial state. By default the initial state itself.
        state, time
            The operating point itself, in the order of `states`. A state that only `inputs` or
            `outputs` bring into play is as at the start.
        parameters
            Values for this call alone, SI numbers or texts with a unit.

        Raises
        ------
        BgError
            An input or output does not exist, or there is no equilibrium.
        """
        from bgc.runtime.linearising.operating import OpenedModel

        if self.origin is None:
            raise ValueError("a model without its source has no inputs: use `eigenvalues`")
        path, options = self.origin
        values = self.parameters.given(parameters or {})
        opened = OpenedModel(path, options, inputs, outputs, values)
        if state is not None:
            names = (variable.name for variable in self.states)
            given = dict(zip(names, np.asarray(state, dtype=float).tolist(), strict=True))
            return opened.linearise(opened.at_state(given, time))
        return opened.linearise(opened.operating_point(at))

    def eigenvalues(
        self,
        state: Array | None = None,
        time: float = 0.0,
        parameters: Mapping[str, Quantity] | None = None,
    ) -> Complex:
        """Eigenvalues of the emitted Jacobian at a state, 1/s, by rising real part."""
        instance = self._instance_at(state, time, parameters)
        status, dense, _ = instance.jacobian()
        require(instance, status)
        status, mass = instance.mass()
        require(instance, status)
        return pencil_eigenvalues(dense, mass)

    def modes(
        self,
        state: Array | None = None,
        time: float = 0.0,
        parameters: Mapping[str, Quantity] | None = None,
    ) -> tuple[Mode, ...]:
        """Modes of the emitted Jacobian at a state, by rising frequency."""
        return modes_of(self.eigenvalues(state, time, parameters))

    def state_at(self, time: float) -> tuple[Array, Array]:
        """The state after a run to a time in s, and the device inputs then; no rows are kept."""
        facts = self.facts
        method, _ = self._settled(choose_method(self.library, facts, None, None, None, None), {})
        times = row_times(time, time, None, len(self.measured))
        rows = np.full((len(times), len(self.measured)), np.nan)
        with self.started(method, False) as instance:
            status, _, _ = run_watched(instance, times, rows, False)
        require(instance, status)
        return instance.state.copy(), instance.input.copy()

    def _instance_at(
        self, state: Array | None, time: float, parameters: Mapping[str, Quantity] | None
    ) -> Instance:
        """Make an instance that stands at a given state, by default the initial one."""
        instance = self.parameters.instance(parameters or {})
        require(instance, instance.reset(time), self._places)
        if state is not None:
            instance.state[:] = state
        return instance


def _variable(info: VarInfo) -> Variable:
    return Variable(text(info.name), text(info.unit))


def _account_columns(facts: RunFacts, observed: tuple[Variable, ...]) -> dict[str, str]:
    """Columns of the energy accounts: those that are no outputs, in the accounts' order."""
    outputs = {variable.name for variable in observed}
    columns = [column for column in facts.columns if column not in outputs]
    return dict(zip(facts.accounts, columns, strict=True))
