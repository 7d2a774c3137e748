"""Draw a bond graph: half arrows, causal strokes, names, and parts as boxes.

Input: a causal graph. Output: the text of Graphviz's `dot` language, or a picture that `dot`
renders from it. A wide bond is a double line labelled with its width; if its components differ in
causality, the number of strokes is given at each end.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape

from bgc.algebra.disjoint_sets import DisjointSets
from bgc.diagnostics.catalogue.machine import dot_failed, dot_missing
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.causal import CausalGraph
from bgc.ir.graph import (
    FlatGraph,
    port_ends,
)

_COMPONENT = re.compile(r"\[\d+\]$")
SHORT = {"J0": "0", "J1": "1"}
HEAD = """digraph bond_graph {
  rankdir=LR; nodesep=0.25; ranksep=0.55; fontname="Helvetica"; fontsize=10;
  node [shape=box, peripheries=0, margin="0.06,0.04", width=0, height=0, fontname="Helvetica"];
  edge [dir=both, arrowtail=none, arrowhead=lvee, arrowsize=0.8, penwidth=1.1,
        fontname="Helvetica", fontsize=9, fontcolor="#555555"];
"""


@dataclass(frozen=True, slots=True)
class _Edge:
    """Bonds drawn as one edge between two nodes of the drawing."""

    tail: int
    head: int
    bonds: tuple[int, ...]


def lay_out(text: str, kind: str) -> bytes:
    """Render dot text as a picture in a format of Graphviz: svg, pdf, png."""
    program = shutil.which("dot")
    if program is None:
        raise BgError([dot_missing()])
    done = subprocess.run(
        [program, f"-T{kind}"], input=text.encode(), capture_output=True, check=False
    )
    if done.returncode != 0:
        raise BgError([dot_failed(done.stderr.decode("utf-8", "replace").strip())])
    return done.stdout


def to_dot(causal: CausalGraph) -> str:
    """Print a causal graph in the language of Graphviz's `dot`; equal graphs give equal text.

    Each element is a node; the components of a wide element share one. The stroke is at the end
    where the effort is imposed.
    """
    graph = causal.graph
    drawn = _merge_components(graph)
    edges = _edges(graph, drawn)
    members: dict[int, list[int]] = {}
    for element, node in enumerate(drawn):
        members.setdefault(node, []).append(element)
    names = {node: _name(graph, parts) for node, parts in members.items()}
    lines = [HEAD.rstrip()]
    lines += _clusters(sorted(names.items(), key=lambda item: item[0]), graph)
    lines += [_edge_line(edge, causal) for edge in edges]
    return "\n".join((*lines, "}", ""))


def _merge_components(graph: FlatGraph) -> list[int]:
    """Map each element to the first of those that share its node in the drawing.

    Elements share a node if they are components of one part at the same end of one wide bond.
    """
    sets = DisjointSets(len(graph.elements))
    first: dict[tuple[str, int, str, str], int] = {}
    for bond, sign, element in port_ends(graph):
        if graph.bonds[bond].width == 1:
            continue
        part = graph.elements[element]
        key = (graph.bonds[bond].wide, sign, part.kind, _COMPONENT.sub("", part.name))
        sets.unite(first.setdefault(key, element), element)
    return [sets.find(element) for element in range(len(graph.elements))]


def _edges(graph: FlatGraph, drawn: Sequence[int]) -> list[_Edge]:
    at = {(bond, sign): drawn[element] for bond, sign, element in port_ends(graph)}
    groups: dict[tuple[str, int, int], list[int]] = {}
    for bond in graph.bonds:
        tail, head = at[bond.index, -1], at[bond.index, 1]
        wide = bond.wide if bond.width > 1 else str(bond.index)
        groups.setdefault((wide, tail, head), []).append(bond.index)
    return [_Edge(tail, head, tuple(bonds)) for (_, tail, head), bonds in groups.items()]


def _name(graph: FlatGraph, parts: Sequence[int]) -> str:
    name = graph.elements[parts[0]].name
    return _COMPONENT.sub("", name) if len(parts) > 1 else name


def _clusters(nodes: Iterable[tuple[int, str]], graph: FlatGraph) -> list[str]:
    """Print the nodes, with a box around those of each part."""
    tree: dict[str, object] = {}
    for node, name in nodes:
        *path, last = name.split(".")
        place = tree
        for step in path:
            inner = place.setdefault(f"{step}.", {})
            assert isinstance(inner, dict)
            place = inner
        # A name may stand for several elements (the two sides of a merged part).
        place[f"{last} {node}"] = (node, last)
    return list(_print_tree(tree, (), graph))


def _print_tree(tree: dict[str, object], path: tuple[str, ...], graph: FlatGraph) -> Iterator[str]:
    indent = "  " * (len(path) + 1)
    for key, inner in tree.items():
        if isinstance(inner, dict):
            inside = (*path, key.removesuffix("."))
            yield f'{indent}subgraph "cluster_{escape(".".join(inside))}" {{'
            yield f'{indent}  label="{inside[-1]}"; labeljust=l; style=rounded; color="#bbbbbb";'
            yield from _print_tree(inner, inside, graph)
            yield f"{indent}}}"
        else:
            assert isinstance(inner, tuple)
            node, name = inner
            kind = graph.elements[node].kind
            label = (
                f"<b>{SHORT.get(kind, kind)}</b><br/>"
                f'<font point-size="9" color="#555555">{escape(name)}</font>'
            )
            yield f"{indent}n{node} [label=<{label}>];"


def _edge_line(edge: _Edge, causal: CausalGraph) -> str:
    at_head = sum(causal.strokes[bond].at_head for bond in edge.bonds)
    at_tail = len(edge.bonds) - at_head
    facts = ["arrowhead=teelvee"] if at_head else []
    facts += ["arrowtail=tee"] if at_tail else []
    if len(edge.bonds) > 1:
        facts += ['color="black:invis:black"', f'label="{len(edge.bonds)}"']
    if at_head and at_tail:
        facts += [f'headlabel="{at_head}"', f'taillabel="{at_tail}"']
    reasons = "\n".join(dict.fromkeys(causal.strokes[bond].reason for bond in edge.bonds))
    facts.append(f'edgetooltip="{_quoted(reasons)}"')
    return f"  n{edge.tail} -> n{edge.head} [{', '.join(facts)}];"


def _quoted(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
