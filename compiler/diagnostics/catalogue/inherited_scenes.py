"""Diagnostics: scenes that extend other scenes."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, info, listed, nearest, warning
from bgc.diagnostics.source import Span


@error(
    "BG243: scene `{name}` names both a model and the scene `{base}`",
    "write `scene {name} is {base} { .. }`: the model is that of `{base}`",
)
def model_and_base(span: Span, name: str, base: str) -> None: ...
@error("BG244: there is no scene `{name}`", "{there}")
def unknown_base_scene(
    span: Span, name: str, known: Sequence[str], is_model: bool = False
) -> Values:
    if is_model:
        return {"there": f"a scene of a model is `scene name of {name} {{ .. }}`"}
    there = f"name one of the scenes: {listed(known)}" if known else "import the file of the scene"
    return {"there": there, **nearest(name, known, span)}


@error("BG245: a scene extends itself: {line}", "give one of them a model by `of`, or another name")
def scene_extends_itself(span: Span, names: Sequence[str]) -> Values:
    return {"line": " is ".join(names)}


@error(
    "BG246: two imported scenes are called `{name}`",
    "rename one of them, or import only one of the files",
    labels={"places": "declared here"},
)
def ambiguous_base_scene(span: Span, name: str, places: Sequence[Span]) -> None: ...
@info(
    "BG247: this {what} has no effect: `{path}` does not exist",
    "nothing need be done; add a statement of the new model's own if one is wanted",
    note="`{slot}` is filled with another model than in the scene that has this statement",
)
def statement_dropped(span: Span, what: str, path: str, slot: str) -> None: ...
@error(
    "BG248: this scene extends more than {most} scenes by `is`",
    "let the scenes extend one common scene",
)
def too_many_bases(span: Span, most: int) -> None: ...


@warning(
    "BG271: scene `{base}`, or something that it uses, has changed since {scene:scene} was "
    "compared with it",
    "run `bgc reduce` again on `{base}`",
)
def changed_since_proof(span: Span, base: str, scene: str) -> None: ...
@warning(
    "BG272: {scene:scene} extends no scene that its `proof` could be about",
    "write `scene {scene} is other { .. }`, or remove the statement",
)
def proof_without_base(span: Span, scene: str) -> None: ...
