"""Warm starts: find an earlier build of the same request without parsing anything.

A request is an entry file, a scene and overrides, for this version of the compiler and this kind of
machine. Its note lists the files that were read, with their hashes, and the resulting build. If
one byte of any file has changed, the request is compiled again.

This module imports only what a warm start needs.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from hashlib import blake2b
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from bgc.building.built import Built, Panel, Place, Places, Rest, RunFacts, Sampled
from bgc.building.cache import Cache, digest_of, read_note, write_note
from bgc.building.user_folder import safe_cache_directory
from bgc.diagnostics.diagnostic import Diagnostic, Label, Severity
from bgc.diagnostics.source import Source, Span
from bgc.ir.port_facts import ForceFacts, PortFacts
from bgc.language.columns import AccountColumn
from bgc.options import Options

_COMPILER_FILES = (".py", ".lark", ".json", ".c", ".h")


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
        "facts": asdict(built.facts),
        "warnings": [_diagnostic_to_json(d) for d in built.warnings],
        "assertions": [_place_to_json(place) for place in built.places.assertions],
        "switches": [_place_to_json(place) for place in built.places.switches],
        "divisors": [_place_to_json(place) for place in built.places.divisors],
        "jumps": [_place_to_json(place) for place in built.places.jumps],
        "held": [_place_to_json(place) for place in built.places.held],
        "ports": [_place_to_json(place) for place in built.places.ports],
        "checks": [_place_to_json(place) for place in built.places.checks],
        "parameters": [_place_to_json(place) for place in built.places.parameters],
        "start": list(built.places.start),
        "loops": [list(map(list, loop)) for loop in built.places.loops],
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
    """Hash names, sizes and times of the compiler's own files, to identify its exact version."""
    state = blake2b(digest_size=16)
    for package in ("bgc", "bgc.grammar", "bgc.runtime"):
        spec = find_spec(package)
        assert spec is not None and spec.submodule_search_locations
        for root in spec.submodule_search_locations:
            for path in sorted(_files_under(root)):
                facts = Path(path).stat()
                state.update(f"{path} {facts.st_size} {facts.st_mtime_ns}\n".encode())
    return state.hexdigest()


def _files_under(root: str) -> list[str]:
    found: list[str] = []
    with os.scandir(root) as entries:
        for entry in entries:
            if entry.name.endswith(_COMPILER_FILES):
                found.append(entry.path)
            elif entry.name[0] not in "_." and entry.is_dir():
                found.extend(_files_under(entry.path))
    return found


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
    facts: dict[str, Any] = {key: _tuples(value) for key, value in note["facts"].items()}
    panels = [Panel(tuple(panel["columns"]), panel["across"]) for panel in note["facts"]["panels"]]
    facts["panels"] = tuple(panels)
    facts["accounts"] = tuple(AccountColumn(**found) for found in note["facts"]["accounts"])
    for name in ("rest", "resting"):
        if (rest := note["facts"][name]) is not None:
            lists = {key: _tuples(value) for key, value in rest.items()}
            lists["sampled"] = tuple(Sampled(**value) for value in rest["sampled"])
            facts[name] = Rest(**lists)
    for name, kind in (("ports", PortFacts), ("forces", ForceFacts)):
        rows = ({key: _tuples(value) for key, value in row.items()} for row in note["facts"][name])
        facts[name] = tuple(kind(**row) for row in rows)
    warnings = tuple(_diagnostic_from_json(d, texts) for d in note["warnings"])
    places = Places(
        tuple(_place_from_json(place, texts) for place in note["assertions"]),
        tuple(_place_from_json(place, texts) for place in note["switches"]),
        tuple(_place_from_json(place, texts) for place in note["divisors"]),
        tuple(note["start"]),
        _tuples(note["loops"]),
        tuple(_place_from_json(place, texts) for place in note["jumps"]),
        tuple(_place_from_json(place, texts) for place in note["held"]),
        tuple(_place_from_json(place, texts) for place in note["ports"]),
        tuple(_place_from_json(place, texts) for place in note["checks"]),
        tuple(_place_from_json(place, texts) for place in note["parameters"]),
    )
    return Built(library, RunFacts(**facts), warnings, warm=True, places=places)


def _tuples(value: Any) -> Any:
    """Turn the lists of JSON back into tuples."""
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value


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


def _diagnostic_to_json(diagnostic: Diagnostic) -> dict[str, object]:
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity.value,
        "message": diagnostic.message,
        "span": _span_to_json(diagnostic.span),
        "note": diagnostic.note,
        "labels": [[_span_to_json(label.span), label.text] for label in diagnostic.labels],
        "help": diagnostic.help,
    }


def _diagnostic_from_json(value: Any, texts: Mapping[str, str]) -> Diagnostic:
    labels: list[Label] = []
    for place, text in value["labels"]:
        span = _span_from_json(place, texts)
        if span is not None:
            labels.append(Label(span, text))
    return Diagnostic(
        code=value["code"],
        severity=Severity(value["severity"]),
        message=value["message"],
        span=_span_from_json(value["span"], texts),
        note=value["note"],
        labels=tuple(labels),
        help=value["help"],
    )


def _place_to_json(place: Place) -> list[object]:
    return [_span_to_json(place.span), list(place.states)]


def _place_from_json(value: Any, texts: Mapping[str, str]) -> Place:
    span, states = value
    return Place(_span_from_json(span, texts), tuple(states))


def _span_to_json(span: Span | None) -> list[object] | None:
    return None if span is None else [span.source.name, span.start, span.end]


def _span_from_json(value: Any, texts: Mapping[str, str]) -> Span | None:
    if value is None:
        return None
    name, start, end = value
    return Span(Source(name, texts[name]), start, end)
