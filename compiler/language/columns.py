"""Names of the columns of a result."""

from __future__ import annotations

_COMPONENTS = {"x": "1", "y": "2", "z": "3"}


def column_of(path: str) -> str:
    """Name the column of a vector's component written as a member: `tip[1]` for `tip.x`."""
    vector, dot, name = path.rpartition(".")
    return f"{vector}[{_COMPONENTS[name]}]" if dot and name in _COMPONENTS else path
