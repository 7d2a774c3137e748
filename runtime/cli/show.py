"""Understand 4: print the result of one pass of the compiler."""

from bgc.printing.stages import PASSES, needed_for, show_pass
from bgc.runtime.cli.command import command, option, require
from bgc.runtime.cli.options import SceneOptions, Whole
from bgc.runtime.cli.printing import print_text


@command()
def show(
    scene: SceneOptions,
    whole: Whole,
    name: str = option(
        "Name of the pass; an unknown name lists all passes.",
        "--after",
        metavar="PASS",
        default="equations",
        show_default=True,
    ),
) -> None:
    """Print the result of one pass of the compiler for a scene of FILE."""
    chosen = next((known for known in PASSES if known == name), PASSES[0])
    require(chosen == name, f"there is no pass {name}; there are {', '.join(PASSES)}")
    print_text(show_pass(chosen, scene.stages(needed_for(chosen), whole=whole)))
