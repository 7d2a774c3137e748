"""BG087-BG089: stress maps of a scene, and the activity of its elements."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def not_a_drive(text: str) -> Diagnostic:
    """BG087: an invalid `--drive`

    What: the text after `--drive` does not name a quantity and its values.

    Why: the name, the `=` or the range is missing, the range does not increase, or no parameter
    matches the name.

    Example: `--drive stiffness`.

    Way out: write `--drive "k=1e3..1e14 N/m"` for decades, `"k=1 N/m..2 N/m:5"` for five values, or
    `"k=1 N/m, 5 N/m"`. Besides parameters, `step`, `rtol` and `time` can be driven. A `*` in a name
    matches any text: `"*.lock.stiffness=1e3..1e14 N/m"` drives all matching parameters together.
    """
    return error(
        "BG087",
        f"`{text}` is not a valid `--drive`",
        help="write NAME=LOW..HIGH, NAME=LOW..HIGH:COUNT or NAME=VALUE, VALUE",
    )


def nothing_to_judge(scene: str) -> Diagnostic:
    """BG088: nothing to judge

    What: the scene observes nothing, or only energy accounts.

    Why: `bgc stress` and `bgc activity` judge the observed quantities.

    Example: `scene s of RLC { run 1 s; }`.

    Way out: add `observe NAME;` to the scene.
    """
    of = f"scene `{scene}`" if scene else "the model"
    return error(
        "BG088",
        f"{of} observes nothing that can be judged",
        help="add `observe NAME;` to the scene",
    )


def nominal_run_failed(message: str) -> Diagnostic:
    """BG089: a scene that does not run

    What: the scene's own run failed, so there is nothing to compare with.

    Why: the message of that run gives the reason.

    Example: a scene with a failing `assert`.

    Way out: run it with `bgc run` and fix the error that it reports.
    """
    return error(
        "BG089",
        f"the scene does not run: {message}",
        help="run it with `bgc run` and fix the error that it reports",
    )
