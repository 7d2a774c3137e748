"""The folders from which scenes may load programs: drivers of devices, and FMUs."""

from __future__ import annotations

import os
from pathlib import Path

ALLOWED = "BGC_DRIVERS"
"""The environment variable that lists these folders."""


def is_allowed(path: Path) -> bool:
    """Return whether a scene may load this file: it lies in a folder that the user has listed."""
    listed = [Path(folder) for folder in os.environ.get(ALLOWED, "").split(os.pathsep) if folder]
    return any(path.resolve().is_relative_to(folder.resolve()) for folder in listed)
