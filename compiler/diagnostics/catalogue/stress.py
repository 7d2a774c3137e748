"""BG087-BG089: stress maps of a scene, and the activity of its elements."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def not_a_drive(text: str) -> Diagnostic:
    """BG087: an invalid `--drive`"""
    return error(
        "BG087",
        f"`{text}` is not a valid `--drive`",
        help="write NAME=LOW..HIGH, NAME=LOW..HIGH:COUNT or NAME=VALUE, VALUE",
    )


def nothing_to_judge(scene: str) -> Diagnostic:
    """BG088: nothing to judge"""
    of = f"scene `{scene}`" if scene else "the model"
    return error(
        "BG088",
        f"{of} observes nothing that can be judged",
        help="add `observe NAME;` to the scene",
    )


def nominal_run_failed(message: str) -> Diagnostic:
    """BG089: a scene that does not run"""
    return error(
        "BG089",
        f"the scene does not run: {message}",
        help="run it with `bgc run` and fix the error that it reports",
    )
