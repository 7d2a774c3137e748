"""The user's options of a compilation, as one value passed along."""

from __future__ import annotations

from typing import Final

from bgc.record_class import dataclass

RUN_NUMBER: Final = "number_of_the_run"
"""A parameter, 1 by default, that `Options.drives` may use: inputs of each run of an ensemble."""


@dataclass(frozen=True, slots=True)
class Options:
    """Options of one compilation.

    `scene` is the scene's name, None for the file's first. `overrides` are the
    `--set name=value` texts that decide structure; the others are set at run time. `strict`
    makes every warning about the model an error. `whole` compiles the whole model: nothing is
    folded or sliced. `uses` are pairs of a slot and the type that fills it, `("crane.elbow.lock",
    "Rigid[5]")`; they override the scene's own choices. `observe` replaces the scene's
    observations by these names of its columns or expressions. `preview` asks for C that compiles
    fast and runs slowly, `lanes` for the functions that run many instances at once, next to those
    of one, `tangents` for derivatives of a run by parameters. `audited` observes all energy
    accounts, whatever the scene does. `verify` checks the invariants of every intermediate result,
    as the environment variable BGC_VERIFY does. `shapes` records the poses of all shapes.
    `inputs` are inputs of models to which a parameter of their name is added, zero by default: a
    linear model varies it. `drives` are pairs of an input and the expression that gives it; they
    override the scene's own.
    """

    scene: str | None = None
    overrides: tuple[tuple[str, str], ...] = ()
    strict: bool = False
    whole: bool = False
    uses: tuple[tuple[str, str], ...] = ()
    observe: tuple[str, ...] = ()
    preview: bool = False
    lanes: bool = False
    tangents: bool = False
    audited: bool = False
    verify: bool = False
    shapes: bool = False
    inputs: tuple[str, ...] = ()
    drives: tuple[tuple[str, str], ...] = ()
