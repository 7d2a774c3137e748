"""The folder for files that bgc keeps on the user's machine."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def cache_directory() -> Path:
    """Return the cache directory: `$BGC_CACHE_DIR`, otherwise `bgc` in the user's own.

    Raises
    ------
    RuntimeError
        If the user has no home directory.
    """
    if chosen := os.environ.get("BGC_CACHE_DIR"):
        return Path(chosen).absolute()
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "bgc"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "bgc"
    if chosen := os.environ.get("XDG_CACHE_HOME"):
        return Path(chosen).absolute() / "bgc"
    return Path.home() / ".cache" / "bgc"
