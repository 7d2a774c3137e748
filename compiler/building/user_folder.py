"""The folder for files that bgc keeps on the user's machine."""

from __future__ import annotations

import os
import stat
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


def safe_cache_directory() -> Path:
    """Return the cache directory, to read from it.

    Raises
    ------
    OSError
        If there is no such directory.
    RuntimeError
        If the user has no home directory, or somebody else may have written to the cache.
    """
    root = cache_directory()
    if reason := why_unsafe(root):
        raise RuntimeError(reason)
    return root


def make_cache_directory(root: Path) -> None:
    """Make the cache directory and the missing folders above it, for the user alone."""
    missing = [root]
    while not missing[-1].parent.exists():
        missing.append(missing[-1].parent)
    for folder in reversed(missing):
        folder.mkdir(mode=0o700, exist_ok=True)


def why_unsafe(root: Path) -> str:
    """Return why the code in a cache directory may be somebody else's; empty if it is not.

    Code from the cache is executed, so only the user may write to it. The folders above it may
    be writable by all only if they are sticky, as `/tmp` is: else anybody could replace it.

    Raises
    ------
    OSError
        If there is no such directory.
    """
    if sys.platform == "win32":  # protected by the lists of access of the user's profile
        return ""
    facts = root.stat()
    if facts.st_uid != os.geteuid():
        return "it belongs to another user"
    if facts.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return "other users may write to it"
    for folder in root.resolve().parents:
        mode = folder.stat().st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            return f"anybody may replace it: all users may write to {folder}"
    return ""
