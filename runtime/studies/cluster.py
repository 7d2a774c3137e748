"""Chunks of a study on the workers of a Dask scheduler.

Each task carries the C text of the model with its hash. A worker (`worker.py`) compiles it on
first use, for its own processor and into its own cache, so a worker that joins late or replaces a
killed one needs nothing from anywhere else. Cases that end every worker that runs them are reported
as failed.
"""

from __future__ import annotations

import pickle
import zlib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import PurePath
from typing import Any

from bgc.building.cache import digest_of_bytes
from bgc.diagnostics.catalogue.ensembles import source_changed
from bgc.diagnostics.catalogue.studies import cluster_unusable
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene, model_units
from bgc.emission.emit import content_of
from bgc.runtime.results.columns import optional_package
from bgc.runtime.running.batches import Outcome
from bgc.runtime.running.identity import bgc_version, device_files
from bgc.runtime.running.many import Plan, lane_options
from bgc.runtime.studies.chunks import BATCH, Waiting, refused
from bgc.runtime.studies.worker import Contents, Shipped, Task, run_task

_TIMEOUT = 10.0  # s, for the scheduler to answer, and for its first worker
_AHEAD = 2  # chunks for each thread of the workers


def ship(plan: Plan) -> Shipped:
    """Pack the C text of a model; BG742 if its source changed."""
    model = plan.model
    if model.origin is None:
        raise BgError([cluster_unusable("tcp", "the model has no source to compile from")])
    path, options = model.origin
    options = replace(options, preview=False)
    options = options if plan.alone else lane_options(options)
    emitted = compile_scene(path, options, until="emit").emitted
    if content_of(emitted) != model.facts.content:
        raise BgError([source_changed(str(path))])
    inside = (
        (name, found.read_bytes())
        for name, found in device_files(model)
        if not PurePath(name).is_absolute() and ".." not in PurePath(name).parts
    )
    contents = Contents(
        model_units(emitted, options), model.facts, model.places, tuple(inside), not plan.alone
    )
    packed = zlib.compress(pickle.dumps(contents), 6)
    return Shipped(digest_of_bytes(packed), packed, bgc_version())


def on_cluster(plan: Plan, address: str, waiting: Waiting) -> Iterator[Outcome]:
    """Run what is waiting on the workers of a scheduler; yield chunks as they end, in any order.

    Raises BgError: BG058 without Dask, BG799 where the scheduler or its workers cannot be used.
    """
    distributed = optional_package("distributed", "`--scheduler`", "cluster")
    if not waiting:
        return
    shipped = ship(plan)
    host, colon, port = address.rpartition("://")[2].rpartition(":")
    if not (host and colon and port.isdecimal()):
        # Dask's client would be left half made, and end with a traceback 20 s later.
        reason = "it is not of the form tcp://HOST:PORT"
        raise BgError([cluster_unusable(address, reason, "write it as `dask scheduler` prints it")])
    try:
        client = distributed.Client(address, timeout=_TIMEOUT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as problem:
        silent = isinstance(problem, OSError | TimeoutError)
        reason = "it does not answer" if silent else str(problem)
        way_out = "start `dask scheduler` there, and give the address that it prints"
        raise BgError([cluster_unusable(address, reason, way_out)]) from problem
    try:
        try:
            client.wait_for_workers(1, timeout=_TIMEOUT)
        except TimeoutError as problem:
            raise BgError([cluster_unusable(address, "it has no workers")]) from problem
        yield from _results(plan, shipped, client, distributed.as_completed, waiting, address)
    finally:
        with suppress(Exception):  # the scheduler may have gone
            client.close(timeout=1)


def _results(
    plan: Plan, shipped: Shipped, client: Any, as_completed: Any, waiting: Waiting, address: str
) -> Iterator[Outcome]:
    running: dict[Any, range] = {}
    ended = as_completed(loop=client.loop, with_results=False)

    def submit(numbers: range) -> None:
        task = Task(
            numbers.start, plan.cases.part(slice(numbers.start, numbers.stop)), plan.method,
            plan.times, plan.alone, plan.varied, plan.observables, plan.between,
        )  # fmt: skip
        future = client.submit(run_task, shipped, task, pure=False)
        running[future] = numbers
        ended.add(future)

    def fill() -> None:
        threads = sum(client.nthreads().values())
        while waiting and len(running) < _AHEAD * max(threads, 1):
            submit(waiting.take())

    fill()
    while running:
        future = next(ended)
        numbers = running.pop(future)
        if future.status == "finished":
            found = future.result()
            if not isinstance(found, Outcome):
                raise BgError(found)
            waiting.learn(found)
            yield found
        elif future.status == "error" and type(future.exception()).__name__ == "KilledWorker":
            if len(numbers) > BATCH:
                for start in range(numbers.start, numbers.stop, BATCH):
                    submit(range(start, min(start + BATCH, numbers.stop)))
            else:
                why = cluster_unusable(address, "this run ended every worker that began it")
                yield refused(numbers.start, plan, len(numbers), why)
        else:
            error = future.exception() if future.status == "error" else None
            reason = str(error) if error else "it has ended"
            raise BgError([cluster_unusable(address, reason)])
        future.release()
        fill()
