"""Run files of tests in a fork of a process that has loaded all packages but bgc."""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import resource
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

PACKAGES = """
pytest_asyncio.plugin pytest_lsp pytest_timeout _hypothesis_pytestplugin numpy scipy.linalg
scipy.integrate scipy.optimize scipy.interpolate scipy.stats sympy lark click jinja2 hypothesis
xarray pandas mujoco pinocchio pygls.lsp.server matplotlib.figure
""".split()
_MEMORY = 6 << 30  # bytes of data of one process


@dataclass(frozen=True, slots=True)
class Outcome:
    """`killed`, `survived`, `timeout` or `missing` (no such test).

    `failed` are the tests that failed, `seconds` the time by the clock.
    """

    kind: str
    failed: tuple[str, ...]
    seconds: float


def load_packages() -> None:
    """Import what tests use, so that no fork does; bgc itself stays out."""
    for name in PACKAGES:
        with contextlib.suppress(Exception):
            importlib.import_module(name)
    assert "bgc" not in sys.modules
    gc.freeze()  # else each fork copies what it counts


class _Notes:
    """A plugin that writes the tests that began and those that failed."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def note(self, what: str, name: str) -> None:
        with self.file.open("a", encoding="utf-8") as file:
            file.write(json.dumps([what, name]) + "\n")

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.note("begun", nodeid)

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            self.note("failed", report.nodeid)

    def pytest_collectreport(self, report: Any) -> None:
        if report.failed:
            self.note("failed", report.nodeid)


def run(work: Path, files: Sequence[str], left_out: Sequence[str], limit: float,
        stop: bool = True) -> Outcome:  # fmt: skip
    """Run the quick tests of files, or single tests, in a fork; `left_out` are names of tests.

    `limit` is in s of processor time, of which the clock may take ten times as much.
    """
    begun = time.monotonic()
    noted = work / "notes.txt"
    noted.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        chosen = [] if any("::" in file for file in files) else ["-m", "not slow"]
        _child(work, [*files, *chosen, *(f"--deselect={name}" for name in left_out)], limit, stop)
    with contextlib.suppress(OSError):
        os.setpgid(child, child)
    code = _await(child, begun + 10.0 * limit)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)  # what tests started
    lines = noted.read_text(encoding="utf-8").splitlines() if noted.exists() else []
    notes = [json.loads(line) for line in lines]
    failed = tuple(name for what, name in notes if what == "failed")
    seconds = time.monotonic() - begun
    if failed:
        return Outcome("killed", failed, seconds)
    if code is None or code == -signal.SIGXCPU:
        return Outcome("timeout", (), seconds)
    if code in (0, pytest.ExitCode.NO_TESTS_COLLECTED):
        return Outcome("survived", (), seconds)
    if "not found: " in (work / "output.txt").read_text(encoding="utf-8"):
        return Outcome("missing", (), seconds)
    last = notes[-1][1] if notes else "import"
    return Outcome("killed", (last,), seconds)  # a crash


def _await(child: int, end: float) -> int | None:
    """The exit code of a child, or None where it took too long."""
    pause = 0.01
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(pause)
        pause = min(0.1, 1.3 * pause)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def _child(work: Path, arguments: list[str], limit: float, stop: bool) -> None:
    code = 1
    try:
        os.setpgid(0, 0)
        with (work / "output.txt").open("w") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, _MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 1))
        options = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", f"--basetemp={work / 'tmp'}"]
        plugins = [_Notes(work / "notes.txt")]
        code = int(pytest.main([*options, *(["-x"] if stop else []), *arguments], plugins))
    finally:
        sys.stdout.flush()
        os._exit(code)
