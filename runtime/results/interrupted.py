"""Ctrl-C during a run or a study, with what was done by then."""

from __future__ import annotations

from typing import Any


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run or a study; `result` holds what was done by then, None if nothing was.

    `kept` is true where the next equal call goes on from there. It is a KeyboardInterrupt, so that
    a script with many runs ends as its user expects.
    """

    def __init__(self, message: str, result: Any = None, kept: bool = False) -> None:
        super().__init__(message)
        self.result = result
        self.kept = kept
