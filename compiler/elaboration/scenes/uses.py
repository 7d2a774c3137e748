"""Slots that are filled on request, before what the scene fills them with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bgc.diagnostics.source import Source
from bgc.elaboration.instances.instantiate import as_type_use
from bgc.elaboration.instances.scopes import path_of
from bgc.elaboration.instances.tree import Given
from bgc.elaboration.scenes.scene import Scene
from bgc.grammar import syntax
from bgc.grammar.parse import parse_setting


def using(scene: Scene, uses: Sequence[tuple[str, str]]) -> Scene:
    """The scene with slots filled: `("crane.elbow.lock", "Rigid[5]")`, as its own `use` would.

    Raises BgError where a text is no slot or no type. A slot that the scene fills is filled
    anew; nothing to use leaves the scene as it is.
    """
    if not uses:
        return scene
    asked = [_read(scene, use) for use in uses]
    filled = {path_of(item.slot) for item in asked}
    rest = (
        item
        for item in scene.items
        if not (isinstance(item, syntax.Use) and path_of(item.slot) in filled)
    )
    return replace(scene, items=(*rest, *asked))


def _read(scene: Scene, use: tuple[str, str]) -> syntax.Use:
    setting = parse_setting(Source("--use", "=".join(use)))
    given = Given(setting.value, scene.env, setting.value.span)
    type_use = as_type_use(given, path_of(setting.target))
    return syntax.Use(setting.target, type_use, setting.value.span)
