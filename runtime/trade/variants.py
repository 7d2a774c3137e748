"""Variants of a scene's slots: which are tried, and their models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

from bgc.driver import Compilation
from bgc.grammar.catalogue.trade import no_such_slot
from bgc.grammar.diagnostics import BgError
from bgc.options import Options
from bgc.runtime.trade.configurations import Uses
from bgc.variants import variants_of

ALL = "all"


def chosen_variants(path: Path, options: Options, patterns: Sequence[str]) -> tuple[Uses, ...]:
    """What to fill slots with, by the patterns that a user gives.

    `crane.elbow.lock` is one slot, and `all` each slot by itself. A pattern with `*` exchanges all
    slots that it matches together, by each type that fits all of them.

    Raises
    ------
    BgError
        BG093: a pattern matches no slot that something else fits.
    """
    if not patterns:
        return ()
    compilation = Compilation(path, options)
    by_slot: dict[str, list[str]] = {}
    for variant in variants_of(compilation.package, compilation.graph):
        by_slot.setdefault(variant.slot, []).append(variant.type)
    found: list[Uses] = []
    for pattern in patterns:
        if pattern == ALL:
            found += [((slot, type_),) for slot, types in by_slot.items() for type_ in types]
            continue
        slots = [slot for slot in by_slot if fnmatchcase(slot, pattern)]
        if not slots:
            raise BgError([no_such_slot(pattern, tuple(by_slot))])
        first, *others = (by_slot[slot] for slot in slots)
        common = [type_ for type_ in first if all(type_ in other for other in others)]
        found += [tuple((slot, type_) for slot in slots) for type_ in common]
    return tuple(dict.fromkeys(found))


def with_uses(options: Options, uses: Uses) -> Options:
    """The options that fill slots so."""
    return replace(options, uses=(*options.uses, *uses))
