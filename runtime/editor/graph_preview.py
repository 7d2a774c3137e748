"""The bond graph of a file for the editor: a picture of a scene, or the reason for none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bgc.diagnostics.diagnostic import BgError
from bgc.driver import strokes_of
from bgc.editing.file_analysis import Analysis
from bgc.grammar.syntax import Scene
from bgc.options import Options
from bgc.printing.draw import View, lay_out, part_paths, to_dot
from bgc.record_class import asdict, dataclass

_MOST_ELEMENTS = 150  # elements that are drawn one by one unless a depth is asked for


@dataclass(frozen=True, slots=True)
class Asked:
    """The scene and the depth that the editor asks for; None for the first scene and a fit."""

    scene: str | None = None
    depth: int | None = None

    @classmethod
    def read(cls, params: Any) -> Asked:
        """Read the fields of a request; others than text and whole numbers count as missing."""
        scene, depth = (getattr(params, name, None) for name in ("scene", "depth"))
        whole = isinstance(depth, int) and not isinstance(depth, bool) and depth >= 0
        return cls(scene if isinstance(scene, str) and scene else None, depth if whole else None)


@dataclass(frozen=True, slots=True)
class Preview:
    """A picture (SVG) of a scene, with the scenes and depths to choose from.

    `message` says why there is no picture, or no causality in it. `depth` is -1 where all elements
    are drawn.
    """

    svg: str = ""
    scene: str = ""
    scenes: tuple[str, ...] = ()
    depth: int = -1
    depths: int = 0
    message: str = ""

    def content(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return asdict(self)


def preview(path: Path, analysis: Analysis, asked: Asked) -> Preview:
    """Draw a scene of an open file with its causal strokes; needs Graphviz.

    One without a causality is drawn up to the contradiction, with the message beside it.
    """
    declared = analysis.document.file.declarations
    scenes = tuple(each.name for each in declared if isinstance(each, Scene))
    if not scenes:
        return Preview(message="the file has no scene")
    scene = asked.scene if asked.scene in scenes else scenes[0]
    try:
        causal, refusal = strokes_of(path, Options(scene), analysis.package)
        depths = max((name.count(".") + 1 for name in part_paths(causal.graph)), default=0)
        depth = asked.depth
        if depth is None and depths and len(causal.graph.elements) > _MOST_ELEMENTS:
            depth = 1
        svg = lay_out(to_dot(causal, View(depth, ())), "svg").decode()
    except BgError as problem:
        return Preview(scene=scene, scenes=scenes, message=_message(problem))
    drawn = svg[svg.index("<svg") :]
    message = _message(refusal) if refusal else ""
    return Preview(drawn, scene, scenes, -1 if depth is None else depth, depths, message)


def _message(problem: BgError) -> str:
    first = problem.diagnostics[0]
    way_out = f" ({first.help})" if first.help else ""
    return f"{first.code}: {first.message}{way_out}"
