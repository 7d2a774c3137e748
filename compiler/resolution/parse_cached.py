"""Parse a source, or find its tree in the user's cache: most files of a package never change.

Only trees without a diagnostic are kept, by the text and the parser's own files.
"""

from __future__ import annotations

from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path
from typing import TypeAlias

from bgc.building.cache import Cache, digest_of
from bgc.building.code_identity import code_identity
from bgc.building.user_folder import cache_directory, make_cache_directory, safe_cache_directory
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Source
from bgc.grammar import syntax
from bgc.grammar.parse import parse
from bgc.grammar.tree_json import tree_from_json, tree_to_json

Parsed: TypeAlias = tuple[syntax.File, tuple[Diagnostic, ...]]


@lru_cache(maxsize=256)  # a process that loads models one after the other imports the same files
def parse_cached(source: Source) -> Parsed:
    """Return the tree and the diagnostics of a source; the cache may be absent or damaged."""
    name = f"{digest_of((_parser_identity(), source.text))}.json"
    with suppress(OSError, RuntimeError, ValueError, TypeError, LookupError):
        kept = Cache(safe_cache_directory()).blob("trees", name)
        if kept is not None:
            return tree_from_json(kept.read_text(encoding="ascii"), source), ()
    file, diagnostics = parse(source)
    if not diagnostics:
        with suppress(OSError, RuntimeError):  # a full disk costs the next run some time, no more
            _keep(name, tree_to_json(file))
    return file, diagnostics


def _keep(name: str, tree: str) -> None:
    make_cache_directory(cache_directory())
    store = Cache(safe_cache_directory())
    with store.workplace() as place:
        made = Path(place) / name
        made.write_text(tree, encoding="ascii")
        store.publish("trees", name, made)


@cache
def _parser_identity() -> str:
    return code_identity("bgc.grammar")
