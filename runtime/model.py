"""A compiled model as a Python user holds it: parameters, simulation, linearisation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TextIO, Unpack

import numpy as np

from bgc.diagnostics.public import public_class
from bgc.language.solver import SolverKeywords
from bgc.runtime.evaluated import EvaluatedModel
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.result import Result
from bgc.runtime.running.arguments import read_solver, seconds_of, with_solver_keywords
from bgc.runtime.running.device_drivers import read_choices
from bgc.runtime.running.input_models import compiled_again
from bgc.runtime.running.inputs import Inputs, drives_of
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.quantity import Quantity
from bgc.runtime.running.sensitivities import followed
from bgc.runtime.running.simulate import method_of, simulate, times_of
from bgc.runtime.studied import StudiedModel

if TYPE_CHECKING:
    from bgc.driver import Stage, Stages
    from bgc.runtime.documents.views import Drawing, Equations, Tables
    from bgc.runtime.linearising.casadi_model import CasadiModel
    from bgc.runtime.realtime.loop import Realtime
    from bgc.runtime.realtime.loop_options import RealtimeOptions
    from bgc.runtime.realtime.python_device import PythonDevice
    from bgc.runtime.running.stepwise import Stepping
    from bgc.runtime.web.page_export import LivePage
    from bgc.symbolic.symbolic_model import SymbolicModel


@public_class
class Model(StudiedModel, EvaluatedModel):
    """A compiled model: set its parameters, simulate it, linearise it.

    Runs share nothing: each starts from the initial state.
    """

    @with_solver_keywords
    def simulate(
        self,
        duration: Quantity | None = None,
        *,
        every: Quantity | None = None,
        parameters: Mapping[str, ParameterValue] | None = None,
        progress: bool = False,
        shapes: bool = False,
        devices: Mapping[str, str] | None = None,
        inputs: Inputs | None = None,
        out: str | Path | TextIO | None = None,
        error: bool = True,
        sensitivities: Sequence[str] = (),
        **run: Unpack[SolverKeywords],
    ) -> Result:
        """Run from the initial state and return the observed values.

        Parameters
        ----------
        duration, every
            End time and interval between rows, s or texts such as `"2 s"`; by default the
            scene's. Without an interval there is a row for each step of a fixed-step method, else
            there are 1,000 intervals. If the equations depend explicitly on time, adaptive
            methods take no step longer than five row intervals, unless `max_step` is given.
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
        inputs
            Inputs of the model by their paths, in place of the scene's `drive`s: a constant; a
            pair `(times, values)`, interpolated by straight lines, whose times (s) cover the run;
            or a function of the time in s, which is called at the times of the rows and
            interpolated between them without overshoot (`pchip`). Values are SI numbers, texts
            with a unit, or arrays of these. The model is compiled once for each set of values.
        out
            A file for all rows: `.csv`, `.npz` or `.zarr`, or an open text stream (CSV). More than
            2 million numbers are written while the run goes on, in constant memory, and the result
            then has a selection of the rows (`Result.rows`).
        error
            Whether to estimate by how much the columns are off: `result.error`. The rows are the
            same bits without, and the run takes less time.
        sensitivities
            Names of parameters, and of states for their initial values, by which the columns are
            differentiated: `result.sensitivity("tip", "boom.mass")`. The steps are those of a run
            without; they are not shortened for the sake of the derivatives. A file `out` has a
            column `d tip/d boom.mass` for each. The model is compiled once more, with its tangents.
        **run
            Method, tolerances, steps and start of the run: see `SolverKeywords`. By default the
            scene's, else `ros34prw` where the scene gives a step, or `rodas5p`; where explicit
            steps may cost less `switching_fixed` or `switching`. An option that the method does
            not have is an error.

        Raises
        ------
        SimulationError
            The run could not be completed; its `result` holds the rows up to there.
        RunInterrupted
            Ctrl-C; its `result` holds the rows up to there.
        BgError
            An argument or a parameter is at fault.

        Examples
        --------
        >>> result = model.simulate("2 s", parameters={"R": "5 ohm"})  # doctest: +SKIP
        >>> result["capacitor.e"].max(), result.units["capacitor.e"]  # doctest: +SKIP
        """
        values = parameters or {}
        method, notices = method_of(self, read_solver(run), values)
        end, interval = seconds_of(duration), seconds_of(every, "every")
        # Inputs that are functions are called at the times of the rows.
        drives = drives_of(inputs, times_of(self, method, end, interval)) if inputs else ()
        if drives or (shapes and not self.facts.shapes):
            return compiled_again(self, drives, shapes=shapes).simulate(
                duration,
                every=every,
                parameters=values,
                progress=progress,
                devices=devices,
                out=out,
                error=error,
                sensitivities=sensitivities,
                **run,
            )
        choices = read_choices(devices or {})
        model, directions = followed(self, method, sensitivities)
        if out is not None:
            # Loads the writers of files.
            from bgc.runtime.running.row_stream import simulate_to, target_of

            target = target_of(out)
            return simulate_to(
                target, model, method, end, interval, values, progress, notices, choices, error,
                directions,
            )  # fmt: skip
        times = times_of(model, method, end, interval, 1 + len(directions))
        common = values, progress, notices, choices, error, directions
        return simulate(model, method, times, *common)

    @with_solver_keywords
    def realtime(
        self,
        duration: Quantity | None = None,
        *,
        devices: Mapping[str, str | PythonDevice] | None = None,
        options: RealtimeOptions | None = None,
        record: str | Path | None = None,
        keep: int = 60_000,
        parameters: Mapping[str, ParameterValue] | None = None,
        on_records: Callable[[Array], None] | None = None,
        **run: Unpack[SolverKeywords],
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
            `bgc.runtime.realtime.loop_options.RealtimeOptions`.
        record
            A `.csv` file for the motion of the device, which `trace` replays with the same bits.
        keep
            Number of samples kept in `rows`.
        parameters, **run
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
        from bgc.runtime.realtime.loop_options import RealtimeOptions

        method, notices = method_of(self, read_solver(run), parameters or {})
        loop = Realtime(
            self,
            method,
            options or RealtimeOptions(),
            duration=seconds_of(duration),
            devices=devices,
            record=None if record is None else Path(record),
            keep=keep,
            parameters=parameters,
            on_records=on_records,
        )
        loop.warnings += notices
        return loop

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

        Derivatives are exact. Where algebraic equations remain, it is `E dx' = A dx + B du`.

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

        Examples
        --------
        >>> linear = model.linearise(["supply.e"], ["speed"], at="steady")  # doctest: +SKIP
        >>> linear.A, linear.modes(), linear.to_ss()  # doctest: +SKIP
        """
        # Loads the compiler, which takes longer than most runs; they do without it.
        from bgc.runtime.linearising.operating_point import OpenedModel

        path, options = self.source_for("inputs: use `eigenvalues`")
        values = self.parameters.given(parameters or {})
        opened = OpenedModel(path, options, inputs, outputs, values)
        if state is not None:
            names = (variable.name for variable in self.states)
            given = dict(zip(names, np.asarray(state, dtype=float).tolist(), strict=True))
            return opened.linearise(opened.at_state(given, seconds_of(time, "time") or 0.0))
        point = opened.operating_point("steady" if at == "steady" else seconds_of(at, "at"))
        return opened.linearise(point)

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
        derivatives by parameters; see `bgc.symbolic.symbolic_model.SymbolicModel`.

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

        path, options = self.source_for("letters: use `linearise`")
        values = self.parameters.given(parameters or {})
        return symbolic_model(path, options, inputs, outputs, at, values)

    def casadi(
        self,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        *,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> CasadiModel:
        """The equations and their linear form as CasADi expressions, for optimal control.

        See `bgc.runtime.linearising.casadi_model.CasadiModel`; the extra `casadi` installs CasADi.

        Parameters
        ----------
        inputs, outputs
            As for `symbolic`: the effort or flow of a source whose value depends on parameters and
            the time alone is replaced by its input, any other input is added.
        parameters
            Other values of the parameters and of the start that follows from them, SI numbers or
            texts with a unit.

        Raises
        ------
        BgError
            An input or output does not exist, or CasADi is not installed (BG058).

        Examples
        --------
        >>> pendulum = bgc.compile("pendulum.bg").casadi(["motor.e"], ["angle"])  # doctest: +SKIP
        >>> pendulum.f, pendulum.A, pendulum.function()  # doctest: +SKIP
        """
        # Loads the compiler and CasADi, which most runs do without.
        from bgc.runtime.linearising.casadi_model import casadi_model

        path, options = self.source_for("equations: use `linearise`")
        values = self.parameters.given(parameters or {})
        return casadi_model(path, options, inputs, outputs, values)

    # --- stepwise ---------------------------------------------------------------------

    @with_solver_keywords
    def step(
        self,
        *,
        parameters: Mapping[str, ParameterValue] | None = None,
        inputs: Inputs | None = None,
        **run: Unpack[SolverKeywords],
    ) -> Stepping:
        """Begin a run that the program advances piece by piece.

        Between the pieces the observed values and the state can be read: to stop at a condition, to
        show them, to feed another program. An adaptive method takes its own steps, and its values
        at the times asked for are those of its dense output.

        Parameters
        ----------
        parameters, **run
            As for `simulate`.
        inputs
            Inputs in place of the scene's `drive`s: a value is held until `advance` changes it; a
            pair `(times, values)` is joined by straight lines, and its last value holds after them.

        Raises
        ------
        BgError
            An argument or a parameter is at fault (BG563 for an input that is a function).

        Examples
        --------
        >>> with model.step() as run:  # doctest: +SKIP
        ...     while run.advance("10 ms")["height"] > 0:
        ...         print(run.time, run["height"])
        >>> with model.step(inputs={"force": 0}) as run:  # doctest: +SKIP
        ...     run.advance("10 ms", inputs={"force": -2.0 * run["speed"]})
        """
        # Few programs run stepwise.
        from bgc.runtime.running.stepwise import Stepping, opened

        begun = opened(self, inputs or {})
        method, notices = method_of(begun.model, read_solver(run), parameters or {})
        values = {**(parameters or {}), **begun.values}
        return Stepping(begun.model, method, values, begun.inputs, notices)

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
        from bgc.runtime.web.page_export import page_of

        shown = compiled_again(self, (), shapes=True)
        return page_of(shown, shown._stages("C compiler"), height)

    def _stages(self, until: Stage) -> Stages:
        # Loads the compiler, as `linearise` does.
        from bgc.driver import compile_scene

        path, options = self.source_for("graph and no equations")
        return compile_scene(path, options, until=until)

    def _repr_html_(self) -> str:
        # Only a notebook needs it.
        from bgc.printing.text_tables import Table
        from bgc.runtime.results.html import table_html

        rows = [
            (kind, v.name, v.shown.label)
            for kind, some in (("state", self.states), ("output", self.outputs))
            for v in some
        ]
        title = repr(self).strip("<>")
        table = table_html(Table(title, ("", "name", "unit"), tuple(rows)))
        return table + self.parameters._repr_html_()
