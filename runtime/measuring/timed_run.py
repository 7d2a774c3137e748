"""A timed run: rows, processor time and counts, with limits on its time."""

from __future__ import annotations

import math
import os
import platform
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from threading import get_ident

import numpy as np

from bgc.building.build_result import ENERGY_ACCOUNTS
from bgc.diagnostics.catalogue.stress import nominal_run_failed
from bgc.diagnostics.diagnostic import BgError
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.failures import require
from bgc.runtime.running.identity import bgc_version
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.run import watched, with_capped_step
from bgc.runtime.running.structures import Status
from bgc.runtime.running.subtolerance import Subtolerance, subtolerance_states

_OF_STATE, _OF_SCALE = 1e-8, 1e-12
_MOST_PERIODS = 60_000  # that are timed one by one
_EXCLUDED = 1e-3  # of the periods: they may be slower than the usual time
_PERIODS_PER_OUTLIER = 100  # periods, of which one may be slower
_CLOCK_EVERY = 64  # periods


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """The outcome of a timed run.

    `status` is `done`, `stopped` at a limit, `failed`, or `refused` before the start; `message` is
    the reason. `rows` have the model's outputs, then the four energy accounts if requested; rows
    that were not reached are NaN. `seconds` is the processor time of the computation alone.
    `subtolerance` are the states that fell below their tolerance and grew again.
    """

    status: str
    message: str
    rows: Array
    seconds: float
    counts: dict[str, float]
    subtolerance: tuple[Subtolerance, ...] = ()

    @property
    def residual(self) -> float:
        """The largest energy residual over the energy exchanged, of a run with accounts.

        0 if there is no energy. The residual is the last of the columns.
        """
        worst = float(np.max(np.abs(self.rows[:, -1]), initial=0.0))
        exchanged = self.counts["exchanged"]
        return worst / exchanged if exchanged > 0 else 0.0


@dataclass(frozen=True, slots=True)
class Budget:
    """The time that a study may take, s, from now on."""

    seconds: float
    started: float = field(default_factory=time.monotonic)

    @property
    def left(self) -> float:
        """Seconds that are left."""
        return self.seconds - (time.monotonic() - self.started)


def reason_of(problem: BgError) -> str:
    """The first diagnostic of an error in one line."""
    first = problem.diagnostics[0]
    return f"{first.code}: {first.message}"


def timed_run(
    model: LoadedModel,
    method: Solver,
    times: Array,
    *,
    accounts: bool,
    limit: float,
    busy: float = math.inf,
    watch: Callable[[float], None] = lambda reached: None,
    moved: float = 0.0,
) -> Run:
    """Run a model from its start over all times, within two limits.

    `limit` is in seconds of wall time, `busy` in seconds of processor time, which other processes
    do not consume. `watch` is called regularly with the time reached, s. Ctrl-C stops the run
    and is raised again. With `moved` it starts next to the initial state: see `move_start`.
    """
    width = len(model.measured) + (len(ENERGY_ACCOUNTS) if accounts else 0)
    rows = np.full((len(times), width), np.nan)
    try:
        capped = with_capped_step(method, times, model.facts.timed)
        with model.started(capped, accounts) as instance:
            if moved > 0:
                move_start(instance, moved)
            status, seconds, stopped = _run_in_thread(instance, times, rows, limit, busy, watch)
            counts = instance.counts
            subtolerance = () if method.fixed else subtolerance_states(instance)
            if stopped and status is Status.INTERRUPTED:
                message = f"stopped at t = {instance.time:.3g} s: it takes too long"
                return Run("stopped", message, rows, seconds, counts)
            if status is not Status.OK:
                message = reason_of(BgError([model.explain(instance, status)]))
                return Run("failed", message, rows, seconds, counts)
    except BgError as problem:
        return Run("refused", reason_of(problem), rows, 0.0, {})
    if not np.isfinite(rows).all():
        return Run("failed", "BG712: an observed value is not finite", rows, seconds, counts)
    return Run("done", "", rows, seconds, counts, subtolerance)


def completed(run: Run) -> Run:
    """Return the run of an unchanged scene; BG089 where it was not completed."""
    if run.status != "done":
        raise BgError([nominal_run_failed(run.message)])
    return run


