"""Run tests in a fork of the process that has collected them, until one fails."""

from __future__ import annotations

import contextlib
import ctypes
import os
import resource
import select
import signal
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

_MEMORY = 6 << 30  # bytes of data of one process
_SILENCE = 60.0  # s of the clock without progress, beyond the processor time of the test


@dataclass(frozen=True, slots=True)
class Outcome:
    """`survived`, `killed` or `timeout`; the test that ended it, and the processor time."""

    kind: str
    test: str
    seconds: float
    passed: dict[str, float]  # processor times of tests that passed
    failed: tuple[str, ...]


def run_items(
    items: Sequence[pytest.Item],
    limits: dict[str, float],
    log: Path,
    before: Callable[[], None],
    after: Callable[[], None] | None = None,
    stop: bool = True,
) -> Outcome:
    """Fork, call `before`, run the tests; `limits` are processor times of tests by name.

    `after` is called in the fork, and C's own functions at exit then run.
    """
    begun = _children_time()
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        _child(items, limits, log, before, after, stop, writer)
    os.close(writer)
    os.setpgid(child, child)
    lines = _watch(child, reader, items, limits)
    if after is not None:
        _await_end(child)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)  # what tests started
    _, status = os.waitpid(child, 0)
    seconds = _children_time() - begun
    passed = {name: float(took) for what, took, name in lines if what == "passed"}
    failed = tuple(name for what, _, name in lines if what == "failed")
    if failed:
        return Outcome("killed", failed[0], seconds, passed, failed)
    if any(what == "ended" for what, _, _ in lines):
        return Outcome("survived", "", seconds, passed, failed)
    at = next((name for what, _, name in reversed(lines) if what == "begun"), "")
    hung = os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGPROF, signal.SIGKILL)
    return Outcome("timeout" if hung else "killed", at, seconds, passed, failed)


def _time() -> float:
    """Processor time of this process and of those that it started."""
    return sum(os.times()[:4])


def _children_time() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _watch(
    child: int, reader: int, items: Sequence[pytest.Item], limits: dict[str, float]
) -> list[list[str]]:
    """The text that the child wrote until it ended or was silent for too long."""
    text = b""
    longest = 4.0 * max((limits.get(item.nodeid, 5.0) for item in items), default=5.0) + _SILENCE
    end = time.monotonic() + longest
    while time.monotonic() < end:
        ready, _, _ = select.select([reader], [], [], 0.5)
        if ready:
            part = os.read(reader, 65536)
            if not part:
                break
            text += part
            end = time.monotonic() + longest
            if text.endswith(b"done\n"):
                break
    else:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
    os.close(reader)
    return [line.split("\t") for line in text.decode().splitlines() if line.count("\t") == 2]


def _await_end(child: int) -> None:
    """Let a process that has said its last end by itself, with a limit."""
    for _ in range(600):
        if os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None:
            return
        time.sleep(0.05)


class _Reports:
    """A plugin that notes failures."""

    def __init__(self) -> None:
        self.failed = False

    def pytest_runtest_logreport(self, report: Any) -> None:
        self.failed = self.failed or report.failed
        if report.failed:
            print(report.nodeid, report.longrepr, flush=True)


def _child(
    items: Sequence[pytest.Item],
    limits: dict[str, float],
    log: Path,
    before: Callable[[], None],
    after: Callable[[], None] | None,
    stop: bool,
    writer: int,
) -> None:
    code = 1
    try:
        os.setpgid(0, 0)
        with log.open("w") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, _MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        reports = _Reports()
        if items:
            items[0].config.pluginmanager.register(reports)

        def say(what: str, took: float, item: str) -> None:
            os.write(writer, f"{what}\t{took:.4f}\t{item}\n".encode())

        before()
        for item, following in zip(items, [*items[1:], None][: len(items)], strict=True):
            reports.failed = False
            used = _time()
            # Processes that the test starts do not inherit a timer, as they would a limit.
            signal.setitimer(signal.ITIMER_PROF, limits.get(item.nodeid, 60.0))
            say("begun", 0.0, item.nodeid)
            item.ihook.pytest_runtest_protocol(item=item, nextitem=following)
            say("failed" if reports.failed else "passed", _time() - used, item.nodeid)
            if reports.failed and stop:
                break
        if after is not None:
            after()
        say("ended", 0.0, "")
        code = 0
    except BaseException as problem:
        print("the run of the tests failed:", repr(problem), flush=True)
    finally:
        with contextlib.suppress(Exception):
            sys.stdout.flush()
        if after is not None and code == 0:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            os.close(writer)
            ctypes.CDLL(None).exit(0)
        os.write(writer, b"done\n")
        os._exit(code)
