"""Understand 1: show causal strokes with their reasons, storage, loops."""

from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.printing.causality_table import causality_tables, stroke_table
from bgc.runtime.cli.command import command
from bgc.runtime.cli.options import SceneOptions
from bgc.runtime.cli.printing import print_tables


@command()
def causality(scene: SceneOptions) -> None:
    """Show the causality of a scene of FILE: strokes, storage, algebraic loops.

    A stroke, |-> or ->|, stands at the end of the bond that receives the effort. Each is printed
    with its reason.
    """
    try:
        stages = scene.stages("equations")
    except BgError:
        # Where the strokes are known, they help to understand why there are no equations.
        stages = compile_scene(scene.file, scene.options(), until="causality")
        print_tables([stroke_table(stages.causal)])
        raise
    print_tables(causality_tables(stages))
