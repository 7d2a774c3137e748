"""Replace the uses, drives and observations of a scene by those from outside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from bgc.diagnostics.catalogue import slots
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source
from bgc.elaboration.instances.scopes import path_of
from bgc.elaboration.scenes.observations import is_path
from bgc.elaboration.scenes.scene_choice import Scene
from bgc.grammar import syntax
from bgc.grammar.parse import parse_filling, parse_setting
from bgc.language.column_names import column_in, name_in_si
from bgc.resolution.modules import Inherited
from bgc.resolution.scene_inheritance import replacing


def with_uses(scene: Scene, uses: Sequence[tuple[str, str]]) -> Scene:
    """Fill slots: `("crane.elbow.lock", "Rigid[5]")` acts as a `use` statement of the scene.

    `uses` override the scene's own choices; without any, the scene is returned unchanged. What the
    scene says of a part that is gone with the former choice has no effect, as in a scene that
    extends it. Raises BgError where a text is not a slot or not a type.
    """
    if not uses:
        return scene
    added = replacing(scene.items, [_use(use) for use in uses])
    filled = dict.fromkeys(path_of(item.slot) for item in added if isinstance(item, syntax.Use))
    kept = tuple(
        item
        for item in scene.items
        if not (isinstance(item, syntax.Use) and path_of(item.slot) in filled)
    )
    before = {id(each.item): each.slots for each in scene.inherited}
    inherited = tuple(
        Inherited(item, tuple(dict.fromkeys((*before.get(id(item), ()), *filled)))) for item in kept
    )
    return replace(scene, items=(*kept, *added), inherited=inherited)


def _use(use: tuple[str, str]) -> syntax.Use:
    source = Source("--use", "=".join(use))
    found = parse_filling(source)
    if found is not None:
        return replace(found, span=found.type.span)
    setting = parse_setting(source)
    raise BgError([slots.type_expected(setting.value.span, path_of(setting.target))])


def with_drives(scene: Scene, drives: Sequence[tuple[str, str]]) -> Scene:
    """Drive inputs: `("road", "0.1 m")` acts as a `drive` statement of the scene.

    `drives` override the scene's own; without any, the scene is returned unchanged. Raises BgError
    where a text is not a path or not an expression.
    """
    if not drives:
        return scene
    added = [_drive(drive) for drive in drives]
    driven = {path_of(item.target) for item in added}

    def is_kept(item: object) -> bool:
        return not (isinstance(item, syntax.Drive) and path_of(item.target) in driven)

    inherited = tuple(each for each in scene.inherited if is_kept(each.item))
    return replace(scene, items=(*filter(is_kept, scene.items), *added), inherited=inherited)


def _drive(drive: tuple[str, str]) -> syntax.Drive:
    # Behind a line break, long values stay out of the excerpts of messages about the name.
    setting = parse_setting(Source("inputs", " =\n".join(drive)))
    return syntax.Drive(setting.target, setting.value, setting.target.span)


def with_observations(scene: Scene, texts: Sequence[str]) -> Scene:
    """Replace the observations by names of the scene's own columns or other expressions.

    Without any, the scene is returned unchanged. Raises BgError where a text is not an expression.
    """
    if not texts:
        return scene
    items = list(scene.statements(syntax.Observe))
    own = {name_in_si(_column(item)): replace(item, unit=None) for item in items}
    own |= {_column(item): item for item in items}
    replaced = syntax.Observe | syntax.Plot | syntax.Require
    kept = (item for item in scene.items if not isinstance(item, replaced))
    added = (own[text] if text in own else _observation(text, own) for text in texts)
    return replace(scene, items=(*kept, *added), implicit=False)


def _column(item: syntax.Observe) -> str:
    """The column name of an observation; empty if it needs an alias."""
    name = item.alias or (path_of(item.value) if is_path(item.value) else "")
    return column_in(name, item.unit) if name else ""


def _observation(text: str, own: Mapping[str, syntax.Observe]) -> syntax.Observe:
    """An expression to observe; `name[2]` is a component of the scene's own column `name`."""
    value = parse_setting(Source("--output", f"y = {text}")).value
    match value:
        case syntax.Index(base=syntax.Name(name=name)) if name in own:
            value = replace(value, base=own[name].value)
        case _:
            pass
    return syntax.Observe(value, text, None, value.span, value.span)
