"""Simplifications that `bgc activity` found, stored for `bgc trade`."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from typing import Any, cast

from bgc.building.cache import digest_of, open_cache, read_note, write_note
from bgc.elaboration.scenes.variants import Change
from bgc.runtime.running.identity import scene_identity
from bgc.runtime.running.loaded import LoadedModel


def keep_variants(model: LoadedModel, variants: Sequence[Sequence[Change]]) -> None:
    """Store the variants of a compiled scene with its present parameters."""
    value = [[asdict(change) for change in one] for one in variants]
    with suppress(OSError):  # a full disk: `bgc trade` repeats the search
        write_note(open_cache().root, _key(model), value)


def stored_variants(model: LoadedModel) -> tuple[tuple[Change, ...], ...] | None:
    """Read the stored variants; None if the scene in this form was not examined."""
    value = cast(Any, read_note(open_cache().root, _key(model)))
    with suppress(TypeError):  # nothing, or damaged
        return tuple(tuple(Change(**change) for change in one) for one in value)
    return None


def _key(model: LoadedModel) -> str:
    return digest_of(("activity", *scene_identity(model), repr(model.facts.requirements)))
