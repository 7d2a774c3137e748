"""BG09x: measuring the trade between speed and accuracy."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, warning
from bgc.diagnostics.diagnostic import Diagnostic


def nothing_measured(scene: str, method: str) -> Diagnostic:
    """BG090: `solver auto` without a measurement

    What: the scene leaves its solver to what `bgc trade` recommends, and nothing was measured for
    the scene as it now is. It was run with the default method instead.

    Why: `bgc trade` was not run on this machine, was interrupted, found nothing that meets
    `require` and `deadline`, or the model, the scene or a parameter has changed since.

    Example: `solver auto;` in a scene that is new.

    Way out: `bgc trade FILE`, or a method by its name: `solver rodas5p;`.
    """
    of = f"scene `{scene}`" if scene else "the model"
    return warning(
        "BG090",
        f"`solver auto`: nothing was measured for {of} as it is now, so it was run with `{method}`",
        help="run `bgc trade` on it, with the same `--set` and `--use`, or name a method",
    )


def nothing_to_measure(scene: str) -> Diagnostic:
    """BG091: nothing whose error could be measured

    What: `bgc trade` measures errors in what the scene observes or requires.

    Why: the scene observes nothing, or energy accounts alone.

    Example: `scene s of RLC { run 1 s; }`.

    Way out: `observe NAME;` or `require NAME within VALUE;`.
    """
    of = f"scene `{scene}`" if scene else "the model"
    return error(
        "BG091",
        f"{of} observes nothing whose error could be measured",
        help="add `observe NAME;` to the scene, or `require NAME within VALUE;`",
    )


def no_reference(reasons: Sequence[str]) -> Diagnostic:
    """BG092: no method completes the run at a tight tolerance

    What: errors are measured against a solution by two methods at tight tolerances. Fewer than two
    of the methods completed it.

    Why: the model fails (see the reasons), or needs more time than the budget allows.

    Example: a model that runs into a singularity.

    Way out: `bgc run FILE` shows how it fails; `--time` measures a shorter part; `--budget` gives
    more time.
    """
    return error(
        "BG092",
        f"there is no reference to measure errors against: {'; '.join(reasons)}",
        help="see how `bgc run --solver rodas5p` ends, shorten the scene by `--time`, or give more "
        "`--budget`",
    )


def no_such_slot(pattern: str, slots: Sequence[str]) -> Diagnostic:
    """BG093: a slot that the scene does not have, or that nothing else fits

    What: `--variants` takes paths of slots, with `*` for any part of one, `all`, `activity`, or
    lines as a scene says them, `use slot = type; set name = value`.

    Why: none of the scene's slots that something else fits is called so.

    Example: `--variants crane.elbw.lock`.

    Way out: one of the slots that `bgc cost FILE` lists.
    """
    listed = ", ".join(f"`{slot}`" for slot in slots[:8]) or "none"
    return error(
        "BG093",
        f"`{pattern}` is no slot of the scene that could be filled otherwise",
        help=did_you_mean(pattern, slots) or f"slots that could: {listed}",
    )
