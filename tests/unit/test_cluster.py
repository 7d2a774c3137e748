"""Studies in a store and on Dask workers: the bits of threads, killed workers, resumption."""

from __future__ import annotations

import errno
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from model_files import model_file

import bgc
from bgc.building.recall import processors
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.model import Model
from bgc.runtime.results.runs import Interrupted
from bgc.runtime.running import batches
from bgc.runtime.running.cases import checked_cases
from bgc.runtime.running.many import plan_many
from bgc.runtime.running.simulate import method_of, times_of
from bgc.runtime.studies import chunks, cluster, study_store, worker
from bgc.runtime.studies.chunks import Waiting
from bgc.runtime.studies.sweep import observables_of

zarr = pytest.importorskip("zarr")
distributed = pytest.importorskip("distributed")

# Adaptive, so that bits depend on the cases that share a batch; the stiffest springs tear.
OBSERVE = ["max(x)", "rms(v)"]
VARY = {"k": "5..80 N/m:50", "mass": [1.0, 1.5]}


@pytest.fixture(scope="module")
def model() -> Model:
    return bgc.compile(model_file("cluster"))


@pytest.fixture(scope="module")
def whole(model: Model):
    return model.sweep(VARY, OBSERVE)


@pytest.fixture
def scheduler() -> Iterator[distributed.LocalCluster]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as local:
        yield local


def equal(found, whole) -> None:
    assert found.status == whole.status and found.design == whole.design
    assert 0 < found.status.count("failed") < len(found)
    np.testing.assert_array_equal(found.values, whole.values)
    np.testing.assert_array_equal(found["k"], whole["k"])
    assert found.failures.keys() == whole.failures.keys()
    assert next(iter(found.failures.values())).code == next(iter(whole.failures.values())).code


@pytest.mark.slow
def test_a_killed_worker_loses_nothing_and_the_bits_are_those_of_threads(
    model, whole, scheduler, monkeypatch, tmp_path
):
    monkeypatch.setattr(chunks, "SECONDS", 0.0)  # a batch in each chunk
    original, written = study_store.Store.write, []

    def write(self, chunk):
        original(self, chunk)
        written.append(chunk.first)
        if len(written) == 2:
            with distributed.Client(scheduler.scheduler_address, set_as_default=False) as client:
                victim = next(iter(client.run(os.getpid).values()))
            os.kill(victim, signal.SIGKILL)

    monkeypatch.setattr(study_store.Store, "write", write)
    out = tmp_path / "study.zarr"
    address = scheduler.scheduler_address
    found = model.sweep(VARY, OBSERVE, scheduler=address, store=out)
    equal(found, whole)
    assert sorted(written) == list(range(0, 100, 8)) and found.together == whole.together
    group = zarr.open_group(str(out), mode="r")
    assert (group["status"][:] > 0).all() and group["observables"].attrs["units"] == ["m", "m/s"]
    np.testing.assert_array_equal(group["observables"][:], whole.values)
    rows = model.sweep({"k": "5..80 N/m:9"}, scheduler=address)
    np.testing.assert_array_equal(rows.values, model.sweep({"k": "5..80 N/m:9"}).values)


def test_a_store_goes_on_where_it_was_interrupted_and_refuses_others(
    model, whole, monkeypatch, tmp_path
):
    out = tmp_path / "study.zarr"
    monkeypatch.setattr(chunks, "SECONDS", 0.0)
    original, ran = batches.Work.run_batch, []

    def interrupted(work, start):
        original(work, start)
        ran.append(start)
        if len(ran) == 2 * processors():
            work.stopping = True

    with monkeypatch.context() as patch:
        patch.setattr(batches.Work, "run_batch", interrupted)
        with pytest.raises(Interrupted) as caught:
            model.sweep(VARY, OBSERVE, store=out)
    done = len(whole) - caught.value.result.status.count("interrupted")
    assert caught.value.kept and 0 < done < len(whole)
    found = model.sweep(VARY, OBSERVE, store=out)
    equal(found, whole)
    assert done - 8 * processors() <= found.recalled <= done
    monkeypatch.setattr(batches.Work, "run_batch", None)  # nothing is left to run
    equal(model.sweep(VARY, OBSERVE, store=out), whole)
    for other in ({"vary": {"k": "5..81 N/m:50"}}, {"observe": ["min(x)"]}):
        with pytest.raises(BgError, match="BG789"):
            model.sweep(**{"vary": VARY, "observe": OBSERVE, **other}, store=out)
    with monkeypatch.context() as patch:  # another process has made it just now
        exists = Path.exists
        patch.setattr(Path, "exists", lambda path: path != out and exists(path))
        with pytest.raises(BgError, match="BG789"):
            model.sweep(VARY, ["min(x)"], store=out)
    (tmp_path / "other.zarr").mkdir()
    with pytest.raises(BgError, match="BG789"):
        model.sweep(VARY, OBSERVE, store=tmp_path / "other.zarr")


