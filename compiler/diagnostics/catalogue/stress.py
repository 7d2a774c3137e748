"""Diagnostics: stress maps and activity."""

from __future__ import annotations

from bgc.diagnostics.catalogue import Values, error


@error(
    "BG087: `{text}` is not a valid `--drive`{why}",
    "write NAME=LOW..HIGH, NAME=LOW..HIGH:COUNT or NAME=VALUE, VALUE",
)
def not_a_drive(text: str, reason: str = "") -> Values:
    return {"why": f": {reason}" if reason else ""}


@error(
    "BG088: {scene:scene} observes nothing that can be judged", "add `observe NAME;` to the scene"
)
def nothing_to_judge(scene: str) -> None: ...
@error(
    "BG089: the scene does not run: {message}",
    "run it with `bgc run` and fix the error that it reports",
)
def nominal_run_failed(message: str) -> None: ...
