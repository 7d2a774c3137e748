"""The user's cache: compiled objects and syntax trees by content, and finished builds.

The cache has two levels. A *blob* (`objects/KEY.o`, `models/KEY.so`, `trees/KEY.json`) is named
by the hash of everything that determines it, so it never has to be invalidated. A *note*
(`notes/KEY.json`) maps a request (entry file, scene, overrides) to the files that were read, their
hashes and the resulting build. When none of these files has changed, a warm start loads the build
without parsing.

Every file is written to a temporary name and then moved into place, so two runs at once are safe.
Blobs carry a checksum; a damaged blob counts as absent.
"""

from __future__ import annotations

import atexit
import json
import os
import shutil
import tempfile
import time
from collections.abc import Iterable
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path

from bgc.building.user_folder import cache_directory, make_cache_directory, why_unsafe
from bgc.diagnostics.catalogue.machine import cache_not_private, cache_not_writable
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.record_class import dataclass

_KEEP_SECONDS = 60 * 24 * 3600.0  # what is unused for longer is removed
_KEEP_BYTES = 2_000_000_000  # beyond it, what was unused for longest is removed
_KEEP_MAKING_SECONDS = 24 * 3600.0  # a killed run's half-made files


@dataclass(slots=True)
class Cache:
    """An opened cache directory, with the warnings about it."""

    root: Path
    warnings: tuple[Diagnostic, ...] = ()

    def blob(self, kind: str, name: str) -> Path | None:
        """A blob by name, None when it is absent or damaged."""
        path = self.root / kind / name
        try:
            if file_digest(path) != _checksum(path).read_text(encoding="ascii"):
                return None
            os.utime(path)  # the last use, for `prune`
        except (OSError, UnicodeDecodeError):
            return None
        return path

    def publish(self, kind: str, name: str, made: Path) -> Path:
        """Move a finished file, on the same file system, into the cache atomically."""
        path = self.root / kind / name
        path.parent.mkdir(parents=True, exist_ok=True)
        digest = file_digest(made)
        made.replace(path)
        write_aside(_checksum(path), digest)
        return path

    def move_away(self, reason: str) -> None:
        """Continue in a temporary directory, with a warning that gives the reason."""
        wanted = str(self.root)
        self.root = _temporary_directory()
        self.warnings = (*self.warnings, cache_not_writable(wanted, reason))

    def workplace(self) -> tempfile.TemporaryDirectory[str]:
        """A private directory on the cache's file system, removed on exit from its context."""
        return tempfile.TemporaryDirectory(prefix="making-", dir=self.root)

    def prune(self) -> None:
        """Remove files unused for two months or beyond 2 GB, and what killed runs left."""
        now = time.time()
        files: list[tuple[float, int, Path]] = []  # last use, bytes
        for kind in ("objects", "models", "trees", "notes", "sweeps"):
            for path in (self.root / kind).glob("*"):
                with suppress(OSError):
                    facts = path.stat()
                    if path.suffix != ".sum":
                        files.append((facts.st_mtime, facts.st_size, path))
        held = sum(size for _, size, _ in files)
        for used, size, path in sorted(files):
            if used >= now - _KEEP_SECONDS and held <= _KEEP_BYTES:
                break
            held -= size
            with suppress(OSError):
                path.unlink()
                _checksum(path).unlink(missing_ok=True)
        old = (
            ("failed/*", _KEEP_SECONDS),
            ("trades/*", _KEEP_SECONDS),
            ("fmus/*", _KEEP_SECONDS),
            ("making-*", _KEEP_MAKING_SECONDS),
        )
        for pattern, seconds in old:
            for path in self.root.glob(pattern):
                with suppress(OSError):
                    if path.stat().st_mtime < now - seconds:
                        shutil.rmtree(path, ignore_errors=True)


def open_cache() -> Cache:
    """Open the user's cache for writing; where that fails, a temporary one with a warning.

    So it is where somebody else may have written to the cache.
    """
    try:
        root = cache_directory()
    except RuntimeError as problem:  # no home directory
        return _temporary_cache("~/.cache/bgc", str(problem))
    try:
        make_cache_directory(root)
        if reason := why_unsafe(root):
            return Cache(_temporary_directory(), (cache_not_private(str(root), reason),))
        with tempfile.TemporaryFile(dir=root) as probe:
            probe.write(b"bgc")
    except OSError as problem:
        return _temporary_cache(str(root), problem.strerror or str(problem))
    return Cache(root)


def _temporary_cache(wanted: str, reason: str) -> Cache:
    return Cache(_temporary_directory(), (cache_not_writable(wanted, reason),))


def _temporary_directory() -> Path:
    """A directory that is removed when the process ends."""
    root = Path(tempfile.mkdtemp(prefix="bgc-"))
    atexit.register(shutil.rmtree, root, ignore_errors=True)
    return root


def digest_of(parts: Iterable[str]) -> str:
    """Hash texts, with the boundaries between them, to 32 hexadecimal digits."""
    state = blake2b(digest_size=16)
    for part in parts:
        data = part.encode("utf-8", "surrogateescape")
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.hexdigest()


def digest_of_bytes(content: bytes) -> str:
    """Hash bytes to 32 hexadecimal digits."""
    return blake2b(content, digest_size=16).hexdigest()


def file_digest(path: Path) -> str:
    """Hash a file's bytes; OSError where it cannot be read."""
    return digest_of_bytes(path.read_bytes())


def read_note(root: Path, key: str) -> object:
    """The JSON value noted under a key, None when there is none or it is damaged."""
    path = root / "notes" / f"{key}.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def write_note(root: Path, key: str, value: object) -> None:
    """Note a JSON value under a key."""
    path = root / "notes" / f"{key}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_aside(path, json.dumps(value))


def _checksum(path: Path) -> Path:
    return path.with_name(path.name + ".sum")


def write_aside(path: Path, text: str) -> None:
    """Write a file of the cache atomically."""
    handle, name = tempfile.mkstemp(dir=path.parent)
    aside = Path(name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        aside.replace(path)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise
