"""Understand 3: draw the bond graph with its causal strokes."""

from pathlib import Path

from bgc.causality.procedure import Procedure
from bgc.diagnostics.catalogue.arguments import unknown_part
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import strokes_of
from bgc.ir.causal import CausalGraph
from bgc.printing.draw import View, lay_out, part_paths, to_dot
from bgc.runtime.cli.command import Target, command, option, require
from bgc.runtime.cli.options import SceneOptions
from bgc.runtime.cli.printing import print_paths, write_file


@command()
def graph(
    scene: SceneOptions,
    out: str | None = option(
        "File to write: .svg, .pdf, .png or .dot; by default FILE.svg.",
        "-o",
        "--out",
        type=Target(".svg", ".dot", ".pdf", ".png"),
    ),
    depth: int | None = option("Draw parts below this level as one node each.", within=(0, None)),
    collapsed: tuple[str, ...] = option(
        "Draw this part as one node. May be repeated.", "--collapse", metavar="PART"
    ),
) -> None:
    """Draw the bond graph of a scene of FILE, with half arrows and causal strokes.

    Dashed arrows are signals that modulate an element. Pictures need Graphviz; .dot does not. A
    graph without a causality is drawn with the strokes that are certain, and red bonds at fault.
    """
    target = Path(out or f"{scene.file.stem}.svg")
    refusal: BgError | None = None
    causal: CausalGraph | Procedure
    try:
        causal = scene.stages("causality").causal
    except BgError:
        causal, refusal = strokes_of(scene.file, scene.options())
    parts = part_paths(causal.graph)
    for part in collapsed:
        require(part in parts, unknown_part(part, parts))
    text, kind = to_dot(causal, View(depth, collapsed)), target.suffix.lower()
    write_file(target, text if kind == ".dot" else lay_out(text, kind[1:]))
    print_paths([target])
    if refusal:
        raise refusal
