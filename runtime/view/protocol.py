"""Messages between the page and its server.

The server sends text messages, JSON objects with a `type`, and binary messages with rows:

============= ==================================================================================
`scene`       the description (see `description`), the number of the `model` (exchanges so far), and
              `live`
`state`       whether it plays, its speed, the speed reached, the epoch (number of resets), and the
              devices that pages hold; of a loop in real time (`realtime` in the description) also
              `loop`: `words` on it, and the `lines` of its report
`values`      the values of all parameters, SI, in the order of the description
`fault`       why a run stopped, or why a value was refused; the rows so far stay
`graph`       the bond graph (see `graph`), where a page asked for it
============= ==================================================================================

A `scene` with another description or model announces another model: the page is loaded again.

A binary message is a header of four 32-bit and one 64-bit little-endian numbers: kind (1: rows
follow those before, 2: all rows so far, 3: a row with effort and flow of each bond of the graph),
epoch, number of rows, columns of a row; the time at which it was sent, s. Rows of float32 follow:
the time as a sum of two numbers, then the model's columns.

The page sends text messages: `play`, `pause`, `step`, `reset`, `speed` with a `value`, and `set`
with the `name` of a parameter and its `value`, SI. `hand` gives a `device` a pose: its `position`,
m, and if it likes `orientation` (a unit quaternion, scalar first), `gripper` and `buttons`; `leave`
gives the `device` back to the scene. `graph` asks for the bond graph, `watch` with a `value`, true
or false, for the efforts and flows of its bonds; `use` puts a `part` into a `slot`. All
clients see and steer the same run. A loop in real time takes `hand`, `leave`, `set`, which holds
from the next reset, `reset`, `graph` for its slots, and `use`.
"""

from __future__ import annotations

import json
import math
import re
import struct
import sys
from typing import Any, Final

from bgc.runtime.view.history import Rows

NEW_ROWS: Final = 1
ALL_ROWS: Final = 2
POWERS: Final = 3
HEADER: Final = struct.Struct("<IIIId")
LONGEST: Final = 4096  # bytes of a client's message
_COMMANDS: Final = frozenset(
    ("play", "pause", "step", "reset", "speed", "set", "hand", "leave", "graph", "watch", "use")
)
# Least and most numbers of each part of a pose.
_POSE: Final = {
    "position": (3, 3),
    "orientation": (4, 4),
    "buttons": (0, 8),
}
_FARTHEST: Final = 1e3  # of a number of a pose
_SHORTEST_QUATERNION: Final = 1e-6  # length of a quaternion, which is made 1


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
        if not _is_number(value) or (kind == "speed" and value <= 0):
            return None
    if kind == "set" and not isinstance(message.get("name"), str):
        return None
    if kind in ("hand", "leave") and not isinstance(message.get("device"), str):
        return None
    if kind == "use" and not all(_is_name(message.get(key)) for key in ("slot", "part")):
        return None
    if kind == "watch" and not isinstance(message.get("value"), bool):
        return None
    if kind == "hand" and not _is_pose(message):
        return None
    return {str(key): value for key, value in message.items()}


def _is_pose(message: dict[str, Any]) -> bool:
    """Return whether a message has a position, and its other parts are numbers of a pose."""
    for part, (least, most) in _POSE.items():
        if part not in message and part != "position":
            continue
        numbers = message.get(part)
        if not isinstance(numbers, list) or not least <= len(numbers) <= most:
            return False
        if not all(_is_number(x) and abs(x) <= _FARTHEST for x in numbers):
            return False
    gripper = message.get("gripper", 0.0)
    turned = message.get("orientation", [1.0])
    return (
        _is_number(gripper)
        and abs(gripper) <= _FARTHEST
        and math.hypot(*turned) >= _SHORTEST_QUATERNION
    )


def _is_number(value: Any) -> bool:
    """Return whether a value is a number that a double holds; JSON has longer integers."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= sys.float_info.max


def _is_name(value: Any) -> bool:
    """Return whether a value is a path or a type: names, dots, and indices or dimensions."""
    return isinstance(value, str) and re.fullmatch(r"[A-Za-z_][\w.\[\], ]*", value) is not None
