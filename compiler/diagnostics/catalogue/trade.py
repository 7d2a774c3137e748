"""BG09x: measuring the trade between speed and accuracy."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, warning
from bgc.diagnostics.diagnostic import Diagnostic


def nothing_measured(scene: str, method: str) -> Diagnostic:
    """BG090: `solver auto` without a measurement"""
    of = f"scene `{scene}`" if scene else "the model"
    return warning(
        "BG090",
        f"`solver auto`: there is no measurement of {of} in its present form; `{method}` was used",
        help="run `bgc trade` with the same `--set` and `--use`, or name a method",
    )


def nothing_to_measure(scene: str) -> Diagnostic:
    """BG091: no quantity to measure errors in"""
    of = f"scene `{scene}`" if scene else "the model"
    return error(
        "BG091",
        f"{of} observes nothing whose error can be measured",
        help="add `observe NAME;` to the scene, or `require NAME within VALUE;`",
    )


def no_reference(reasons: Sequence[str]) -> Diagnostic:
    """BG092: no reference solution"""
    return error(
        "BG092",
        f"there is no reference to measure errors against: {'; '.join(reasons)}",
        help="see how `bgc run --solver rodas5p` ends, shorten the run with `--time`, or increase "
        "`--budget`",
    )


def no_such_slot(pattern: str, slots: Sequence[str]) -> Diagnostic:
    """BG093: a slot that does not exist or has no alternatives"""
    listed = ", ".join(f"`{slot}`" for slot in slots[:8]) or "none"
    return error(
        "BG093",
        f"`{pattern}` is not a slot of the scene with alternatives",
        help=did_you_mean(pattern, slots) or f"slots with alternatives: {listed}",
    )
