"""One run of a model: its method, its devices, and its supervision from Python."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from threading import Event, Thread
from types import MappingProxyType
from typing import TypeVar

from bgc.building.backends import BACKENDS, build_backend
from bgc.building.built import RunFacts
from bgc.building.cache import open_cache
from bgc.diagnostics.catalogue.arguments import (
    bad_option,
    option_not_served,
    step_needed,
    unknown_solver,
)
from bgc.diagnostics.catalogue.backends import solver_does_not_serve
from bgc.diagnostics.diagnostic import BgError
from bgc.language.scene import Rest
from bgc.language.scene_tables import AUTO
from bgc.language.solver import SOLVER_OPTIONS
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.rest import AtRest
from bgc.runtime.running.binding import Instance, Library, backend_run
from bgc.runtime.running.methods import ADAPTIVE_OPTIONS, MethodInfo, default_method
from bgc.runtime.running.progress import ProgressBar
from bgc.runtime.running.rest import go_to_rest
from bgc.runtime.running.rows import RowTimes
from bgc.runtime.running.settle import settle
from bgc.runtime.running.structures import OptionsStruct, Status

_ROWS_IN_A_STEP = 5
_WATCH_SECONDS = 0.05  # between two checks of a run: bounds the wait after Ctrl-C

_NONE: Mapping[str, float | None] = MappingProxyType({})

_Outcome = TypeVar("_Outcome")


@dataclass(frozen=True, slots=True)
class Method:
    """An integration method with its options, SI; 0 where the C runtime chooses.

    `auto` means that the recommendation of `bgc trade` goes first, if there is one. `start` is
    "rest", "given", or empty for the scene's own start.
    """

    name: str
    fixed: bool
    rtol: float = 0.0
    atol: float = 0.0
    step: float = 0.0
    max_step: float = 0.0
    max_steps: int = 0
    keep: int = 0
    substeps: int = 0
    settle: float = 0.0
    auto: bool = False
    start: str = ""

    def with_capped_step(self, times: Array | RowTimes, timed: bool) -> Method:
        """Cap the step of an adaptive method at a few row intervals where a model is `timed`.

        Error control cannot see a source that acts between two stages of a long step.
        """
        if not timed or self.fixed or self.max_step or len(times) < 2:
            return self
        duration = times.duration if isinstance(times, RowTimes) else float(times[-1] - times[0])
        interval = duration / (len(times) - 1)
        return replace(self, max_step=_ROWS_IN_A_STEP * interval)

    def started(self, start: str | None) -> Method:
        """The method with another start of its runs; BG066 for an unknown one."""
        if start not in (None, "rest", "given"):
            raise BgError([bad_option("start", start, "`rest` or `given`", "rest")])
        return self if start is None else replace(self, start=start)

    def rest_of(self, facts: RunFacts) -> Rest | None:
        """The start at rest of a run of a scene; None where it starts from given values."""
        if self.start == "given":
            return None
        return facts.rest or (facts.resting if self.start == "rest" else None)

    def struct(self, accounts: bool) -> OptionsStruct:
        """Make the options structure of C."""
        return OptionsStruct(
            name=self.name.encode(),
            rtol=self.rtol,
            atol=self.atol,
            step=self.step,
            max_step=self.max_step,
            max_steps=self.max_steps,
            keep=self.keep,
            accounts=int(accounts),
            substeps=self.substeps,
        )


def choose_method(
    library: Library,
    facts: RunFacts,
    solver: str | None = None,
    options: Mapping[str, float | None] = _NONE,
    backends: Iterable[str] = (),
) -> Method:
    """Choose the method of a run: the caller's options go before those of the scene.

    Without a solver, and for `auto` without a recommendation, the method is the default of the
    runtime: with fixed steps where a step is given, else with error control. The scene's options
    are those of its own method: another one takes those that it has, but no tolerance or step of a
    method of the other kind. `backends` are external solvers that may be chosen too.

    Raises BgError: BG044 for an option that the method does not have, BG066 for a bad option, BG071
    for an unknown solver, BG072 for a fixed-step method without a step.
    """
    given = {name: value for name, value in options.items() if value is not None}
    wanted = {**facts.solver.given, **given}
    _check_options(wanted)
    name = solver or facts.solver.name
    # A recommendation was measured without the caller's options, which go first.
    auto = name == AUTO and not given
    if name in ("", AUTO):
        fixed = bool(wanted.get("step") or facts.step)
        name = default_method(library.methods.values(), fixed, library.explicit_cost > 0).name
    known = (*library.methods, *backends)
    if name not in known:
        raise BgError([unknown_solver(name, known)])
    info = library.methods.get(name)  # None: a backend, which is adaptive
    fixed = info is not None and info.fixed
    served = ADAPTIVE_OPTIONS if info is None else info.options
    parts = 1 if info is None else info.substeps
    parts = int(wanted.get("substeps", parts)) if "substeps" in served else parts
    if fixed and parts == 1:  # no step is judged by a tolerance
        served = tuple(option for option in served if option not in ("rtol", "atol"))
    intended = set(wanted) if facts.solver.name == name else set(given)
    for option in wanted:
        if option not in served and option in intended:
            raise BgError([option_not_served(name, option, fixed, served)])
    lost = _options_of_other_kind(library.methods.get(facts.solver.name), fixed)
    wanted = {
        option: value
        for option, value in wanted.items()
        if option in served and (option in given or option not in lost)
    }
    if fixed and "step" not in wanted:
        if facts.step is None:
            raise BgError([step_needed(name)])
        wanted["step"] = facts.step
    return Method(
        name,
        fixed,
        rtol=wanted.get("rtol", 0.0),
        atol=wanted.get("atol", 0.0),
        step=wanted.get("step", 0.0),
        max_step=wanted.get("max_step", 0.0),
        max_steps=int(wanted.get("max_steps", 0)),
        keep=int(wanted.get("keep", 0)),
        substeps=parts,
        settle=wanted.get("settle", 0.0),
        auto=auto,
    )


def _check_options(wanted: Mapping[str, float]) -> None:
    """Refuse options that no method can use, as BG066."""
    for name, value in wanted.items():
        if (problem := SOLVER_OPTIONS[name].problem(name, value)) is not None:
            raise BgError([problem])


def _options_of_other_kind(own: MethodInfo | None, fixed: bool) -> set[str]:
    """The options of the scene's own method that have no meaning for one of the other kind.

    `own` is None without a method in the scene, for `auto` and for a backend.
    """
    if own is None:
        return {"rtol", "atol"} if fixed else set()
    return {"rtol", "atol", "step"} if own.fixed != fixed else set()


def start(
    instance: Instance, method: Method, rest: Rest | None = None
) -> tuple[Status, AtRest | None]:
    """Put an instance at its initial state, or at rest near to it.

    Without `rest`, fast modes are brought to rest if the method has `settle`.
    """
    status = instance.reset()
    if status is Status.OK and rest is not None:
        return go_to_rest(instance, rest)
    if status is Status.OK and method.settle > 0:
        return settle(instance, method.settle), None
    return status, None


def set_method(instance: Instance, method: Method, accounts: bool) -> Status:
    """Set the method of an instance; an external solver is compiled first if necessary.

    Raises BgError: BG046 if the solver is not installed, BG047 if it does not support the model.
    """
    if method.name not in BACKENDS:
        return instance.set_options(method.struct(accounts))
    model = instance.library.model
    unsupported = (
        (model.n_device > 0, "it reads a device"),
        (instance.library.is_sampled, "it has sampled parts"),
        (model.n_input > 0, "its inputs are written while it runs"),
        (model.n_mass > 0, "its rates are coupled, or it has algebraic equations"),
        (model.n_state == 0, "it has no states"),
        (instance.library.has_jumps, "its states jump"),
        (instance.library.has_chains, "it has closed chains of rigid connections"),
    )
    for applies, reason in unsupported:
        if applies:
            raise BgError([solver_does_not_serve(method.name, reason)])
    path = build_backend(BACKENDS[method.name], open_cache())
    instance.backend = backend_run(path, method.name)
    adaptive = default_method(instance.library.methods.values(), fixed=False)
    return instance.set_options(replace(method, name=adaptive.name).struct(accounts))


def run_watched(
    instance: Instance, times: Array, rows: Array, progress: bool
) -> tuple[Status, int, bool]:
    """Run to all times, with a progress bar if requested; Ctrl-C stops the run within 0.2 s.

    Returns the status, the number of finished rows, and whether Ctrl-C was pressed.
    """
    with ProgressBar(float(times[-1]), progress) as bar:
        (status, done), interrupted = watched(
            instance, lambda: instance.run(times, rows), lambda: bar.show(instance.time)
        )
    return status, done, interrupted


def watched(
    instance: Instance, run: Callable[[], _Outcome], watch: Callable[[], None]
) -> tuple[_Outcome, bool]:
    """Run an instance in a thread, calling `watch` every 0.05 s; Ctrl-C stops the run.

    The C code runs uninterrupted, so that watching cannot change the result.

    Returns the result of `run`, and whether Ctrl-C was pressed.
    """
    outcome: list[_Outcome] = []
    finished = Event()

    def work() -> None:
        try:
            outcome.append(run())
        finally:
            finished.set()

    interrupted = False
    Thread(target=work, daemon=True).start()
    while not finished.is_set():
        # An event: after Ctrl-C in Thread.join, Python would consider the thread ended.
        try:
            finished.wait(_WATCH_SECONDS)
            watch()
        except KeyboardInterrupt:
            interrupted = True
        if interrupted:
            instance.stop()
    (found,) = outcome
    return found, interrupted
