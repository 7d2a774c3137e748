"""Diagnostics of scenes that extend other scenes."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, info, listed, respelt
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def model_and_base(span: Span, name: str, base: str) -> Diagnostic:
    """BG243: a scene with both a model and a base scene

    What: a scene has `of`, which names its model, and `is`, which names another scene.

    Why: the other scene has a model already.

    Example: `scene heavy of Crane is lift { }`

    Way out: write `is` alone. A slot of the model is filled by `use`; another model needs a scene
    of its own, with `of`.
    """
    return error(
        "BG243",
        f"scene `{name}` names both a model and the scene `{base}`",
        span,
        help=f"write `scene {name} is {base} {{ .. }}`: the model is that of `{base}`",
    )


def unknown_base_scene(
    span: Span, name: str, known: Sequence[str], is_model: bool = False
) -> Diagnostic:
    """BG244: a base scene that does not exist

    What: neither the file nor one of its imports has a scene with the name after `is`.

    Why: a scene takes its statements from the scene that it extends.

    Example: `scene heavy is lfit { set load = 3 t; }`

    Way out: correct the name, or import the file of that scene. A scene of a model is
    `scene name of Model { .. }`.
    """
    near = did_you_mean(name, known)
    way = f"name one of the scenes: {listed(known)}" if known else "import the file of the scene"
    if is_model:
        near = f"a scene of a model is `scene name of {name} {{ .. }}`"
    edits = [] if is_model else respelt(span, name, known)
    return error("BG244", f"there is no scene `{name}`", span, help=near or way, edits=edits)


def scene_extends_itself(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG245: a scene that extends itself

    What: the chain of `is` from a scene leads back to the scene itself.

    Why: none of these scenes names a model. A scene of the file hides an imported one of its name.

    Example: `scene a is b { } scene b is a { }`

    Way out: remove one `is`, or rename the scene that extends an imported one of the same name.
    """
    return error(
        "BG245",
        f"a scene extends itself: {' is '.join(names)}",
        span,
        help="give one of them a model by `of`, or another name",
    )


def ambiguous_base_scene(span: Span, name: str, places: Sequence[Span]) -> Diagnostic:
    """BG246: a base scene that two imported files declare

    What: two imported files have a scene with the name after `is`.

    Why: the scenes differ.

    Example: `import "calm.bg"; import "storm.bg"; scene heavy is lift { }`, where both have a
    scene `lift`.

    Way out: rename one of them, or import only one of the files.
    """
    return error(
        "BG246",
        f"two imported scenes are called `{name}`",
        span,
        labels=[Label(place, "declared here") for place in places],
        help="rename one of them, or import only one of the files",
    )


def statement_dropped(span: Span, what: str, path: str, slot: str) -> Diagnostic:
    """BG247: an inherited statement that is dropped

    What: a scene fills a slot by `use`, and a statement of the scene that it extends names a part
    or value that the new model does not have; or the command line fills it by `--use`. The
    statement has no effect.

    Why: scenes of different variants share their statements as far as these apply.

    Example: `scene long is lift { use crane = TelescopicCrane; }`, where `lift` has
    `observe crane.elbow.angle;`

    Way out: nothing need be done. Write a statement of the scene's own for the new part.
    """
    return info(
        "BG247",
        f"this {what} has no effect: `{path}` does not exist",
        span,
        note=f"`{slot}` is filled with another model than in the scene that has this statement",
        help="nothing need be done; add a statement of the new model's own if one is wanted",
    )


def too_many_bases(span: Span, most: int) -> Diagnostic:
    """BG248: a scene that extends too many scenes

    What: more than 100 scenes lie between a scene and the first of those that it extends.

    Why: each of them is read for each scene that extends it.

    Example: a file written by a program, in which each scene extends the one before.

    Way out: let the scenes extend one common scene.
    """
    return error(
        "BG248",
        f"this scene extends more than {most} scenes by `is`",
        span,
        help="let the scenes extend one common scene",
    )
