"""BG087-BG089: driving a scene to its extremes, and the activity of its elements."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic


def not_a_drive(text: str) -> Diagnostic:
    """BG087: a drive without a range

    What: `--drive` names what is driven and the values that it takes; this text does not.

    Why: the name, the `=` or the range is missing, the range does not rise, or no parameter has a
    name like that.

    Example: `--drive stiffness`.

    Way out: `--drive "k=1e3..1e14 N/m"` by decades, `"k=1 N/m..2 N/m:5"` in five values, or
    `"k=1 N/m, 5 N/m"`. Besides parameters there are `step`, `rtol` and `time`. A `*` in a name
    stands for anything: `"*.lock.stiffness=1e3..1e14 N/m"` drives all of such names together.
    """
    return error(
        "BG087",
        f"`{text}` is no drive",
        help="write NAME=LOW..HIGH, NAME=LOW..HIGH:COUNT or NAME=VALUE, VALUE",
    )


def nothing_to_judge(scene: str) -> Diagnostic:
    """BG088: nothing that could be right or wrong

    What: `bgc stress` and `bgc activity` judge what the scene observes, and it observes nothing,
    or energy accounts alone.

    Why: states are of no interest by themselves; what is observed is.

    Example: `scene s of RLC { run 1 s; }`.

    Way out: `observe NAME;` in the scene.
    """
    of = f"scene `{scene}`" if scene else "the model"
    return error(
        "BG088",
        f"{of} observes nothing that could be right or wrong",
        help="add `observe NAME;` to the scene",
    )


def nominal_run_failed(message: str) -> Diagnostic:
    """BG089: the scene does not run as it is

    What: the scene's own run was not completed, so that there is nothing to compare with.

    Why: the message of that run tells.

    Example: a scene whose `assert` fails.

    Way out: `bgc run` the scene, and mend what it says.
    """
    return error(
        "BG089",
        f"the scene does not run as it is: {message}",
        help="`bgc run` it, and mend what it says",
    )
