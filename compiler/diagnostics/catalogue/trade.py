"""BG09x: measuring the trade between speed and accuracy."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, warning
from bgc.diagnostics.diagnostic import Diagnostic


def nothing_measured(scene: str, method: str) -> Diagnostic:
    """BG090: `solver auto` without a measurement

    What: the scene uses the solver that `bgc trade` recommends, but there is no measurement of the
    scene in its present form. The default method was used instead.

    Why: `bgc trade` was not run on this machine, was interrupted, or found no method that meets
    `require` and `deadline`; or the model, the scene or a parameter has changed since.

    Example: `solver auto;` in a new scene.

    Way out: run `bgc trade FILE`, or name a method: `solver rodas5p;`.
    """
    of = f"scene `{scene}`" if scene else "the model"
    return warning(
        "BG090",
        f"`solver auto`: there is no measurement of {of} in its present form; `{method}` was used",
        help="run `bgc trade` with the same `--set` and `--use`, or name a method",
    )


def nothing_to_measure(scene: str) -> Diagnostic:
    """BG091: no quantity to measure errors in

    What: the scene observes nothing, or only energy accounts.

    Why: `bgc trade` measures errors in the observed or required quantities.

    Example: `scene s of RLC { run 1 s; }`.

    Way out: add `observe NAME;` or `require NAME within VALUE;`.
    """
    of = f"scene `{scene}`" if scene else "the model"
    return error(
        "BG091",
        f"{of} observes nothing whose error can be measured",
        help="add `observe NAME;` to the scene, or `require NAME within VALUE;`",
    )


def no_reference(reasons: Sequence[str]) -> Diagnostic:
    """BG092: no reference solution

    What: fewer than two methods completed the run at a tight tolerance, so there is no reference to
    measure errors against.

    Why: the model fails (see the reasons), or needs more time than the budget allows.

    Example: a model that runs into a singularity.

    Way out: see with `bgc run FILE` how it fails, measure a shorter part with `--time`, or give
    more time with `--budget`.
    """
    return error(
        "BG092",
        f"there is no reference to measure errors against: {'; '.join(reasons)}",
        help="see how `bgc run --solver rodas5p` ends, shorten the run with `--time`, or increase "
        "`--budget`",
    )


def no_such_slot(pattern: str, slots: Sequence[str]) -> Diagnostic:
    """BG093: a slot that does not exist or has no alternatives

    What: the text after `--variants` matches no slot that another model fits.

    Why: `--variants` takes paths of slots (with `*` for any part of a path), `all`, `activity`, or
    statements of a scene: `use slot = type; set name = value`.

    Example: `--variants crane.elbw.lock`.

    Way out: use one of the slots that `bgc cost FILE` lists.
    """
    listed = ", ".join(f"`{slot}`" for slot in slots[:8]) or "none"
    return error(
        "BG093",
        f"`{pattern}` is not a slot of the scene with alternatives",
        help=did_you_mean(pattern, slots) or f"slots with alternatives: {listed}",
    )
