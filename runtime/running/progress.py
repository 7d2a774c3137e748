"""A progress bar on the terminal for runs that take longer than a moment."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

_AFTER_SECONDS = 1.0


class ProgressBar:
    """Shows how much of the simulated time (or of other work) is done, after one second.

    Nothing is drawn, and nothing loaded, unless `wanted` and standard error is a terminal.
    """

    def __init__(
        self, end: float, wanted: bool, what: str = "simulating", unit: str = " s"
    ) -> None:
        self._end = end
        self._what, self._unit = what, unit
        self._start = time.monotonic()
        self._wanted = wanted and sys.stderr.isatty()
        self._drawn: tuple[Progress, TaskID] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._drawn is not None:
            self._drawn[0].stop()

    def show(self, reached: float) -> None:
        """Draw that the run has reached a time."""
        if not self._wanted or time.monotonic() - self._start < _AFTER_SECONDS:
            return
        if self._drawn is None:
            self._drawn = self._draw()
        bar, task = self._drawn
        bar.update(task, completed=reached)

    def _draw(self) -> tuple[Progress, TaskID]:
        # Slow to load: a bar is drawn for long runs on a terminal alone.
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        bar = Progress(
            TextColumn(self._what),
            BarColumn(),
            TextColumn("{task.completed:.3g} of {task.total:.3g}" + self._unit),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        bar.start()
        return bar, bar.add_task(self._what, total=self._end)
