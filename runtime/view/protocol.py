"""Messages between the page and its server.

The server sends text messages, JSON objects with a `type`, and binary messages with rows:

============= ==================================================================================
`scene`       the description (see `description`), `live`, and the state of the player
`state`       whether it plays, its speed, the speed reached, the epoch (number of resets)
`values`      the values of all parameters, SI, in the order of the description
`fault`       why a run stopped, or why a value was refused; the rows so far stay
============= ==================================================================================

A binary message is a header of four 32-bit and one 64-bit little-endian numbers: kind (1: rows
follow those before, 2: all rows so far), epoch, number of rows, columns of a row; the time at which
it was sent, s. Rows of float32 follow: the time as a sum of two numbers, then the model's columns.

The page sends text messages: `play`, `pause`, `step`, `reset`, `speed` with a `value`, and `set`
with the `name` of a parameter and its `value`, SI. All clients see and steer the same run.
"""

from __future__ import annotations

import json
import math
import struct
from typing import Any, Final

from bgc.runtime.view.history import Rows

NEW_ROWS: Final = 1
ALL_ROWS: Final = 2
HEADER: Final = struct.Struct("<IIIId")
LONGEST: Final = 4096  # bytes of a client's message
_COMMANDS: Final = frozenset({"play", "pause", "step", "reset", "speed", "set"})


def pack_rows(kind: int, epoch: int, rows: Rows, sent: float) -> bytes:
    """Pack rows, (n, width), into a binary message."""
    return HEADER.pack(kind, epoch, *rows.shape, sent) + rows.astype("<f4", copy=False).tobytes()


def pack(kind: str, content: Any) -> str:
    """Pack a text message; numbers that JSON does not have become null."""
    return json.dumps({"type": kind, **content}, allow_nan=False, separators=(",", ":"))


def finite(values: list[float]) -> list[float | None]:
    """Replace numbers that JSON does not have by None."""
    return [value if math.isfinite(value) else None for value in values]


def read_command(text: str) -> dict[str, Any] | None:
    """Check a message of a client; None where it is not one of the protocol."""
    try:
        message: Any = json.loads(text)
    except (ValueError, RecursionError):
        return None
    kind = message.get("type") if isinstance(message, dict) else None
    if not isinstance(kind, str) or kind not in _COMMANDS:
        return None
    if kind in ("speed", "set"):
        value = message.get("value")
        if isinstance(value, bool) or not isinstance(value, int | float):
            return None
        if not math.isfinite(value) or (kind == "speed" and value <= 0):
            return None
    if kind == "set" and not isinstance(message.get("name"), str):
        return None
    return {str(key): value for key, value in message.items()}
