"""The bond graph of a scene for the page: layouts, strokes, units, places in the source.

It is plain data for JSON. Layouts differ in the depth to which parts are opened. Powers of bonds
come from a model that is compiled once more, with effort and flow of each bond observed.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from bgc.algebra.dag import Kind
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.driver import Stages, compile_scene
from bgc.elaboration.scenes.variants import Change, variants_of
from bgc.ir.causal import CausalGraph
from bgc.ir.graph import FlatGraph, Observation, Slot
from bgc.options import Options
from bgc.printing.draw import DrawnNode, View, drawing, lay_out, part_paths, to_dot
from bgc.runtime.view.layout import layered
from bgc.runtime.view.meter import METERED, GraphOfScene
from bgc.runtime.view.scene_description import Description

_DEEPEST: Final = 4  # levels of parts that have layouts of their own
_COMPONENT = re.compile(r"\[\d+\]$")
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]\d+)?")
_INCH: Final = 72.0  # points


def graph_of_scene(path: Path, options: Options) -> GraphOfScene:
    """Compile a scene with meters at all bonds, and describe its graph; BgError where it fails."""
    stages, description = metered_stages(path, options)
    slots = _slots(variants_of(stages.package, stages.graph), stages.graph.slots)
    return GraphOfScene({**description, "slots": slots}, stages.built)


def metered_stages(path: Path, options: Options) -> tuple[Stages, Description]:
    """Compile a scene with meters at all bonds; return its stages and the description."""
    options = replace(options, preview=True, shapes=False)
    stages = compile_scene(path, options, prepare=with_meters)
    return stages, describe_graph(stages.causal)


def with_meters(graph: FlatGraph) -> FlatGraph:
    """Observe the effort and the flow of each scalar bond, in the order of the bonds."""
    dag = graph.dag
    added = [
        Observation(f"{METERED} {bond.index} {name}", unit, dag.symbol(kind, bond.index), bond.span)
        for bond in graph.bonds
        for name, kind, unit in (
            ("e", Kind.EFFORT, bond.effort_unit),
            ("f", Kind.FLOW, bond.flow_unit),
        )
    ]
    return replace(graph, observations=(*graph.observations, *added))


def describe_graph(causal: CausalGraph) -> Description:
    """Describe a graph: its scalar bonds, its parts and elements, and layouts by depth."""
    graph = causal.graph
    depth = max((path.count(".") + 1 for path in part_paths(graph)), default=0)
    views = [View(k) for k in range(1, min(depth, _DEEPEST) + 1)]
    if not views or depth > _DEEPEST:
        views.append(View())
    return {
        "bonds": [
            {
                "name": bond.name,
                "units": [bond.effort_unit, bond.flow_unit],
                "power": bond.power,
                "stroke": "head" if stroke.at_head else "tail",
                "rule": stroke.rule.value,
                "reason": stroke.reason,
                "line": _line(bond.span),
            }
            for bond, stroke in zip(graph.bonds, causal.strokes, strict=True)
        ],
        "parts": {p.path: {"model": p.model, "line": _line(p.span)} for p in graph.parts},
        "elements": {
            _COMPONENT.sub("", e.name): {"kind": e.kind, "line": _line(e.span)}
            for e in reversed(graph.elements)
        },
        "layouts": [_layout(causal, view) for view in views],
    }


def _slots(variants: Sequence[Change], slots: Sequence[Slot]) -> list[Description]:
    """The slots that other models fit too, those of the scene's own model first."""
    found = []
    for slot in sorted(slots, key=lambda slot: slot.path.count(".")):
        others = [change.value for change in variants if change.name == slot.path]
        if others:
            names = {"slot": slot.path, "interface": slot.interface}
            found.append({**names, "filled": slot.filled_by, "others": others})
    return found


def _line(span: Span) -> Description:
    """The line of the source in which a span begins."""
    line, _ = span.source.position(span.start)
    text = span.source.line(line).strip()
    return {"file": Path(span.source.name).name, "number": line, "text": text}


