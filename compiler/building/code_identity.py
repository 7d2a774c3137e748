"""Identify the exact version of bgc's own code, for what it keeps in the cache."""

from __future__ import annotations

import os
from hashlib import blake2b
from importlib.util import find_spec

_FILES = (".py", ".lark", ".json", ".c", ".h")


def code_identity(*packages: str) -> str:
    """Hash names, sizes and times of the files of packages."""
    state = blake2b(digest_size=16)
    for package in packages:
        spec = find_spec(package)
        assert spec is not None and spec.submodule_search_locations
        for root in spec.submodule_search_locations:
            for path in sorted(_files_under(root)):
                facts = os.stat(path)  # noqa: PTH116 - a path object for each takes longer than its facts
                state.update(f"{path} {facts.st_size} {facts.st_mtime_ns}\n".encode())
    return state.hexdigest()


def _files_under(root: str) -> list[str]:
    found: list[str] = []
    with os.scandir(root) as entries:
        for entry in entries:
            if entry.name.endswith(_FILES):
                found.append(entry.path)
            elif entry.name[0] not in "_." and entry.is_dir():
                found.extend(_files_under(entry.path))
    return found
