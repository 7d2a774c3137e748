"""Compilations beside a live run, in a process of their own.

A compilation holds Python's lock, so that a run in the same process would stand still meanwhile.
The process leads a session, so that Ctrl-C in the terminal does not reach it; it is killed instead.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.options import Options
from bgc.record_class import dataclass

_PROGRAM = "from bgc.runtime.view.aside import work; work()"


@dataclass(frozen=True, slots=True)
class Request:
    """A request to compile a scene with its graph (`graph`), or as it runs (`model`)."""

    kind: str
    path: Path
    options: Options


@dataclass(frozen=True, slots=True)
class Answer:
    """The result of a request, or the reasons why there is none.

    Without either the process has failed, and has written why to the standard error.
    """

    result: Any = None
    diagnostics: tuple[Diagnostic, ...] = ()


class Aside:
    """One compilation at a time; a new request ends the one before."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None

    def ask(self, request: Request, done: Callable[[Answer], None]) -> None:
        """Begin a compilation; `done` is called in a thread, unless `end` comes before."""
        self.end()
        process = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        self._process = process
        Thread(target=self._wait, args=(process, request, done), daemon=True).start()

    def _wait(
        self,
        process: subprocess.Popen[bytes],
        request: Request,
        done: Callable[[Answer], None],
    ) -> None:
        output, _ = process.communicate(pickle.dumps(request))
        if self._process is not process:
            return  # ended
        self._process = None
        # The output is that of a process that this one has started.
        done(pickle.loads(output) if process.returncode == 0 else Answer())

    def end(self) -> None:
        """Kill a compilation that has not ended."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()


def work() -> None:
    """Answer the request on the standard input: the program of the process."""
    request: Request = pickle.loads(sys.stdin.buffer.read())
    output = sys.stdout.buffer
    sys.stdout = sys.stderr
    with suppress(BrokenPipeError):  # the command has ended meanwhile
        output.write(pickle.dumps(_answer(request)))
        output.flush()


def _answer(request: Request) -> Answer:
    # Each request needs one of them, and the compiler takes long to load.
    try:
        if request.kind == "graph":
            from bgc.runtime.view.graph_page import graph_of_scene

            return Answer(graph_of_scene(request.path, request.options))
        from bgc.runtime.running.model_loading import load_or_compile

        return Answer(load_or_compile(request.path, request.options))
    except BgError as problem:
        return Answer(diagnostics=tuple(problem.diagnostics))
