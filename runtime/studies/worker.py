"""The part of a study that runs in a Dask worker: building the model, and chunks of cases.

A worker imports this module to run a task, so it imports neither the compiler nor Dask.
"""

from __future__ import annotations

import pickle
import tempfile
import zlib
from pathlib import Path
from threading import Lock

from bgc.building.build import Unit, build_shared_object
from bgc.building.build_result import Built, Places, RunFacts
from bgc.building.cache import open_cache
from bgc.building.toolchain import find_toolchain
from bgc.diagnostics.catalogue.studies import cluster_unusable
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.observables import Observable
from bgc.runtime.running.batches import Outcome
from bgc.runtime.running.cases import Cases
from bgc.runtime.running.identity import bgc_version
from bgc.runtime.running.lane_interface import LaneLibrary
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.many import Plan
from bgc.runtime.studies.chunks import run_chunk

_MODELS = 8  # that a worker holds in memory

_held: dict[str, tuple[LoadedModel, LaneLibrary | None]] = {}  # by hash; of one worker process
_lock = Lock()


@dataclass(frozen=True, slots=True)
class Shipped:
    """A model as a task carries it: compressed C text and facts, and their hash."""

    key: str
    packed: bytes
    version: str


@dataclass(frozen=True, slots=True)
class Contents:
    """The contents of `Shipped.packed`: C text, facts and the files that devices read."""

    units: tuple[Unit, ...]
    facts: RunFacts
    places: Places
    files: tuple[tuple[str, bytes], ...]  # that devices read
    in_batches: bool


@dataclass(frozen=True, slots=True)
class Task:
    """A chunk to run: everything but the model."""

    first: int
    cases: Cases
    method: Solver
    times: Array
    alone: str
    varied: tuple[str, ...]
    observables: tuple[Observable, ...]
    between: int


def run_task(shipped: Shipped, task: Task) -> Outcome | tuple[Diagnostic, ...]:
    """Run a chunk in a worker; return diagnostics where the worker cannot build the model."""
    try:
        model, library = build_model(shipped)
    except BgError as problem:  # does not survive the way back as an exception
        return problem.diagnostics
    plan = Plan(
        model, task.method, task.cases, task.times, task.alone, task.varied, task.observables,
        task.between,
    )  # fmt: skip
    return run_chunk(plan, library, task.first, task.cases, threads=1)


def build_model(shipped: Shipped) -> tuple[LoadedModel, LaneLibrary | None]:
    """Build a model in this worker's cache, or take the one that it holds."""
    if shipped.version != bgc_version():
        reason = f"a worker has bgc {bgc_version()}, this process {shipped.version}"
        raise BgError([cluster_unusable("the workers", reason)])
    with _lock:
        if shipped.key not in _held:
            contents: Contents = pickle.loads(zlib.decompress(shipped.packed))
            path = build_shared_object(contents.units, find_toolchain(), open_cache())
            folder = Path(tempfile.mkdtemp(prefix="bgc-")) if contents.files else Path()
            for name, content in contents.files:
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes(content)
            model = LoadedModel(Built(path, contents.facts, places=contents.places), folder)
            while len(_held) >= _MODELS:
                del _held[next(iter(_held))]
            _held[shipped.key] = model, LaneLibrary(path) if contents.in_batches else None
        return _held[shipped.key]
