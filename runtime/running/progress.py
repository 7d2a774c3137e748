"""Progress on the terminal: a bar for long runs, a line for a compilation."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Self, TypeVar

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID
    from rich.status import Status

_AFTER_SECONDS = 1.0

_Item = TypeVar("_Item")


class _OnTerminal:
    """What is drawn on the terminal during a `with` statement.

    Nothing is drawn or imported unless `wanted` and standard error is a terminal.
    """

    def __init__(self, wanted: bool) -> None:
        self._wanted = wanted and sys.stderr is not None and sys.stderr.isatty()
        self._drawn: Progress | Status | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        if self._drawn is not None:
            with suppress(OSError):  # the terminal was closed
                self._drawn.stop()


class ProgressBar(_OnTerminal):
    """A bar for simulated time or other work, shown after one second."""

    def __init__(
        self, end: float, wanted: bool, label: str = "simulating", unit: str = " s"
    ) -> None:
        super().__init__(wanted)
        self._end = end
        self._label, self._unit = label, unit
        self._start = time.monotonic()
        self._bar: tuple[Progress, TaskID] | None = None

    def show(self, reached: float) -> None:
        """Update the bar: the run has reached a time."""
        if not self._wanted or time.monotonic() - self._start < _AFTER_SECONDS:
            return
        try:
            bar, task = self._bar = self._bar or self._draw()
            bar.update(task, completed=reached)
        except OSError:  # the terminal was closed, and the run goes on
            self._wanted = False

    def _draw(self) -> tuple[Progress, TaskID]:
        # Slow to load, and only long runs on a terminal draw a bar.
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        self._drawn = bar = Progress(
            TextColumn(self._label),
            BarColumn(),
            TextColumn("{task.completed:.3g} of {task.total:.3g}" + self._unit),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        bar.start()
        return bar, bar.add_task(self._label, total=self._end)


def tracked(items: Sequence[_Item], wanted: bool, label: str, unit: str = "") -> Iterator[_Item]:
    """Go through items of work with a bar that counts them."""
    with ProgressBar(float(len(items)), wanted, label, unit) as bar:
        for count, item in enumerate(items):
            bar.show(count)
            yield item


class StatusLine(_OnTerminal):
    """A line on the terminal that says what goes on at present."""

    _line: Status | None = None

    def show(self, text: str) -> None:
        """Replace the text of the line."""
        if not self._wanted:
            return
        if self._line is None:
            # Slow to load, and a model from the cache does without it.
            from rich.console import Console

            self._drawn = self._line = Console(stderr=True, highlight=False).status(
                text, spinner="line"
            )
            self._line.start()
        self._line.update(text)


class CompilingLine(StatusLine):
    """A line that names the stage of a compilation, for the first run of a model.

    An object is called with each stage as it begins; nothing is drawn for a model that is taken
    from the cache.
    """

    def __init__(self, name: str, wanted: bool) -> None:
        super().__init__(wanted)
        self._name = name

    def __call__(self, stage: str) -> None:
        """Show the stage that begins."""
        self.show(f"compiling {self._name} (first time): {stage}")
