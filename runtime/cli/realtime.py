"""Options and live view that the commands in real time share."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeVar

import click

from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.realtime.loop import Realtime
from bgc.runtime.realtime.options import RealtimeOptions
from bgc.runtime.realtime.report import Report
from bgc.runtime.running.quantity import read_quantity

if TYPE_CHECKING:
    from rich.console import Group
    from rich.live import Live
    from rich.table import Table

    from bgc.runtime.cli.keys import Menu

_Command = TypeVar("_Command", bound=Callable[..., Any])

# Option, field of RealtimeOptions, unit, text.
_LIMITS = (
    (
        "--max-force",
        "max_force",
        "N",
        "Largest force, such as 5 N; the device's own limit applies too.",
    ),
    ("--max-torque", "max_torque", "N*m", "Largest torque."),
    ("--max-gripper-force", "max_gripper_force", "N", "Largest force of the gripper."),
    ("--max-force-rate", "max_force_rate", "N/s", "Fastest change of the force."),
    ("--max-power", "max_power", "W", "Largest power into the hand."),
    ("--ramp", "ramp", "s", "Time in which the force rises (0.5 s)."),
    ("--stale", "stale", "s", "Longest time without new data from a device with motors (0.1 s)."),
    ("--watchdog", "watchdog", "s", "Longest time without a sample (0.1 s)."),
)
_MOST_VALUES = 12
_VIEWS_PER_SECOND = 10


def realtime_options(command: _Command) -> _Command:
    """Add the limits of the loop; `read_limits` converts them."""
    for option, _, _, text in reversed(_LIMITS):
        command = click.option(option, metavar="VALUE", help=text)(command)
    dead_man = "Button without which there is no force: 1 to 8."
    command = click.option("--dead-man", type=int, metavar="BUTTON", help=dead_man)(command)
    burst = "Number of missed deadlines that ends the loop (100 with motors); 0: no limit."
    command = click.option("--burst", type=float, metavar="COUNT", help=burst)(command)
    policy = "Treatment of missed periods, in place of that in the scene's `deadline`."
    choice = click.Choice(("hold", "skip", "slow"))
    return click.option("--policy", type=choice, help=policy)(command)


def read_limits(given: Mapping[str, Any]) -> RealtimeOptions:
    """Read the options of `realtime_options`."""
    values: dict[str, Any] = {}
    for option, field, unit, _ in _LIMITS:
        if given[field] is not None:
            values[field] = read_quantity(given[field], option, unit)
    for field in ("dead_man", "burst", "policy"):
        if given[field] is not None:
            values[field] = given[field]
    return RealtimeOptions(**values)


def print_couplings(loop: Realtime, quiet: bool) -> None:
    """Print the damping that the loop needs, and warnings about it, before the loop starts."""
    known = len(loop.warnings)
    lines = [coupling.line() for coupling in loop.couplings()]
    if not quiet and lines:
        click.echo("\n".join(lines), err=True)
    print_diagnostics(loop.warnings[known:])
    del loop.warnings[known:]


class LiveView:
    """A table of the loop on the terminal, drawn ten times a second off the loop.

    Nothing is drawn or imported unless `wanted` and standard error is a terminal.
    """

    def __init__(self, loop: Realtime, wanted: bool, menu: Menu | None = None) -> None:
        self._loop, self._menu = loop, menu
        self._wanted = wanted and sys.stderr is not None and sys.stderr.isatty()
        self._live: Live | None = None

    def __enter__(self) -> Self:
        if self._wanted:
            # Slow to load, and only a terminal shows it.
            from rich.console import Console
            from rich.live import Live

            self._live = Live(console=Console(stderr=True), auto_refresh=False, transient=True)
            self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._live is not None:
            self._live.stop()
        self._loop.stop(at_once=kind is not None)

    def follow(self) -> Report:
        """Show the loop until it ends or Ctrl-C ends it; return the final report.

        A second Ctrl-C does not wait until the force has fallen.
        """
        try:
            while self._loop.step(1.0 / _VIEWS_PER_SECOND).is_running:
                if self._menu is not None:
                    self._menu.poll()
                self._show()
                self._loop.pause(1.0 / _VIEWS_PER_SECOND)
        except KeyboardInterrupt:
            try:
                return self._loop.stop()
            except KeyboardInterrupt:
                return self._loop.stop(at_once=True)
        return self._loop.close()

    def _show(self) -> None:
        if self._live is None:
            return
        try:
            self._live.update(self._shown(), refresh=True)
        except OSError:  # the terminal was closed, and the loop goes on
            self._live = None

    def _shown(self) -> Group:
        """The state, the report as lines of the whole width, and a table of devices and values."""
        # As above.
        from rich.console import Group
        from rich.table import Table
        from rich.text import Text

        def row(table: Table, name: str, text: str) -> None:
            table.add_row(Text(name, style="bold"), Text(text))

        report = self._loop.report
        head, values = (Table(box=None, show_header=False, padding=(0, 1)) for _ in range(2))
        state = "the dead man's button is free" if report.released else "running"
        row(head, "state", f"{state}, force {100 * report.gain:.0f} %")
        if self._menu is not None:
            row(head, "keys", self._menu.line())
        for index, name in enumerate(self._loop.devices):
            force = self._loop.last_force(index)
            shown = ", ".join(f"{value:8.3f}" for value in force[:3])
            row(values, name, f"force {shown} N")
        latest = list(self._loop.latest().items())[:_MOST_VALUES]
        for (name, value), unit in zip(latest, self._loop.course.shown, strict=False):
            row(values, name, unit.text(value))
        # A line that is broken at times would move all that is below it.
        lines = [Text(f" {line}", no_wrap=True, overflow="ellipsis") for line in report.lines()]
        return Group(head, *lines, values)
