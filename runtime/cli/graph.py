"""`bgc graph`."""

from __future__ import annotations

import os
from pathlib import Path

import click

from bgc.diagnostics.catalogue.arguments import unknown_part
from bgc.diagnostics.catalogue.machine import unknown_file_kind
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.printing.draw import View, lay_out, part_paths, to_dot
from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import model_file, read_assignments, scene_option, set_option
from bgc.runtime.results.files import written_whole

_KINDS = (".svg", ".dot", ".pdf", ".png")


@click.command()
@model_file
@scene_option
@set_option
@click.option(
    "-o",
    "--out",
    metavar="FILE",
    help="File to write: .svg, .pdf, .png or .dot; by default FILE.svg.",
)
@click.option(
    "--depth", type=click.IntRange(min=0), help="Draw parts below this level as one node each."
)
@click.option(
    "--collapse",
    "collapsed",
    metavar="PART",
    multiple=True,
    help="Draw this part as one node. May be repeated.",
)
def graph(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    out: str | None,
    depth: int | None,
    collapsed: tuple[str, ...],
) -> None:
    """Draw the bond graph of a scene of FILE, with half arrows and causal strokes.

    Dashed arrows are signals that modulate an element. Pictures need Graphviz; .dot does not.
    """
    target = Path(out) if out is not None else Path(f"{file.stem}.svg")
    kind = target.suffix.lower()
    if kind not in _KINDS:
        raise BgError([unknown_file_kind(str(target), _KINDS)])
    options = Options(scene, read_assignments(assignments))
    stages = compile_scene(file, options, until="causality")
    parts = part_paths(stages.causal.graph)
    for part in collapsed:
        if part not in parts:
            raise BgError([unknown_part(part, parts)])
    text = to_dot(stages.causal, View(depth, collapsed))
    print_diagnostics(stages.warnings)
    picture = text.encode() if kind == ".dot" else lay_out(text, kind[1:])
    with written_whole(target) as aside:
        aside.write_bytes(picture)
    click.echo(os.fsencode(target))
