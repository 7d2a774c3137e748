"""Options and the view on the terminal that the commands in real time share."""

import signal
import sys
from typing import TYPE_CHECKING, Any

from bgc.runtime.cli.command import OptionGroup, signature
from bgc.runtime.cli.options import rows_of
from bgc.runtime.cli.printing import print_diagnostics, print_text
from bgc.runtime.realtime.loop import Realtime
from bgc.runtime.realtime.loop_options import RealtimeOptions
from bgc.runtime.realtime.loop_report import Report

if TYPE_CHECKING:
    from rich.console import Group
    from rich.live import Live
    from rich.table import Table

    from bgc.runtime.cli.keys import Menu

_MOST_VALUES = 12
_PERIOD = 0.1  # s between two views
_PROMPT = 0.3  # s in which the force falls after SIGTERM


class LimitOptions(OptionGroup):
    """Limits of a loop, as `options` of `Model.realtime`."""

    __signature__ = signature(rows_of(RealtimeOptions))

    def __init__(self, **given: Any) -> None:
        known = {name: value for name, value in given.items() if value is not None}
        self.options = RealtimeOptions(**known)


def print_couplings(loop: Realtime, quiet: bool) -> None:
    """Print the damping that the loop needs, and warnings about it, before the loop starts."""
    known = len(loop.warnings)
    lines = [coupling.line() for coupling in loop.couplings()]
    if not quiet and lines:
        print_text("\n".join(lines), err=True)
    print_diagnostics(loop.warnings[known:])
    del loop.warnings[known:]


def follow(loop: Realtime, quiet: bool, menu: "Menu | None" = None) -> Report:
    """Run a loop until it ends or Ctrl-C ends it; print why it failed, return the final report.

    A terminal shows a view of it ten times a second, drawn off the loop, unless `quiet`. A second
    Ctrl-C does not wait until the force has fallen, and another signal only for 0.3 s.
    """
    live = None if quiet or not sys.stderr.isatty() else _live()
    try:
        loop.start()
        try:
            while loop.step(_PERIOD).is_running:
                if menu is not None:
                    menu.poll()
                if live is not None:
                    live = _updated(live, loop, menu)
                loop.pause(_PERIOD)
        except KeyboardInterrupt as asked:
            is_prompt = asked.args not in ((), (signal.SIGINT,))
            try:
                return loop.stop(within=_PROMPT if is_prompt else None)
            except KeyboardInterrupt:
                return loop.stop(at_once=True)
        return loop.close()
    finally:
        if live is not None:
            live.stop()
        loop.stop(at_once=True)  # where an error ended the view


def _live() -> "Live":
    # Slow to load, and only a terminal shows it.
    from rich.console import Console
    from rich.live import Live

    live = Live(console=Console(stderr=True), auto_refresh=False, transient=True)
    live.start()
    return live


def _updated(live: "Live", loop: Realtime, menu: "Menu | None") -> "Live | None":
    try:
        live.update(shown(loop, menu), refresh=True)
    except OSError:  # the terminal was closed, and the loop goes on
        return None
    return live


def shown(loop: Realtime, menu: "Menu | None" = None) -> "Group":
    """The state, the report as lines of the whole width, and a table of devices and values."""
    # As above.
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    def table(rows: list[tuple[str, str]]) -> "Table":
        made = Table(box=None, show_header=False, padding=(0, 1))
        for name, text in rows:
            made.add_row(Text(name, style="bold"), Text(text))
        return made

    report = loop.report
    state = "the dead man's button is free" if report.released else "running"
    head = [("state", f"{state}, force {100 * report.gain:.0f} %")]
    head += [("keys", menu.line())] if menu is not None else []
    forces = {name: loop.last_force(index)[:3] for index, name in enumerate(loop.devices)}
    values = [
        (n, f"force {', '.join(f'{v:8.3f}' for v in force)} N") for n, force in forces.items()
    ]
    latest = list(loop.latest().items())[:_MOST_VALUES]
    values += [(n, unit.text(v)) for (n, v), unit in zip(latest, loop.course.shown, strict=False)]
    # A line that is broken at times would move all that is below it.
    lines = [Text(f" {line}", no_wrap=True, overflow="ellipsis") for line in report.lines()]
    return Group(table(head), *lines, table(values))
