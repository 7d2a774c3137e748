"""A progress bar on the terminal for runs longer than a second."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

_AFTER_SECONDS = 1.0


class ProgressBar:
    """A bar for simulated time or other work, shown after one second.

    Nothing is drawn or imported unless `wanted` and standard error is a terminal.
    """

    def __init__(
        self, end: float, wanted: bool, label: str = "simulating", unit: str = " s"
    ) -> None:
        self._end = end
        self._label, self._unit = label, unit
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
        """Update the bar: the run has reached a time."""
        if not self._wanted or time.monotonic() - self._start < _AFTER_SECONDS:
            return
        if self._drawn is None:
            self._drawn = self._draw()
        bar, task = self._drawn
        bar.update(task, completed=reached)

    def _draw(self) -> tuple[Progress, TaskID]:
        # Slow to load, and only long runs on a terminal draw a bar.
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        bar = Progress(
            TextColumn(self._label),
            BarColumn(),
            TextColumn("{task.completed:.3g} of {task.total:.3g}" + self._unit),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        bar.start()
        return bar, bar.add_task(self._label, total=self._end)
