"""Numbered cases in worker processes, each under limits of processor time and memory.

A worker takes the cases of a portion in their order and writes one line for each. A case that ends
its worker (a signal, the limit of processor time) is a fault of that case, and another worker goes
on behind it.
"""

from __future__ import annotations

import faulthandler
import gc
import json
import os
import resource
import signal
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TypeAlias

from judging import CPU_SECONDS, MEMORY, Verdict

Judge: TypeAlias = Callable[[int, Path], list[Verdict]]

WALL_SECONDS = 300  # for what waits without using the processor
_SHOWN = 3_000  # characters of a fault's detail


@dataclass(slots=True)
class Portion:
    """The outcomes of a range of cases."""

    first: int
    size: int
    outcomes: Counter[str] = field(default_factory=Counter)
    codes: Counter[str] = field(default_factory=Counter)
    faults: list[tuple[int, str, str]] = field(default_factory=list)

    def note(self, number: int, verdict: Verdict) -> None:
        self.outcomes[verdict.outcome] += 1
        self.codes.update(verdict.codes)
        if verdict.is_listed:
            self.faults.append((number, verdict.outcome, verdict.detail))


def run_portion(first: int, size: int, judge: Judge, folder: Path) -> Portion:
    """Judge the cases `first` to `first + size - 1`."""
    portion = Portion(first, size)
    begin = first
    while begin < first + size:
        done = begin
        for number, verdict in _worker(begin, first + size, judge, folder):
            portion.note(number, verdict)
            done = number
        begin = done + 1
    return portion


def _worker(begin: int, end: int, judge: Judge, folder: Path) -> Iterator[tuple[int, Verdict]]:
    """Judge cases in a child process; if one ends the child, its verdict is the last."""
    reading, writing = os.pipe()
    with tempfile.TemporaryFile("w+") as stack:
        child = os.fork()
        if child == 0:
            os.close(reading)
            _work(begin, end, judge, folder, os.fdopen(writing, "w", buffering=1), stack.fileno())
        os.close(writing)
        current = begin
        with os.fdopen(reading) as lines:
            for line in lines:
                number, verdict = json.loads(line)
                if verdict is None:
                    current = number
                else:
                    verdict["codes"] = tuple(verdict["codes"])
                    yield number, Verdict(**verdict)
        _, status = os.waitpid(child, 0)
        if os.WIFSIGNALED(status) or os.WEXITSTATUS(status):
            stack.seek(0)
            yield current, _ended(status, stack.read())


def _work(begin: int, end: int, judge: Judge, folder: Path, out, stack: int) -> None:
    """Judge cases and exit; never returns."""
    status = 1
    try:
        faulthandler.enable(stack)
        faulthandler.register(signal.SIGPROF, stack, all_threads=False, chain=True)
        for number in range(begin, end):
            print(json.dumps((number, None)), file=out)
            gc.collect(0)
            _limit()
            for verdict in judge(number, folder):
                print(json.dumps((number, asdict(verdict))), file=out)
        status = 0
    except MemoryError:  # in the judge itself
        status = 3
    finally:
        out.flush()
        os._exit(status)


def _limit() -> None:
    """Set the limits of the next case: processor time, time and memory."""
    signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS)
    signal.setitimer(signal.ITIMER_REAL, WALL_SECONDS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.RLIM_INFINITY))


def _ended(status: int, stack: str) -> Verdict:
    """Name the end of a worker: over the limit of time, out of memory, or a crash."""
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        if number in (signal.SIGPROF, signal.SIGALRM):
            return Verdict("hang", (), stack[:_SHOWN])
        return Verdict("died", (), f"signal {number}\n{stack[:_SHOWN]}")
    return Verdict("memory" if os.WEXITSTATUS(status) == 3 else "died", (), stack[:_SHOWN])


# --- the results so far -----------------------------------------------------------------


def kept_portions(path: Path) -> dict[int, Portion]:
    """The portions of a file of results, by their first case."""
    if not path.exists():
        return {}
    kept = {}
    for line in path.read_text("utf-8").splitlines():
        row = json.loads(line)
        row["outcomes"], row["codes"] = Counter(row["outcomes"]), Counter(row["codes"])
        row["faults"] = [tuple(fault) for fault in row["faults"]]
        kept[row["first"]] = Portion(**row)
    return kept


def keep_portion(path: Path, portion: Portion) -> None:
    with path.open("a", encoding="utf-8") as file:
        row = {name: getattr(portion, name) for name in Portion.__slots__}
        file.write(json.dumps(row) + "\n")


def summary(portions: list[Portion]) -> str:
    """Tabulate the outcomes of all portions, and list the faults."""
    outcomes = sum((p.outcomes for p in portions), Counter())
    codes = sum((p.codes for p in portions), Counter())
    lines = [f"{sum(p.size for p in portions):,} cases, {len(codes)} different codes"]
    lines += [f"  {name:<12} {count:>8,}" for name, count in sorted(outcomes.items())]
    for portion in portions:
        for number, outcome, detail in portion.faults:
            last = detail.strip().splitlines()[-1] if detail.strip() else ""
            lines.append(f"  case {number}: {outcome}: {last[:200]}")
    return "\n".join(lines)
