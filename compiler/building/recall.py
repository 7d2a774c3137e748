"""Warm starts: find an earlier build of the same request without parsing anything.

A request is an entry file, a scene and overrides, for this version of the compiler and this kind of
machine. Its note lists the files that were read, with their hashes, and the resulting build. If
one byte of any file has changed, the request is compiled again.

This module imports only what a warm start needs.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from contextlib import suppress
from hashlib import blake2b
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from bgc.building.build_result import Built, Places, RunFacts
from bgc.building.cache import Cache, digest_of, read_note, write_note
from bgc.building.code_identity import code_identity
from bgc.building.record_json import from_json, to_json
from bgc.building.user_folder import safe_cache_directory
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Source
from bgc.options import Options


def recall(entry: Path, options: Options) -> Built | None:
    """Find the build of an earlier, equal request; None when anything differs or is damaged."""
    try:
        root = safe_cache_directory()
        note = read_note(root, _request_key(entry, options))
        return None if note is None else _built_from_note(root, note)
    except (OSError, RuntimeError, KeyError, TypeError, ValueError, IndexError):
        return None  # a damaged note is rebuilt, whatever the damage


def remember(
    cache: Cache,
    entry: Path,
    options: Options,
    sources: Sequence[Source],
    built: Built,
    data: Sequence[tuple[str, str]] = (),
) -> None:
    """Note a build for later requests; nothing is noted when a file changed meanwhile.

    `data` are the paths of the data files that were read, with the hashes of their contents.
    """
    files: list[list[str]] = []
    for source in sources:
        path = _file_of(source)
        if path is None:
            return
        files.append([source.name, str(path), blake2b(source.text.encode()).hexdigest()])
    note = {
        "files": files,
        "data": [list(file) for file in data],
        "model": built.library.name,
        "facts": to_json(built.facts),
        "warnings": to_json(built.warnings),
        "places": to_json(built.places),
    }
    with suppress(OSError):  # a full disk costs the next run its warm start, no more
        write_note(cache.root, _request_key(entry, options), note)


def processors() -> int:
    """The number of processors that this process may use."""
    with suppress(AttributeError):  # not on every system
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def machine_identity() -> str:
    """Identify the processor, which `-march=native` depends on; a cache may be on a shared disk."""
    flags = ""
    with suppress(OSError), Path("/proc/cpuinfo").open(encoding="ascii", errors="replace") as file:
        first = file.read(8192).split("\n\n", 1)[0]
        flags = "\n".join(
            line for line in first.splitlines() if line.startswith(("model name", "flags", "CPU"))
        )
    return f"{platform.system()} {platform.machine()} {flags or platform.processor()}"


def _request_key(entry: Path, options: Options) -> str:
    environment = (os.environ.get("CC", ""), machine_identity(), _compiler_identity())
    where = (str(entry), str(entry.resolve()))
    return digest_of((*where, repr(options), *environment))


def _compiler_identity() -> str:
    return code_identity("bgc", "bgc.grammar", "bgc.runtime")


def _built_from_note(root: Path, note: Any) -> Built | None:
    texts: dict[str, str] = {}
    for name, path, digest in note["files"]:
        texts[name] = _read(Path(path))
        if blake2b(texts[name].encode()).hexdigest() != digest:
            return None
    for path, digest in note["data"]:
        if blake2b(Path(path).read_bytes()).hexdigest() != digest:
            return None
    library = Cache(root).blob("models", note["model"])
    if library is None:
        return None
    facts = from_json(RunFacts, note["facts"], texts)
    warnings = from_json(tuple[Diagnostic, ...], note["warnings"], texts)
    places = from_json(Places, note["places"], texts)
    return Built(library, facts, warnings, warm=True, places=places)


def _file_of(source: Source) -> Path | None:
    """Find the file of a source text; None where it has none, or the file has changed.

    Files of the installed library are named `library/..`, wherever that is.
    """
    candidates = [Path(source.name)]
    spec = find_spec("bgc.library")
    if spec is not None and source.name.startswith("library/"):
        inside = source.name.removeprefix("library/")
        candidates += [Path(folder, inside) for folder in spec.submodule_search_locations or ()]
    for path in candidates:
        with suppress(OSError, UnicodeDecodeError):
            if _read(path) == source.text:
                return path.absolute()
    return None


def _read(path: Path) -> str:
    """Read a file as the compiler does, without translating line ends."""
    return path.read_bytes().decode("utf-8-sig")
