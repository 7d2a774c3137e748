"""Understand 1: show causal strokes with their reasons, storage, loops."""

from bgc.causality.procedure import Procedure
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import strokes_of
from bgc.printing.causality_table import causality_tables, procedure_table, stroke_table
from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.options import SceneOptions
from bgc.runtime.cli.printing import print_tables


@command()
def causality(
    scene: SceneOptions,
    steps: bool = option("Show the strokes in the order in which they are assigned."),
) -> None:
    """Show the causality of a scene of FILE: strokes, storage, algebraic loops.

    A stroke, |-> or ->|, stands at the end of the bond that receives the effort. Each is printed
    with its reason. With --steps, each choice stands before the strokes that follow from it; a
    graph without a causality is shown so up to the contradiction.
    """
    try:
        stages = scene.stages("equations")
    except BgError:
        # The strokes that are known help to understand why there are no equations.
        found, _ = strokes_of(scene.file, scene.options())
        if steps or isinstance(found, Procedure):
            print_tables([procedure_table(found)])
        else:
            print_tables([stroke_table(found)])
        raise
    print_tables([procedure_table(stages.causal)] if steps else causality_tables(stages))
