"""Diagnostics: trade between speed and accuracy."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, nearest, quoted, warning


@warning(
    "BG090: `solver auto`: there is no measurement of {scene:scene} in its present form; "
    "`{method}` was used",
    "run `bgc trade` with the same `--set` and `--use`, or name a method",
)
def nothing_measured(scene: str, method: str) -> None: ...
@error(
    "BG091: {scene:scene} observes nothing whose error can be measured",
    "add `observe NAME;` to the scene, or `require NAME within VALUE;`",
)
def nothing_to_measure(scene: str) -> None: ...
@error(
    "BG092: there is no reference to measure errors against: {why}",
    "see how `bgc run --solver rodas5p` ends, shorten the run with `--time`, or increase "
    "`--budget`",
)
def no_reference(reasons: Sequence[str]) -> Values:
    return {"why": "; ".join(reasons)}


@error(
    "BG093: `{pattern}` is not a slot of the scene with alternatives",
    "slots with alternatives: {some}",
)
def no_such_slot(pattern: str, slots: Sequence[str]) -> Values:
    return {"some": quoted(slots[:8]) or "none", **nearest(pattern, slots)}
