"""Signals that end a command."""

import signal
from collections.abc import Callable
from types import FrameType

from bgc.record_class import dataclass

# Ctrl-C; a batch system; a terminal that was closed, which Windows does not signal.
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
_ENDING = [getattr(signal, name) for name in _NAMES if hasattr(signal, name)]


@dataclass(slots=True)
class Caught:
    """The first signal that arrived; 0 as long as none has."""

    number: int = 0

    @property
    def status(self) -> int:
        """The exit status after that signal, as shells have it; 0 without one."""
        return 128 + self.number if self.number else 0


def catch_signals() -> Caught:
    """Make the signals that end a command raise KeyboardInterrupt; note the first of them.

    A signal that the parent process set to be ignored, as `nohup` does, stays ignored.
    """
    caught = Caught()

    def interrupt(number: int, frame: FrameType | None) -> None:
        caught.number = caught.number or number
        raise KeyboardInterrupt(number)

    _handle_ending(interrupt)
    if hasattr(signal, "SIGPIPE"):
        # `bgc run f.bg --out - | head` ends quietly, as other commands do.
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    return caught


def outlive_clients() -> None:
    """Let a server go on when a client closes its connection in the middle of a message."""
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)


def end_at_signals() -> None:
    """Let signals end the process at once: nothing is left to be written."""
    _handle_ending(signal.SIG_DFL)


def _handle_ending(handler: Callable[[int, FrameType | None], None] | signal.Handlers) -> None:
    """Set the handler of the signals that end a command, except of those that are ignored."""
    for number in _ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)