# --- layouts ----------------------------------------------------------------------------------


def _layout(causal: CausalGraph, view: View) -> Description:
    """One layout: by Graphviz where it is installed, else by `layered`."""
    found = drawing(causal, view)
    index = {node.number: k for k, node in enumerate(found.nodes)}
    nodes = [_node(node, node.number in found.varying) for node in found.nodes]
    edges = [
        {"tail": index[edge.tail], "head": index[edge.head], "bonds": list(edge.bonds)}
        for edge in found.edges
    ]
    signals = [[index[a], index[b]] for a, b in found.signals]
    clusters: list[Description] = []
    try:
        placed = json.loads(lay_out(to_dot(causal, view, marked=True), "json"))
    except BgError:
        _place_layered(nodes, edges)
    else:
        clusters = _place_by_graphviz(placed, nodes, edges, index)
    return {
        "depth": view.depth,
        "nodes": nodes,
        "edges": edges,
        "signals": signals,
        "clusters": clusters,
    }


def _node(node: DrawnNode, varies: bool) -> Description:
    kind = node.symbol
    return {
        "path": node.path,
        "name": node.path.rpartition(".")[2],
        "kind": f"M{kind}" if varies and kind else kind,
        "part": node.is_part,
        "size": _size(node),
    }


def _size(node: DrawnNode) -> tuple[float, float]:
    """The width and height that a node takes, in points."""
    name = node.path.rpartition(".")[2]
    if node.is_part:
        return 7.0 * len(name) + 20, 30.0
    return max(5.0 * len(name), 9.0 * len(node.label)) + 8, 34.0 if node.label else 18.0


def _place_layered(nodes: list[Description], edges: list[Description]) -> None:
    pairs = [(edge["tail"], edge["head"]) for edge in edges]
    at, curves = layered([node["size"] for node in nodes], pairs)
    for node, place in zip(nodes, at, strict=True):
        node["at"] = _rounded(place)
    for edge, curve in zip(edges, curves, strict=True):
        edge["curve"] = _rounded(x for point in curve for x in point)


def _place_by_graphviz(
    placed: dict[str, Any],
    nodes: list[Description],
    edges: list[Description],
    index: dict[int, int],
) -> list[Description]:
    """Take positions from Graphviz, whose y points up; return the boxes of the parts."""
    top = float(placed["bb"].split(",")[3])
    clusters = []
    for item in placed["objects"]:
        if item["name"].startswith("cluster_"):
            left, low, right, high = _numbers(item["bb"])
            label = item.get("label", "")
            box = _rounded((left, top - high, right - left, high - low))
            clusters.append({"label": label, "path": item["name"][8:], "box": box})
            continue
        node = nodes[index[int(item["name"][1:])]]
        x, y = _numbers(item["pos"])
        node["at"] = _rounded((x, top - y))
        node["size"] = _rounded((_INCH * float(item["width"]), _INCH * float(item["height"])))
    for item in placed.get("edges", ()):
        if "id" in item:
            edges[int(item["id"])]["curve"] = _spline(item["pos"], top)
    return clusters


def _spline(pos: str, top: float) -> list[float]:
    """The points of an edge of Graphviz, with the tips of its arrows where it has them."""
    found: dict[str, list[float]] = {"s": [], "e": [], "": []}
    for word in pos.split(";")[0].split():
        x, y = _numbers(word)
        found[word[0] if word[0] in found else ""] += (x, top - y)
    points = found[""]
    if found["s"]:
        points[:2] = found["s"]
    if found["e"]:
        points[-2:] = found["e"]
    return _rounded(points)


def _numbers(text: str) -> list[float]:
    return [float(number) for number in _NUMBER.findall(text)]


def _rounded(numbers: Any) -> list[float]:
    return [round(float(x), 1) for x in numbers]