def move_start(instance: Instance, reached: float) -> None:
    """Move each state of an instance at its start by 1e-8 of itself and 1e-12 of its scale.

    Scales count as far as the states of the run have `reached` them. An unstable solution is then
    left, also one that starts exactly at rest.
    """
    instance.state[:] += _OF_STATE * instance.state + _OF_SCALE * reached * instance.scale
    require(instance, instance.restart())


def _run_in_thread(
    instance: Instance,
    times: Array,
    rows: Array,
    limit: float,
    busy: float,
    watch: Callable[[float], None],
) -> tuple[Status, float, bool]:
    """Run; return the status, the thread's processor time, s, and whether a limit was reached."""
    clocks: list[int] = []
    started = time.monotonic()
    stopped = False

    def run() -> tuple[Status, float]:
        if hasattr(time, "pthread_getcpuclockid"):  # not on every system
            clocks.append(time.pthread_getcpuclockid(get_ident()))
        start = time.thread_time()
        status, _ = instance.run(times, rows)
        return status, time.thread_time() - start

    def check_limits() -> None:
        nonlocal stopped
        watch(instance.time)
        stopped = stopped or time.monotonic() - started > limit or _spent(clocks) > busy
        if stopped:
            instance.stop()

    (status, seconds), interrupted = watched(instance, run, check_limits)
    if interrupted:
        raise KeyboardInterrupt
    return status, seconds, stopped


def _spent(clocks: Sequence[int]) -> float:
    """Read the clocks of threads, s; 0 before a thread has one and after its end."""
    with suppress(OSError):
        return sum(map(time.clock_gettime, clocks))
    return 0.0


def machine_description() -> str:
    """Describe the processor and the system that times were measured on."""
    name = ""
    with suppress(OSError), Path("/proc/cpuinfo").open(encoding="ascii", errors="replace") as file:
        lines = (line.partition(":") for line in file)
        name = next((value.strip() for key, _, value in lines if key.strip() == "model name"), "")
    processor = name or platform.processor() or platform.machine()
    cores = os.cpu_count() or 1
    system = f"{platform.system()} {platform.release()}"
    return f"{processor}, {cores} core{'s' if cores > 1 else ''}, {system}, bgc {bgc_version()}"


@dataclass(frozen=True, slots=True)
class Paced:
    """The times of the equal periods of a run, s of the thread's processor time.

    `usual` is the time within which all periods stay but for one in a thousand (of a hundred to a
    thousand periods, but for one). `slowest` are those times that are no smaller, in descending
    order, so that `usual` is the last of them.
    """

    usual: float
    slowest: tuple[float, ...]
    periods: int


def paced_times(
    model: LoadedModel,
    method: Solver,
    period: float,
    duration: float,
    repeats: int,
    limit: float = math.inf,
) -> Paced | None:
    """Measure how long one period of a run takes.

    The run is repeated, within `limit` s of wall time, and the least time of each period counts:
    disturbances by the machine are left out. None if no run was completed.
    """
    end = time.monotonic() + limit
    count = min(round(duration / period), _MOST_PERIODS)
    times = np.arange(1, count + 1, dtype=np.float64) * period
    least: Array | None = None
    for _ in range(repeats):
        spent = _paced(model, method, times, end)
        if spent is None:
            break
        least = spent if least is None else np.minimum(least, spent)
    if least is None or not count:
        return None
    excluded = max(int(_EXCLUDED * count), int(count >= _PERIODS_PER_OUTLIER))
    slowest = tuple(np.sort(least)[::-1][: excluded + 1].tolist())
    return Paced(slowest[-1], slowest, count)


def _paced(model: LoadedModel, method: Solver, times: Array, end: float) -> Array | None:
    """Time each interval between times, s of processor time, less the time of an empty call.

    None if the run fails, or goes on until `end` of the monotonic clock.
    """
    clock = time.thread_time
    row = np.empty((1, len(model.measured) + (len(ENERGY_ACCOUNTS) if model.accounts else 0)))
    spent = np.empty(len(times))
    with model.started(method, bool(model.accounts)) as instance:
        instance.run(np.zeros(1), row)
        idle = []
        for _ in range(50):
            start = clock()
            instance.run(np.zeros(1), row)
            idle.append(clock() - start)
        for k in range(len(times)):
            start = clock()
            status, _ = instance.run(times[k : k + 1], row)
            spent[k] = clock() - start
            late = k % _CLOCK_EVERY == 0 and time.monotonic() > end
            if status is not Status.OK or late:
                return None
    return np.maximum(spent - min(idle), 0.0)
