"""Chunks of a study: runs of some cases on this machine or another one, and their results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.batches import Outcome, run_all
from bgc.runtime.running.cases import Cases
from bgc.runtime.running.examination import examine
from bgc.runtime.running.lane_interface import LaneLibrary
from bgc.runtime.running.many import Plan

BATCH = 8  # cases that stay together: a multiple of the instances of a batch on every machine
SECONDS = 1.0  # of processor time that a chunk is to take on each thread
_LARGEST_CHUNK = 65536  # cases of a chunk


def run_chunk(
    plan: Plan, library: LaneLibrary | None, first: int, cases: Cases, threads: int = 0
) -> Outcome:
    """Run some cases of a plan; `library` is that of the batches."""
    work = plan.work(library, cases)
    run_all(work, progress=False, threads=threads)
    examine(work)
    return work.outcome(first)


def refused(first: int, plan: Plan, count: int, why: Diagnostic) -> Outcome:
    """Make the result of cases that ended every process that ran them."""
    varied = [plan.cases.names.index(name) for name in plan.varied]
    return Outcome(
        first=first,
        values=plan.cases.values[first : first + count, varied],
        reduced=np.full((count, len(plan.observables)), np.nan),
        failures=dict.fromkeys(range(count), why),
    )


class Waiting:
    """The cases that are still to be run, handed out in chunks of about a second a thread.

    Processor time counts: on a busy machine chunks by the clock would be ever smaller, and their
    tasks cost more than their runs.

    A chunk begins at a multiple of `BATCH`, so that its batches are those of a run of all cases,
    and have the same bits.
    """

    def __init__(self, count: int, done: Sequence[bool] | Array) -> None:
        blocks = np.zeros(-(-count // BATCH) * BATCH, dtype=bool)
        blocks[:count] = done
        blocks[count:] = True
        waiting = ~blocks.reshape(-1, BATCH).all(axis=1)
        self._count = count
        self._starts = [int(k) * BATCH for k in np.flatnonzero(waiting)]
        self._next = 0
        self._each = 0.0  # seconds of processor time of a case, of the last chunks

    def __bool__(self) -> bool:
        return self._next < len(self._starts)

    def learn(self, chunk: Outcome) -> None:
        """Note how long the cases of a chunk took."""
        if len(chunk.values):
            each = chunk.seconds / len(chunk.values)
            self._each = each if self._each == 0 else 0.5 * (self._each + each)

    def take(self, workers: int = 1) -> range:
        """The numbers of the cases of the next chunk, for so many threads."""
        wanted = BATCH * workers
        if self._each > 0:
            wanted = int(SECONDS * workers / self._each)
        blocks = max(1, min(wanted, _LARGEST_CHUNK) // BATCH)
        begin = self._starts[self._next]
        taken = 0
        while taken < blocks and self:
            if self._starts[self._next] != begin + taken * BATCH:
                break
            self._next += 1
            taken += 1
        return range(begin, min(begin + taken * BATCH, self._count))


def locally(
    plan: Plan, library: LaneLibrary | None, waiting: Waiting, threads: int
) -> Iterator[Outcome]:
    """Run what is waiting on this machine, chunk by chunk."""
    while waiting:
        numbers = waiting.take(threads)
        part = plan.cases.part(slice(numbers.start, numbers.stop))
        chunk = run_chunk(plan, library, numbers.start, part, threads)
        waiting.learn(chunk)
        yield chunk
        if chunk.stopping:
            raise KeyboardInterrupt