def test_a_damaged_store_is_refused_and_lost_numbers_are_computed_again(model, whole, tmp_path):
    out = tmp_path / "study.zarr"
    model.sweep(VARY, OBSERVE, store=out)
    (numbers,) = (file for file in out.glob("observables/c/*/*"))
    kept = numbers.read_bytes()
    numbers.write_bytes(kept[:20])
    with pytest.raises(BgError, match=r"BG789.*it is damaged"):
        model.sweep(VARY, OBSERVE, store=out)
    numbers.unlink()
    found = model.sweep(VARY, OBSERVE, store=out)
    equal(found, whole)
    assert found.recalled == whole.status.count("failed")
    (out / "status" / "zarr.json").unlink()
    with pytest.raises(BgError, match=r"BG789.*it is damaged"):
        model.sweep(VARY, OBSERVE, store=out)


def test_a_full_disk_and_a_silent_scheduler_are_errors(model, monkeypatch, tmp_path):
    def full(self, *arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(zarr.Array, "__setitem__", full)
        with pytest.raises(BgError, match=r"BG055.*No space left"):
            model.sweep(VARY, OBSERVE, store=tmp_path / "study.zarr")
    (tmp_path / "file").touch()
    with pytest.raises(BgError, match="BG055"):
        model.sweep(VARY, OBSERVE, store=tmp_path / "file" / "study.zarr")
    monkeypatch.setattr("bgc.runtime.studies.cluster._TIMEOUT", 0.2)
    with pytest.raises(BgError, match=r"BG799.*does not answer.*`dask scheduler`"):
        model.sweep(VARY, OBSERVE, scheduler="tcp://127.0.0.1:9")
    for address in ("nowhere", "tcp://nowhere", "tcp://:8786", "tcp://nowhere:port"):
        with pytest.raises(BgError, match=r"BG799.*not of the form tcp://HOST:PORT"):
            model.sweep(VARY, OBSERVE, scheduler=address)


def test_chunks_begin_where_batches_do():
    done = np.zeros(50, dtype=bool)
    done[8:24] = True
    done[30] = True
    waiting, taken = Waiting(50, done), []
    while waiting:
        taken.append(waiting.take(2))
    assert taken == [range(8), range(24, 40), range(40, 50)]


class KilledWorker(Exception):
    """The name that Dask gives to a task that ended several workers."""


class Future:
    """A task that ran where it was submitted, or ended every worker."""

    def __init__(self, task, killed: bool) -> None:
        self.task, self.status = task, "error" if killed else "finished"

    def exception(self) -> Exception:
        return KilledWorker()

    def result(self):
        shipped, task = self.task
        return worker.run_task(shipped, task)

    def release(self) -> None:
        pass


class Client:
    """The part of Dask's client that a study uses; the tasks with run 21 are killed."""

    loop = None

    def submit(self, function, shipped, task, pure):
        numbers = range(task.first, task.first + len(task.cases))
        return Future((shipped, task), 21 in numbers)

    def nthreads(self):
        return {"worker": 1}


class Ended(list):
    def __init__(self, **_) -> None:
        super().__init__()

    add = list.append

    def __next__(self):
        return self.pop()


def test_runs_that_end_every_worker_are_failed_and_the_others_are_done(model, monkeypatch):
    cases = checked_cases({"k": np.linspace(20, 80, 60)}, model.parameters)
    method, _ = method_of(model)
    observables = observables_of(model, OBSERVE)
    plan = plan_many(model, method, cases, times_of(model, method), True, observables)
    waiting = Waiting(60, np.zeros(60, dtype=bool))
    waiting._each = 0.02  # 48 runs in the first chunk
    work = plan.work(None)
    for chunk in cluster._results(plan, cluster.ship(plan), Client(), Ended, waiting, "tcp://a"):
        work.add(chunk)
    assert sorted(work.failures) == list(range(16, 24))
    assert {why.code for why in work.failures.values()} == {"BG799"}
    assert work.completed == {*range(16), *range(24, 60)}
    assert np.isfinite(work.reduced[sorted(work.completed)]).all()
    assert np.isnan(work.reduced[16:24]).all() and work.values[20, 0] == cases.values[20, 0]


def test_a_worker_of_another_version_is_refused(model):
    with pytest.raises(BgError, match="BG799"):
        worker.build_model(worker.Shipped("key", b"", "0.0.0"))
