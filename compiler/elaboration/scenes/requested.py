"""What is observed on request, in place of what the scene observes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from bgc.diagnostics.source import Source
from bgc.elaboration.instances.scopes import path_of
from bgc.elaboration.scenes.observed import is_path
from bgc.elaboration.scenes.scene import Scene
from bgc.grammar import syntax
from bgc.grammar.parse import parse_setting


def observing(scene: Scene, texts: Sequence[str]) -> Scene:
    """The scene with other observations: names of its own columns, or any expressions.

    Raises BgError where a text is no expression. No texts leave the scene as it is.
    """
    if not texts:
        return scene
    own = {_column(item): item for item in scene.every(syntax.Observe)}
    of_own = syntax.Observe | syntax.Plot | syntax.Require
    rest = (item for item in scene.items if not isinstance(item, of_own))
    asked = (own[text] if text in own else _read(text, own) for text in texts)
    return replace(scene, items=(*rest, *asked), implicit=False)


def _column(item: syntax.Observe) -> str:
    """What the column of an observation is called; empty where it needs a name."""
    return item.alias or (path_of(item.value) if is_path(item.value) else "")


def _read(text: str, own: Mapping[str, syntax.Observe]) -> syntax.Observe:
    """An expression to observe; components of a column of the scene's own by that name."""
    value = parse_setting(Source("--output", f"y = {text}")).value
    match value:
        case syntax.Index(base=syntax.Name(name=name)) if name in own:
            value = replace(value, base=own[name].value)
        case _:
            pass
    return syntax.Observe(value, text, value.span)
