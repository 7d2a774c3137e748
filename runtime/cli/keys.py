"""Keys of a terminal while a command runs, and the scenes of `bgc haptic` that they choose."""

import os
import select
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.record_class import dataclass, field
from bgc.runtime.model import Model
from bgc.runtime.realtime.loop import Realtime
from bgc.runtime.running.quantity import Quantity

_MOST_BYTES = 64
MOST_CHOICES = 9
"""Keys `1` to `9`."""


@contextmanager
def terminal_keys() -> Iterator[int | None]:
    """Let the terminal hand over each key at once, without echo; the file that has them.

    None where standard input is not a terminal, or the system has no such terminals.
    """
    try:
        # Not on Windows.
        import termios
        import tty

        file = sys.stdin.fileno()
        before = termios.tcgetattr(file)
    except (ImportError, OSError, ValueError, AttributeError, termios.error):
        yield None
        return
    try:
        tty.setcbreak(file)
        yield file
    finally:
        termios.tcsetattr(file, termios.TCSADRAIN, before)


def read_keys(file: int) -> str:
    """The keys that were pressed since the last call, without waiting."""
    if not select.select([file], [], [], 0.0)[0]:
        return ""
    return os.read(file, _MOST_BYTES).decode("ascii", "ignore")


@dataclass(frozen=True, slots=True)
class Choice:
    """A model that a key lets run: its name on the terminal, and its parameters."""

    name: str
    model: Model
    parameters: Mapping[str, Quantity]


@dataclass(slots=True)
class Menu:
    """The choices of a loop, the one that runs, and what was refused.

    `1` to `9` choose, `n` takes the next one. `arguments` are those of `Realtime.exchange`.
    """

    loop: Realtime
    choices: Sequence[Choice]
    file: int
    arguments: Mapping[str, Any]
    present: int = 0
    refused: list[Diagnostic] = field(default_factory=list)

    def poll(self) -> None:
        """Do what the keys ask for that were pressed since the last call."""
        for key in read_keys(self.file):
            if key == "n":
                self._take((self.present + 1) % len(self.choices))
            elif key.isdecimal() and 1 <= int(key) <= len(self.choices):
                self._take(int(key) - 1)

    def line(self) -> str:
        """The choices as text, the one that runs in brackets; a page may have exchanged it."""
        names = (f"{k} {choice.name}" for k, choice in enumerate(self.choices, 1))
        running = self.loop.course.model
        present = self.present if any(c.model is running for c in self.choices) else None
        shown = (f"[{n}]" if k == present else n for k, n in enumerate(names))
        return f"{', '.join(shown)}; n next"

    def _take(self, place: int) -> None:
        choice = self.choices[place]
        try:
            self.loop.exchange(
                choice.model, parameters=choice.parameters, wait=False, **self.arguments
            )
        except BgError as problem:
            self.refused += problem.diagnostics
        else:
            self.present = place
