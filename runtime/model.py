"""A compiled model as a Python user holds it: parameters, simulation, linearisation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from bgc.diagnostics.doors import with_doors
from bgc.runtime.linear.state_space import Linearisation, Mode, modes_of, pencil_eigenvalues
from bgc.runtime.results.arrays import Array, Complex
from bgc.runtime.results.result import Result
from bgc.runtime.running.compiling import load_as
from bgc.runtime.running.devices import read_choices
from bgc.runtime.running.failures import require
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.quantity import Quantity, in_si
from bgc.runtime.running.simulate import method_of, simulate, state_after, times_of

if TYPE_CHECKING:
    from bgc.driver import Stage, Stages
    from bgc.runtime.documents.views import Drawing, Equations, Tables
    from bgc.runtime.realtime.loop import Realtime
    from bgc.runtime.realtime.options import RealtimeOptions
    from bgc.runtime.realtime.python_device import PythonDevice
    from bgc.runtime.results.ensemble import Ensemble
    from bgc.runtime.results.study import Study
    from bgc.runtime.running.cases import Sets
    from bgc.runtime.running.stepping import Stepping
    from bgc.runtime.studies.estimate import Estimate
    from bgc.runtime.studies.motion import Motion
    from bgc.runtime.studies.operability_result import Operability
    from bgc.runtime.studies.sweep import Vary
    from bgc.runtime.web.export import LivePage
    from bgc.symbolic.model import SymbolicModel


@with_doors
class Model(LoadedModel):
    """A compiled model: set its parameters, simulate it, linearise it.

    Runs share nothing: each starts from the initial state. Attributes are those of `LoadedModel`:
    `parameters`, `states`, `outputs`, `accounts`, `facts`, `warnings`.
    """

    def simulate(
        self,
        duration: Quantity | None = None,
        *,
        every: Quantity | None = None,
        solver: str | None = None,
        rtol: Quantity | None = None,
        atol: Quantity | None = None,
        step: Quantity | None = None,
        max_step: Quantity | None = None,
        substeps: int | None = None,
        settle: Quantity | None = None,
        start: Literal["rest", "given"] | None = None,
        parameters: Mapping[str, ParameterValue] | None = None,
        progress: bool = False,
        shapes: bool = False,
        devices: Mapping[str, str] | None = None,
    ) -> Result:
        """Run from the initial state and return the observed values.

        Parameters
        ----------
        duration, every
            End time and interval between rows, s or texts such as `"2 s"`; by default the
            scene's. Without an interval there is a row for each step of a fixed-step method, else
            there are 1,000 intervals. If the equations depend explicitly on time, adaptive
            methods take no step longer than five row intervals, unless `max_step` is given.
        solver, rtol, atol, step, max_step
            Method and its options; by default the scene's, else `ros34prw` where the scene gives a
            step, `switching` where explicit steps may cost less, or `rodas5p`. `atol` applies to
            all states, SI; without it each state has its own, from the scale of its unit.
            `max_step` limits the steps of an adaptive method, s. An option that the method does
            not have is an error.
        substeps
            Most parts of a fixed step, which is divided where its error is above `rtol` (by
            default 1e-3) and `atol`; by default the scene's, else 1.
        settle
            A frequency in Hz: faster modes start at rest, with stiff springs under their loads,
            and energy is counted from that state. By default the scene's, else none.
        start
            "rest": the nearest state at which all rates vanish (BG760 if there is none);
            `Result.at_rest` has what was moved. "given": the initial values. By default the
            scene's start.
        parameters
            Values for this run alone, SI numbers or texts with a unit.
        progress
            Whether to show a progress bar on a terminal when the run takes longer than a second.
        shapes
            Whether to record the shapes of all parts with their poses at each row, in
            `result.shapes`. They may need states that the scene does not, so the model is compiled
            once more, without a change to this one.
        devices
            Drivers in place of the scene's: `{"hand": "./mine.so"}`, `{"hand": "motion.csv"}` or
            `{"hand": "udp(port=5005)"}`.

        Raises
        ------
        SimulationError
            The run could not be completed; its `result` holds the rows up to there.
        RunInterrupted
            Ctrl-C; its `result` holds the rows up to there.
        BgError
            An argument or a parameter is at fault.
        """
        values = parameters or {}
        if shapes and not self.facts.shapes:
            model = self._with_shapes()
            values = {**self.parameters.given({}), **values}
            return model.simulate(
                duration,
                every=every,
                solver=solver,
                rtol=rtol,
                atol=atol,
                step=step,
                max_step=max_step,
                substeps=substeps,
                settle=settle,
                parameters=values,
                progress=progress,
                devices=devices,
            )
        options = _options(rtol, atol, step, max_step, substeps, settle)
        method, notices = method_of(self, solver, options, values)
        method = method.started(start)
        times = times_of(self, method, _seconds(duration), _seconds(every, "every"))
        choices = read_choices(devices or {})
        return simulate(self, method, times, values, progress, notices, choices)

    def _with_shapes(self) -> Model:
        """Compile the same model with its shapes, or load it from the cache."""
        if self.origin is None:
            raise ValueError("a model without its source has no shapes: compile it with `shapes`")
        path, options = self.origin
        return load_as(Model, path, replace(options, shapes=True), {})

    def realtime(
        self,
        duration: Quantity | None = None,
        *,
        devices: Mapping[str, str | PythonDevice] | None = None,
        options: RealtimeOptions | None = None,
        record: str | Path | None = None,
        keep: int = 60_000,
        solver: str | None = None,
        rtol: Quantity | None = None,
        atol: Quantity | None = None,
        step: Quantity | None = None,
        max_step: Quantity | None = None,
        substeps: int | None = None,
        settle: Quantity | None = None,
        start: Literal["rest", "given"] | None = None,
        parameters: Mapping[str, ParameterValue] | None = None,
        on_records: Callable[[Array], None] | None = None,
    ) -> Realtime:
        """Make a servo loop: the model in step with the clock, with its devices.

        A context manager starts it and stops it; see `bgc.runtime.realtime.loop.Realtime`.

        Parameters
        ----------
        duration
            Simulated time, s; by default the loop runs until it is stopped.
        devices
            Drivers in place of the scene's, as for `simulate`; or objects with `read()` and
            `write(force, torque, gripper_force)`, which a Python thread calls 200 times a second,
            off the loop.
        options
            Limits of force, rate and power, ramp, dead man's button, watchdog; see
            `bgc.runtime.realtime.options.RealtimeOptions`.
        record
            A `.csv` file for the motion of the device, which `trace` replays with the same bits.
        keep
            Number of samples kept in `rows`.
        solver, rtol, atol, step, max_step, substeps, settle, start, parameters
            As for `simulate`. With an adaptive method `step` is its first step; the period is the
            scene's. A step never reaches beyond the next sample.
        on_records
            Called off the loop with new records, (n, width), about every 10 ms.

        Raises
        ------
        BgError
            An argument, a parameter or a device is at fault.

        Examples
        --------
        >>> with model.realtime(devices={"hand": "pointer"}) as loop:  # doctest: +SKIP
        ...     loop.pointer(position=[0.01, 0, 0])
        ...     loop.step()
        """
        # Only this needs the loop, which loads its own shared object.
        from bgc.runtime.realtime.loop import Realtime
        from bgc.runtime.realtime.options import RealtimeOptions

        given = _options(rtol, atol, step, max_step, substeps, settle)
        method, notices = method_of(self, solver, given, parameters or {})
        loop = Realtime(
            self,
            method.started(start),
            options or RealtimeOptions(),
            duration=_seconds(duration),
            devices=devices,
            record=None if record is None else Path(record),
            keep=keep,
            parameters=parameters,
            on_records=on_records,
        )
        loop.warnings += notices
        return loop

    def simulate_many(
        self,
        parameters: Sets,
        duration: Quantity | None = None,
        *,
        every: Quantity | None = None,
        solver: str | None = None,
        rtol: Quantity | None = None,
        atol: Quantity | None = None,
        step: Quantity | None = None,
        max_step: Quantity | None = None,
        substeps: int | None = None,
        settle: Quantity | None = None,
        start: Literal["rest", "given"] | None = None,
        progress: bool = False,
        vectorised: bool = True,
        resume: bool = False,
    ) -> Ensemble:
        """Run many parameter sets at once, and return their observed values as one array.

        Several instances share a vector register (eight with AVX-512), and batches of them run on
        all processors. Instances in a batch take the same steps: under error control those of the
        most demanding instance. Models and methods that batches do not support (see
        `running.many`) are run one by one; `Ensemble.alone` has the reason. The first call
        compiles the batch code, which is cached.

        Parameters
        ----------
        parameters
            A mapping `{"m": values, "k": values}` with one value for each instance (a number or
            a text with a unit is for all; of a vector, one vector for each), or a list of
            mappings as for `simulate`, one for each instance.
        duration, every, solver, rtol, atol, step, max_step, substeps, settle, start
            As for `simulate`.
        progress
            Whether to show a progress bar on a terminal when it takes longer than a second.
        vectorised
            Whether to use vector registers; otherwise instances are run one by one.
        resume
            Whether to keep what is done if Ctrl-C ends the call, for the next equal one.

        Returns
        -------
        Ensemble
            Also if instances failed: `status` and `failures` name them with their errors.

        Raises
        ------
        EnsembleInterrupted
            Ctrl-C; its `result` holds the rows up to there.
        BgError
            An argument or a parameter is at fault.
        """
        # Loading this would take 6 % of a warm `bgc run`, which has no ensemble.
        from bgc.runtime.running.cases import checked_cases
        from bgc.runtime.running.many import plan_many, simulate_many

        cases = checked_cases(parameters, self.parameters)
        options = _options(rtol, atol, step, max_step, substeps, settle)
        method, notices = method_of(self, solver, options)
        method = method.started(start)
        times = times_of(self, method, _seconds(duration), _seconds(every, "every"), len(cases))
        plan = plan_many(self, method, cases, times, vectorised)
        return simulate_many(plan, progress, notices, resume)

    def sweep(
        self,
        vary: Vary = (),
        observe: Sequence[str] = (),
        duration: Quantity | None = None,
        *,
        sample: int | None = None,
        design: str = "latin",
        seed: int = 0,
        cases: str | Path | None = None,
        scheduler: str | None = None,
        store: str | Path | None = None,
        progress: bool = False,
        resume: bool = False,
        every: Quantity | None = None,
        solver: str | None = None,
        rtol: Quantity | None = None,
        atol: Quantity | None = None,
        step: Quantity | None = None,
        max_step: Quantity | None = None,
        substeps: int | None = None,
        settle: Quantity | None = None,
        start: Literal["rest", "given"] | None = None,
    ) -> Ensemble | Study:
        """Run the model over values of its parameters, as `bgc sweep` does.

        Parameters
        ----------
        vary
            `{"m": "1..4 kg:4", "k": "1..1000 N/m:4 log", "c": [1, 2, "5 N*s/m"]}`, or texts
            `["m=1..4 kg:4"]`. By default all combinations of the values are run.
        observe
            Observables such as `max(tension)` or `quantile(tension, 0.95) from 20 s`. Each run
            leaves these numbers and no rows, so that memory does not grow with the rows.
        sample, design, seed
            Number of points to take from the ranges: a `latin` hypercube, a `sobol` sequence, or
            the sample of Sobol indices, `saltelli`, of (parameters + 2) times as many runs.
        cases
            A CSV file with a column for each parameter, `mass [t]`; each case is combined with all
            combinations of `vary`.
        scheduler
            Address of a Dask scheduler, `tcp://10.0.0.5:8786`, whose workers run the cases.
        store
            Directory for the results as a Zarr group, written while the sweep goes on; a sweep that
            was interrupted or killed goes on from there.
        resume
            As for `simulate_many`.
        duration, every, solver, rtol, atol, step, max_step, substeps, settle, start
            As for `simulate`.

        Returns
        -------
        Study
            With observables: one row for each run.
        Ensemble
            Without: all rows of all runs.

        Raises
        ------
        StudyInterrupted, EnsembleInterrupted
            Ctrl-C; `result` holds what was done.
        BgError
            An argument or a parameter is at fault.
        """
        # As for `simulate_many`.
        from bgc.runtime.running.batches import rows_at_once
        from bgc.runtime.studies.sweep import Design, observables_of, sweep

        chosen = Design(vary, sample, design, seed, cases)
        observables = observables_of(self, observe)
        options = _options(rtol, atol, step, max_step, substeps, settle)
        method, notices = method_of(self, solver, options)
        method = method.started(start)
        values = chosen.values(self.parameters)
        count = len(next(iter(values.values()), ()))
        at_once = rows_at_once(count) if observables else count
        times = times_of(self, method, _seconds(duration), _seconds(every, "every"), at_once)
        return sweep(
            self, chosen, method, times, observables, progress=progress, notices=notices,
            resume=resume, scheduler=scheduler, store=store,
        )  # fmt: skip

    def fit(
        self,
        motion: Motion,
        vary: Vary,
        *,
        match: Mapping[str, str] | None = None,
        columns: Sequence[str] = (),
        noise: Mapping[str, Quantity] | None = None,
        loss: str = "linear",
        starts: int = 1,
        confidence: float = 0.95,
        solver: str | None = None,
        rtol: Quantity | None = None,
        atol: Quantity | None = None,
        step: Quantity | None = None,
        max_step: Quantity | None = None,
        substeps: int | None = None,
        settle: Quantity | None = None,
        start: Literal["rest", "given"] | None = None,
    ) -> Estimate:
        """Estimate parameters from a recorded motion, as `bgc fit` does.

        Minimises the sum of squared residuals in units of their noise within the bounds, by SciPy's
        `least_squares`. Each point and its finite differences run as one batch.

        Parameters
        ----------
        motion
            A CSV file with the columns `time` and observed names, `x [mm]`; a result; or columns
            by name, SI. The model runs to the recorded times.
        vary
            Parameters with their bounds, `{"k": "1..1000 N/m"}` or `["k=1..1000 N/m"]`. The
            iteration starts at the present values, or in the middle where they are outside.
        match, columns
            Observed names of recorded columns, `{"x": "position"}`; the observed columns to fit,
            by default all that were recorded.
        noise
            Standard deviations of columns; those of the residuals by default, to which the weights
            of the columns are adapted.
        loss
            "linear": least squares. "soft_l1", "huber" and "cauchy" give outliers beyond the noise
            less weight.
        starts
            Number of points within the bounds, run as one batch, among which to start.
        confidence
            Probability of the intervals. They are those of the linearised problem with independent
            normal noise.
        solver, rtol, atol, step, max_step, substeps, settle, start
            As for `simulate`.

        Raises
        ------
        BgError
            The data or the bounds are at fault (BG788, BG479), or the run at the start fails.
        """
        # As for `simulate_many`.
        from bgc.runtime.studies.bounds import read_bounds, read_noise
        from bgc.runtime.studies.fit import FitOptions, fit
        from bgc.runtime.studies.motion import read_motion

        options = _options(rtol, atol, step, max_step, substeps, settle)
        method, _ = method_of(self, solver, options)
        recorded = read_motion(motion, self, match or {}, columns)
        bounds = read_bounds(vary, self.parameters)
        known = read_noise(noise or {}, recorded.names, self.outputs)
        return fit(
            self, method.started(start), recorded, bounds,
            FitOptions(loss, known, starts, confidence),
        )  # fmt: skip

    def operability(
        self,
        height: str,
        period: str,
        criteria: Sequence[str] = (),
        duration: Quantity | None = None,
        *,
        heading: str | None = None,
        seed: str | None = None,
        judge: str = "gumbel",
        exposure: Quantity | None = None,
        scheduler: str | None = None,
        store: str | Path | None = None,
        progress: bool = False,
        resume: bool = False,
        every: Quantity | None = None,
        solver: str | None = None,
        rtol: Quantity | None = None,
        atol: Quantity | None = None,
        step: Quantity | None = None,
        max_step: Quantity | None = None,
        substeps: int | None = None,
        settle: Quantity | None = None,
        start: Literal["rest", "given"] | None = None,
    ) -> Operability:
        """Find the sea states in which criteria hold, as `bgc operability` does.

        Parameters
        ----------
        height, period, heading, seed
            Parameters of the sea with their values, `"vessel.sea.height=1..4 m:7"`.
        criteria
            Demands on observables, `"max(tension) < 300 kN"`; by default the limits of the scene,
            `require tension < 300 kN;`.
        judge, exposure
            The value of a criterion from those of the seeds. "gumbel": of extremes (max, min, peak,
            range) the most probable one, for the time of `exposure` (s) instead of the simulated
            one; of other observables the mean. "worst": that of the worst seed.
        scheduler, store, resume
            As for `sweep`.
        duration, every, solver, rtol, atol, step, max_step, substeps, settle, start
            As for `simulate`.

        Raises
        ------
        StudyInterrupted
            Ctrl-C.
        BgError
            An argument or a parameter is at fault.
        """
        # As for `simulate_many`.
        from bgc.runtime.running.batches import rows_at_once
        from bgc.runtime.studies.operability import SeaStates, operability, read_criteria

        read = read_criteria(self, criteria)
        options = _options(rtol, atol, step, max_step, substeps, settle)
        method, notices = method_of(self, solver, options)
        method = method.started(start)
        at_once = rows_at_once(1_000_000)
        times = times_of(self, method, _seconds(duration), _seconds(every, "every"), at_once)
        return operability(
            self, SeaStates(height, period, heading, seed), read, method, times, judge=judge,
            exposure=_seconds(exposure, "exposure"), progress=progress, notices=notices,
            resume=resume, scheduler=scheduler, store=store,
        )  # fmt: skip

    def initial_state(self, parameters: Mapping[str, ParameterValue] | None = None) -> Array:
        """The state at time 0, SI, in the order of `states`."""
        return self.instance_at(None, 0.0, parameters).state.copy()

    def rhs(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> Array:
        """f of `M y' = f(t, y)`, by default at the initial state."""
        instance = self.instance_at(state, _seconds(time, "time") or 0.0, parameters)
        status, f = instance.rhs()
        require(instance, status)
        return f

    def jacobian(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> Array:
        """df/dy, dense (n, n), by default at the initial state."""
        instance = self.instance_at(state, _seconds(time, "time") or 0.0, parameters)
        status, dense, _ = instance.jacobian()
        require(instance, status)
        return dense

    def observe(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> dict[str, float]:
        """The observed values, by default at the initial state; no energy accounts."""
        instance = self.instance_at(state, _seconds(time, "time") or 0.0, parameters)
        status, values = instance.outputs()
        require(instance, status)
        pairs = zip(self.measured, values.tolist(), strict=True)
        return {v.name: value for v, value in pairs if v.name in self.facts.columns}

    def linearise(
        self,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        *,
        at: Quantity | Literal["steady"] | None = None,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> Linearisation:
        """Linearise about an operating point: `dx' = A dx + B du`, `dy = C dx + D du`.

        Derivatives are exact. Usable as `scipy.signal.StateSpace(lin.A, lin.B, lin.C, lin.D)`.

        Parameters
        ----------
        inputs
            The inputs: a source's effort or flow (`"supply.e"`), a parameter (`"F"`), an input
            of a model (`"slew"`), a device's channel (`"hand.position[3]"`); by default all
            channels of the devices.
        outputs
            Names that the scene observes, or any expressions; by default all it observes.
        at
            A time in s up to which to simulate, or `"steady"` for an equilibrium near the
            initial state. By default the initial state itself.
        state, time
            The operating point itself, in the order of `states`. A state that only `inputs` or
            `outputs` need keeps its initial value.
        parameters
            Values for this call alone, SI numbers or texts with a unit.

        Raises
        ------
        BgError
            An input or output does not exist, or there is no equilibrium.
        """
        # Loads the compiler, which takes longer than most runs; they do without it.
        from bgc.runtime.linearising.operating import OpenedModel

        if self.origin is None:
            raise ValueError("a model without its source has no inputs: use `eigenvalues`")
        path, options = self.origin
        values = self.parameters.given(parameters or {})
        opened = OpenedModel(path, options, inputs, outputs, values)
        if state is not None:
            names = (variable.name for variable in self.states)
            given = dict(zip(names, np.asarray(state, dtype=float).tolist(), strict=True))
            return opened.linearise(opened.at_state(given, _seconds(time, "time") or 0.0))
        return opened.linearise(opened.operating_point(_point(at)))

    def symbolic(
        self,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        *,
        at: float | Literal["start", "steady"] | Mapping[str, Any] | None = None,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> SymbolicModel:
        """The equations and their linear form as SymPy expressions in the model's own letters.

        `f`, `g`, `A`, `B`, `C`, `D`, transfer functions with poles, zeros and static gain, and
        derivatives by parameters; see `bgc.symbolic.model.SymbolicModel`.

        Parameters
        ----------
        inputs
            Efforts or flows of sources (`"supply.e"`), parameters (`"F"`), channels of devices
            (`"hand.position[3]"`); by default the channels of the devices and the sources that
            depend on parameters and the time alone.
        outputs
            Names that the scene observes, or any expressions; by default all it observes.
        at
            The operating point: None leaves all states as letters; `"start"` puts in the initial
            values, `"steady"` the formula of an equilibrium near the initial state, a time in s
            the numbers after a simulation up to it, a mapping numbers or SymPy expressions by
            name.
        parameters
            Values for this call alone, SI numbers or texts with a unit; they only count where
            numbers are asked for.

        Raises
        ------
        BgError
            An input or output does not exist, there is no equilibrium, or none with a formula.

        Examples
        --------
        >>> model.symbolic().transfer("capacitor.e", "supply.e")  # doctest: +SKIP
        1/(C*L*s**2 + C*R*s + 1)
        """
        # SymPy takes 0.3 s to import, and only this needs it.
        from bgc.runtime.linearising.symbolic import symbolic_model

        if self.origin is None:
            raise ValueError("a model without its source has no letters: use `linearise`")
        path, options = self.origin
        values = self.parameters.given(parameters or {})
        return symbolic_model(path, options, inputs, outputs, at, values)

    def eigenvalues(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> Complex:
        """Eigenvalues of the emitted Jacobian at a state, 1/s, by rising real part."""
        instance = self.instance_at(state, _seconds(time, "time") or 0.0, parameters)
        status, dense, _ = instance.jacobian()
        require(instance, status)
        status, mass = instance.mass()
        require(instance, status)
        return pencil_eigenvalues(dense, mass)

    def modes(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> tuple[Mode, ...]:
        """Modes of the emitted Jacobian at a state, by rising frequency."""
        return modes_of(self.eigenvalues(state, time, parameters))

    def state_at(self, time: Quantity) -> tuple[Array, Array]:
        """Run to a time, s; return the state and the device inputs then. No rows are kept."""
        return state_after(self, _seconds(time, "time") or 0.0)

    # --- stepwise ---------------------------------------------------------------------

    def step(
        self,
        *,
        solver: str | None = None,
        rtol: Quantity | None = None,
        step: Quantity | None = None,
        max_step: Quantity | None = None,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> Stepping:
        """Begin a run that the program advances piece by piece.

        Between the pieces the observed values and the state can be read: to stop at a condition, to
        show them, to feed another program. Options are as for `simulate`; an adaptive method takes
        its own steps, and its values at the times asked for are those of its dense output.

        Examples
        --------
        >>> with model.step() as run:  # doctest: +SKIP
        ...     while run.advance("10 ms")["height"] > 0:
        ...         print(run.time, run["height"])
        """
        # Few programs run stepwise.
        from bgc.runtime.running.stepping import Stepping

        options = _options(rtol, None, step, max_step, None, None)
        method, _ = method_of(self, solver, options, parameters or {})
        return Stepping(self, method, parameters or {})

    # --- views ------------------------------------------------------------------------

    def graph(self, *, depth: int | None = None, collapsed: Sequence[str] = ()) -> Drawing:
        """Draw the bond graph with half arrows and causal strokes; a notebook shows it.

        Parameters
        ----------
        depth
            Draw parts below this level as one node each.
        collapsed
            Paths of parts to draw as one node.
        """
        # Loads the compiler, as `linearise` does.
        from bgc.runtime.documents.views import drawing_of

        return drawing_of(self._stages("causality"), depth, tuple(collapsed))

    @property
    def causality(self) -> Tables:
        """Causal strokes with their reasons, storage and algebraic loops, as tables."""
        # Loads the compiler, as `linearise` does.
        from bgc.runtime.documents.views import causality_of

        return causality_of(self._stages("equations"))

    @property
    def equations(self) -> Equations:
        """The state equations that the scene needs: `text`, and `latex` for a notebook."""
        # Loads the compiler, as `linearise` does.
        from bgc.runtime.documents.views import equations_of

        return equations_of(self._stages("optimise"))

    def live(self, *, height: int = 520) -> LivePage:
        """Make a page that runs this model in any browser, with its present parameters.

        In a notebook the page is shown below the cell, in a frame `height` pixels high;
        `save(path)` writes it as one HTML file, which needs no server. Its model is compiled to
        WebAssembly by the package `ziglang` (the extra `zig`).

        Raises BgError: BG545 without that package, BG548 for a solver of another one.
        """
        # Loads the compiler, as `linearise` does.
        from bgc.runtime.web.export import page_of

        shown = self._with_shapes()
        for name, value in self.parameters.given({}).items():
            shown.parameters[name] = value
        return page_of(shown, shown._stages("C compiler"), height)

    def _stages(self, until: Stage) -> Stages:
        # Loads the compiler, as `linearise` does.
        from bgc.driver import compile_scene

        if self.origin is None:
            raise ValueError("a model without its source has no graph and no equations")
        path, options = self.origin
        return compile_scene(path, options, until=until)

    def _repr_html_(self) -> str:
        # Only a notebook needs it.
        from bgc.printing.tables import Table
        from bgc.runtime.results.html import table_html

        rows = [
            (kind, v.name, v.shown.label)
            for kind, some in (("state", self.states), ("output", self.outputs))
            for v in some
        ]
        title = repr(self).strip("<>")
        table = table_html(Table(title, ("", "name", "unit"), tuple(rows)))
        return table + self.parameters._repr_html_()


def _seconds(value: Quantity | None, name: str = "duration") -> float | None:
    return in_si(value, name, "s")


def _point(at: Quantity | Literal["steady"] | None) -> float | Literal["steady"] | None:
    return "steady" if at == "steady" else in_si(at, "at", "s")


def _options(
    rtol: Quantity | None,
    atol: Quantity | None,
    step: Quantity | None,
    max_step: Quantity | None,
    substeps: int | None,
    settle: Quantity | None,
) -> dict[str, float | None]:
    """The options of a method by name, SI."""
    return {
        "rtol": in_si(rtol, "rtol", ""),
        "atol": in_si(atol, "atol", ""),
        "step": in_si(step, "step", "s"),
        "max_step": in_si(max_step, "max_step", "s"),
        "substeps": substeps,
        "settle": in_si(settle, "settle", "Hz"),
    }
