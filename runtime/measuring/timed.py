"""One run under a clock: rows, processor time, counts; stopped when it takes too long."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from threading import get_ident

import numpy as np

from bgc.building.built import ENERGY_ACCOUNTS
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, Status
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.run import Method, watched

_PACED = 60_000  # periods of a run that are looked at one by one


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """What came of a run.

    `status` is `done`, `stopped` at its limit, or with `message` `failed`, or `refused` before it
    started. `rows` hold the model's outputs, then the four energy accounts if they were wanted,
    those that were not reached as NaN. `seconds` is the processor time of the computation alone.
    """

    status: str
    message: str
    rows: Array
    seconds: float
    counts: dict[str, float]


def timed_run(
    model: LoadedModel,
    method: Method,
    times: Array,
    *,
    accounts: bool,
    limit: float,
    busy: float = math.inf,
    watch: Callable[[float], None] = lambda reached: None,
) -> Run:
    """Run a model from its start over all times, for at most `limit` seconds.

    And for at most `busy` seconds of processor time, which do not pass while others have the
    machine. `watch` is told now and then which time is reached. Ctrl-C stops the run and goes on
    up.
    """
    width = len(model.measured) + (len(ENERGY_ACCOUNTS) if accounts else 0)
    rows = np.full((len(times), width), np.nan)
    try:
        with model.started(method.with_capped_step(times, model.facts.timed), accounts) as instance:
            status, seconds, stopped = _run_in_thread(instance, times, rows, limit, busy, watch)
            counts = instance.counts
            if stopped and status is Status.INTERRUPTED:
                message = f"stopped at t = {instance.time:.3g} s: it takes too long"
                return Run("stopped", message, rows, seconds, counts)
            if status is not Status.OK:
                diagnostic = model.explain(instance, status)
                message = f"{diagnostic.code}: {diagnostic.message}"
                return Run("failed", message, rows, seconds, counts)
    except BgError as problem:
        first = problem.diagnostics[0]
        return Run("refused", f"{first.code}: {first.message}", rows, 0.0, {})
    if not np.isfinite(rows).all():
        return Run("failed", "BG712: an observed value is not finite", rows, seconds, counts)
    return Run("done", "", rows, seconds, counts)


def _run_in_thread(
    instance: Instance,
    times: Array,
    rows: Array,
    limit: float,
    busy: float,
    watch: Callable[[float], None],
) -> tuple[Status, float, bool]:
    """The status, the thread's processor time, and whether a limit was reached."""
    clocks: list[int] = []
    started = time.monotonic()
    stopped = False

    def run() -> tuple[Status, float]:
        if hasattr(time, "pthread_getcpuclockid"):  # not on every system
            clocks.append(time.pthread_getcpuclockid(get_ident()))
        start = time.thread_time()
        status, _ = instance.run(times, rows)
        return status, time.thread_time() - start

    def look() -> None:
        nonlocal stopped
        watch(instance.time)
        stopped = stopped or time.monotonic() - started > limit or _spent(clocks) > busy
        if stopped:
            instance.stop()

    (status, seconds), interrupted = watched(instance, run, look)
    if interrupted:
        raise KeyboardInterrupt
    return status, seconds, stopped


def _spent(clocks: Sequence[int]) -> float:
    """The processor time of the thread with that clock; 0 before it has one or after its end."""
    with suppress(OSError):
        return sum(map(time.clock_gettime, clocks))
    return 0.0


def paced_worst(
    model: LoadedModel, method: Method, period: float, duration: float, repeats: int
) -> float:
    """The longest that one period of a run takes, in s of the thread's processor time.

    The run is the same each time, so that of each period the least of `repeats` counts: what the
    machine did meanwhile is left out. 0 where a run could not be completed.
    """
    count = min(round(duration / period), _PACED)
    least = np.full(count, np.inf)
    for _ in range(repeats):
        spent = _paced(model, method, np.arange(1, count + 1, dtype=np.float64) * period)
        if spent is None:
            return 0.0
        least = np.minimum(least, spent)
    return float(np.max(least, initial=0.0))


def _paced(model: LoadedModel, method: Method, times: Array) -> Array | None:
    """The processor time of each interval between times, less that of a call which does nothing."""
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
            if status is not Status.OK:
                return None
    return np.maximum(spent - min(idle), 0.0)
