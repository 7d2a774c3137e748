"""What the user asked of the compiler, as one value passed along."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Options:
    """Options of one compilation.

    `scene` is the scene's name, None for the file's first. `overrides` are the
    `--set name=value` texts that decide structure; the others are set at run time. `strict`
    makes every warning about the model an error. `whole` compiles all that is written: nothing
    is folded or sliced. `uses` are slots to fill otherwise than the scene does. `preview` asks for
    C that is compiled fast and runs slowly, `lanes` for the functions that run many instances at
    once, next to those of one. `audited` observes all energy accounts, whatever the scene does.
    """

    scene: str | None = None
    overrides: tuple[tuple[str, str], ...] = ()
    strict: bool = False
    whole: bool = False
    uses: tuple[tuple[str, str], ...] = ()
    preview: bool = False
    lanes: bool = False
    audited: bool = False
