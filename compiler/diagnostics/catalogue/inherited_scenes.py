"""Diagnostics of scenes that extend other scenes."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, info, listed, respelt
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def model_and_base(span: Span, name: str, base: str) -> Diagnostic:
    """BG243: a scene with both a model and a base scene"""
    return error(
        "BG243",
        f"scene `{name}` names both a model and the scene `{base}`",
        span,
        help=f"write `scene {name} is {base} {{ .. }}`: the model is that of `{base}`",
    )


def unknown_base_scene(
    span: Span, name: str, known: Sequence[str], is_model: bool = False
) -> Diagnostic:
    """BG244: a base scene that does not exist"""
    near = did_you_mean(name, known)
    way = f"name one of the scenes: {listed(known)}" if known else "import the file of the scene"
    if is_model:
        near = f"a scene of a model is `scene name of {name} {{ .. }}`"
    edits = [] if is_model else respelt(span, name, known)
    return error("BG244", f"there is no scene `{name}`", span, help=near or way, edits=edits)


def scene_extends_itself(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG245: a scene that extends itself"""
    return error(
        "BG245",
        f"a scene extends itself: {' is '.join(names)}",
        span,
        help="give one of them a model by `of`, or another name",
    )


def ambiguous_base_scene(span: Span, name: str, places: Sequence[Span]) -> Diagnostic:
    """BG246: a base scene that two imported files declare"""
    return error(
        "BG246",
        f"two imported scenes are called `{name}`",
        span,
        labels=[Label(place, "declared here") for place in places],
        help="rename one of them, or import only one of the files",
    )


def statement_dropped(span: Span, what: str, path: str, slot: str) -> Diagnostic:
    """BG247: an inherited statement that is dropped"""
    return info(
        "BG247",
        f"this {what} has no effect: `{path}` does not exist",
        span,
        note=f"`{slot}` is filled with another model than in the scene that has this statement",
        help="nothing need be done; add a statement of the new model's own if one is wanted",
    )


def too_many_bases(span: Span, most: int) -> Diagnostic:
    """BG248: a scene that extends too many scenes"""
    return error(
        "BG248",
        f"this scene extends more than {most} scenes by `is`",
        span,
        help="let the scenes extend one common scene",
    )
