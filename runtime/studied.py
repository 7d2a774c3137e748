"""Many runs of a model: ensembles, sweeps, estimation, optimisation, operability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from bgc.diagnostics.public import public_class
from bgc.language.column_names import name_in_si
from bgc.language.solver import SolverKeywords
from bgc.runtime.running.arguments import read_solver, seconds_of, with_solver_keywords
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.quantity import Quantity
from bgc.runtime.running.simulate import method_of, times_of

if TYPE_CHECKING:
    from bgc.runtime.results.ensemble import Ensemble
    from bgc.runtime.results.study import Study
    from bgc.runtime.running.cases import Sets
    from bgc.runtime.running.inputs import Inputs
    from bgc.runtime.studies.effects import Effects
    from bgc.runtime.studies.estimate import Estimate
    from bgc.runtime.studies.motion import Motion
    from bgc.runtime.studies.operability_result import Operability
    from bgc.runtime.studies.optimum import Optimum
    from bgc.runtime.studies.sweep import Vary


@public_class
class StudiedModel(LoadedModel):
    """A model with the methods that run it many times; see `bgc.runtime.model.Model`."""

    @with_solver_keywords
    def simulate_many(
        self,
        parameters: Sets,
        duration: Quantity | None = None,
        *,
        every: Quantity | None = None,
        progress: bool = False,
        vectorised: bool = True,
        resume: bool = False,
        inputs: Inputs | Sequence[Inputs] | None = None,
        **run: Unpack[SolverKeywords],
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
        duration, every, **run
            As for `simulate`.
        progress
            Whether to show a progress bar on a terminal when it takes longer than a second.
        vectorised
            Whether to use vector registers; otherwise instances are run one by one.
        resume
            Whether to keep what is done if Ctrl-C ends the call, for the next equal one.
        inputs
            As for `simulate`, for all runs; or a list with such a mapping for each run. In a list,
            each input has values of one shape in all runs, and functions are joined by cubic
            splines. `parameters={}` takes as many runs as the list has mappings.

        Returns
        -------
        Ensemble
            Also if instances failed: `status` and `failures` name them with their errors.

        Raises
        ------
        Interrupted
            Ctrl-C; its `result` holds the rows up to there.
        BgError
            An argument or a parameter is at fault.

        Examples
        --------
        >>> many = model.simulate_many({"k": [1, 2, "5 N/m"], "m": "2 kg"})  # doctest: +SKIP
        >>> many["x"].shape  # (instances, rows)  # doctest: +SKIP
        """
        # Loading this would take 6 % of a warm `bgc run`, which has no ensemble.
        from bgc.runtime.results.ensemble import Ensemble
        from bgc.runtime.running.cases import checked_cases
        from bgc.runtime.running.input_models import driven_runs, numbered
        from bgc.runtime.running.many import plan_many, run_many

        method, notices = method_of(self, read_solver(run))
        end, interval = seconds_of(duration), seconds_of(every, "every")
        rows = times_of(self, method, end, interval)
        model, sets, by_run = driven_runs(self, inputs, parameters, rows)
        cases = checked_cases(sets, model.parameters)
        times = times_of(self, method, end, interval, len(cases))
        plan = plan_many(model, method, numbered(cases) if by_run else cases, times, vectorised)
        ensemble = run_many(plan, progress, notices, resume)
        assert isinstance(ensemble, Ensemble)  # without observables
        return ensemble

    @with_solver_keywords
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
        inputs: Inputs | None = None,
        **run: Unpack[SolverKeywords],
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
        progress, resume
            As for `simulate_many`.
        duration, every, inputs, **run
            As for `simulate`; the inputs are those of all runs.

        Returns
        -------
        Study
            With observables: one row for each run.
        Ensemble
            Without: all rows of all runs.

        Raises
        ------
        Interrupted
            Ctrl-C; `result` holds what was done.
        BgError
            An argument or a parameter is at fault.

        Examples
        --------
        >>> study = model.sweep({"mass": "1..9 t:5"}, ["max(tension)"])  # doctest: +SKIP
        >>> study["mass"], study["max(tension)"], study.statistics()  # doctest: +SKIP
        """
        # As for `simulate_many`.
        from bgc.runtime.running.batches import rows_at_once
        from bgc.runtime.running.input_models import driven
        from bgc.runtime.studies.sweep import Design, observables_of, sweep

        chosen = Design(vary, sample, design, seed, cases)
        observables = observables_of(self, observe)
        method, notices = method_of(self, read_solver(run))
        values = chosen.values(self.parameters)
        count = len(next(iter(values.values()), ()))
        at_once = rows_at_once(count) if observables else count
        times = times_of(self, method, seconds_of(duration), seconds_of(every, "every"), at_once)
        model = driven(self, inputs, times)
        return sweep(
            model, chosen, method, times, observables, progress=progress, notices=notices,
            resume=resume, scheduler=scheduler, store=store,
        )  # fmt: skip

    @with_solver_keywords
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
        inputs: Inputs | None = None,
        **run: Unpack[SolverKeywords],
    ) -> Estimate:
        """Estimate parameters from a recorded motion, as `bgc fit` does.

        Minimises the sum of squared residuals in units of their noise within the bounds, by SciPy's
        `least_squares`. Derivatives are the sensitivities of the run, of which few are needed, or
        central differences where it has none.

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
        inputs, **run
            As for `simulate`; recorded inputs are pairs of times and values.

        Raises
        ------
        BgError
            The data or the bounds are at fault (BG788, BG479), or the run at the start fails.

        Examples
        --------
        >>> estimate = model.fit("run.csv", {"k": "50..500 N/m"})  # doctest: +SKIP
        >>> estimate["k"], estimate.interval("k")  # doctest: +SKIP
        """
        # As for `simulate_many`.
        from bgc.runtime.running.input_models import driven
        from bgc.runtime.studies.fit import FitOptions, fit
        from bgc.runtime.studies.motion import read_motion
        from bgc.runtime.studies.search_arguments import read_bounds, read_noise

        method, _ = method_of(self, read_solver(run))
        recorded = read_motion(motion, self, match or {}, columns)
        bounds = read_bounds(vary, self.parameters)
        known = read_noise(noise or {}, recorded.names, self.outputs)
        return fit(
            driven(self, inputs, recorded.time), method, recorded, bounds,
            FitOptions(loss, known, starts, confidence),
        )  # fmt: skip

    @with_solver_keywords
    def optimise(
        self,
        vary: Vary,
        *,
        minimise: str | None = None,
        maximise: str | None = None,
        require: Sequence[str] | None = None,
        over: Vary = (),
        judge: str = "worst",
        search: str | None = None,
        starts: int = 1,
        runs: int = 10_000,
        seed: int = 0,
        progress: bool = False,
        duration: Quantity | None = None,
        every: Quantity | None = None,
        **run: Unpack[SolverKeywords],
    ) -> Optimum:
        """Find the parameters of the best design, as `bgc optimise` does.

        Parameters
        ----------
        vary
            Parameters with their bounds, `{"k": "50..500 N/m"}` or `["k=50..500 N/m"]`. The search
            starts at the present values, or at the nearest bound where they are outside.
        minimise, maximise
            The objective, one of both: an observable of a run such as `max(load.z) from 5 s`.
        require
            Limits on observables, `"max(pressure) < 210 bar"`; by default those of the scene,
            `require pressure < 210 bar;`. An empty list stands for none.
        over, judge
            Values of other parameters, `{"w": "5..15 rad/s:40"}`: each design runs with all of
            them, limits have to hold in each of these cases, and the objective is that of the
            worst case ("worst") or the mean ("mean").
        search
            "gradient": sequential quadratic programming (SciPy's SLSQP). Derivatives are the
            sensitivities of the run where these take fewer operations than central differences,
            which are one batch with their point. "evolution": differential evolution, without
            derivatives, one batch a generation. By default "gradient", and "evolution" where an
            observable counts rows (`above`, `crossings`).
        starts, seed
            Number of designs within the bounds, points of a Sobol sequence, among which to start.
        runs
            Number of runs after which the search ends with the best design so far.
        progress
            Whether to show a line with the best design on a terminal.
        duration, every, **run
            As for `simulate`.

        Raises
        ------
        Interrupted
            Ctrl-C; `result` is the best design by then.
        BgError
            An argument is at fault (BG655 and those of a wrong name, unit or number), or the run
            at the start fails.

        Examples
        --------
        >>> best = model.optimise({"k": "50..500 N/m"}, minimise="max(x)")  # doctest: +SKIP
        >>> best["k"], best.objective, best.feasible  # doctest: +SKIP
        """
        # As for `simulate_many`.
        from bgc.runtime.running.batches import rows_at_once
        from bgc.runtime.studies.optimise import Goal, Search, optimise
        from bgc.runtime.studies.search_arguments import read_problem

        problem = read_problem(self, vary, minimise, maximise, require, over)
        method, notices = method_of(self, read_solver(run))
        times = times_of(
            self, method, seconds_of(duration), seconds_of(every, "every"), rows_at_once(1_000)
        )
        return optimise(
            self, method, times, problem.bounds,
            Goal(problem.objective, maximise is not None, judge), problem.criteria, problem.over,
            Search(search or "", starts, runs, seed), progress=progress, notices=notices,
        )  # fmt: skip

    @with_solver_keywords
    def effects(
        self,
        observe: Sequence[str] = (),
        duration: Quantity | None = None,
        *,
        of: Sequence[str] = (),
        every: Quantity | None = None,
        **run: Unpack[SolverKeywords],
    ) -> Effects:
        """Find by how much each parameter changes observables, as `bgc sensitivity` does.

        Derivatives are the sensitivities of the run, or central differences where it has none, at
        the present values of the parameters.

        Parameters
        ----------
        observe
            Observables such as `max(tension)`; by default the largest magnitude, `peak(x)`, of each
            observed column.
        of
            Names of parameters; by default all that are not 0.
        duration, every, **run
            As for `simulate`.

        Raises
        ------
        BgError
            An argument is at fault, or the run fails.

        Examples
        --------
        >>> found = model.effects(["max(force)"], of=["mass", "speed"])  # doctest: +SKIP
        >>> found.ranking("max(force)"), found.per_cent, found.plot()  # doctest: +SKIP
        """
        # As for `simulate_many`.
        from bgc.runtime.studies.effects import effects
        from bgc.runtime.studies.sweep import observables_of

        columns = [v.name for v in self.outputs if v.name in {m.name for m in self.measured}]
        texts = observe or [f"peak({name_in_si(column)})" for column in columns]
        method, notices = method_of(self, read_solver(run))
        times = times_of(self, method, seconds_of(duration), seconds_of(every, "every"))
        return effects(self, method, times, observables_of(self, texts), of, notices)

    @with_solver_keywords
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
        **run: Unpack[SolverKeywords],
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
        scheduler, store, progress, resume
            As for `sweep`.
        duration, every, **run
            As for `simulate`.

        Raises
        ------
        Interrupted
            Ctrl-C.
        BgError
            An argument or a parameter is at fault.

        Examples
        --------
        >>> found = model.operability(  # doctest: +SKIP
        ...     "sea.height=1..4 m:7", "sea.period=5..13 s:5", ["peak(roll) < 3 deg"]
        ... )
        >>> found.limiting_heights(), found.downtime("north_sea.csv")  # doctest: +SKIP
        """
        # As for `simulate_many`.
        from bgc.runtime.running.batches import rows_at_once
        from bgc.runtime.studies.operability import SeaStates, operability, read_criteria

        read = read_criteria(self, criteria)
        method, notices = method_of(self, read_solver(run))
        at_once = rows_at_once(1_000_000)
        times = times_of(self, method, seconds_of(duration), seconds_of(every, "every"), at_once)
        return operability(
            self, SeaStates(height, period, heading, seed), read, method, times, judge=judge,
            exposure=seconds_of(exposure, "exposure"), progress=progress, notices=notices,
            resume=resume, scheduler=scheduler, store=store,
        )  # fmt: skip
