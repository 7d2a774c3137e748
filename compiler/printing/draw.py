"""Draw a bond graph: half arrows, causal strokes, names, and parts as boxes.

Input: a causal graph, or one whose strokes are placed up to a contradiction; the bonds at fault are
red then, and bonds that are still open have no stroke. Output: the text of Graphviz's `dot`
language, or a picture that `dot` renders from it. Dashed arrows are signals that modulate an
element. A wide bond is a double line labelled with its width; if its components differ in
causality, the number of strokes is given at each end.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Sequence, Set
from html import escape
from typing import Literal

from bgc.algebra.disjoint_sets import DisjointSets
from bgc.causality.procedure import Procedure
from bgc.diagnostics.catalogue.machine import dot_failed, dot_missing
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.causal import CausalGraph
from bgc.ir.graph import FlatGraph, port_ends
from bgc.language.elements import ELEMENTS
from bgc.printing.modulation import Modulation, modulations
from bgc.record_class import dataclass, replace

_COMPONENT = re.compile(r"\[\d+\]$")
HEAD = """digraph bond_graph {
  rankdir=LR; nodesep=0.25; ranksep=0.55; fontname="Helvetica"; fontsize=10;
  node [shape=box, peripheries=0, margin="0.06,0.04", width=0, height=0, fontname="Helvetica"];
  edge [dir=both, arrowtail=none, arrowhead=lvee, arrowsize=0.8, penwidth=1.1,
        fontname="Helvetica", fontsize=9, fontcolor="#555555"];
"""


@dataclass(frozen=True, slots=True)
class DrawnEdge:
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


def to_dot(causal: CausalGraph | Procedure, view: View | None = None, marked: bool = False) -> str:
    """Print a causal graph in the language of Graphviz's `dot`; equal graphs give equal text.

    Each element is a node; the components of a wide element share one, and so do all elements of
    a part that `view` does not open. The stroke is at the end where the effort is imposed. Elements
    that a signal modulates are drawn as MTF, MGY, MR, MSe, MSf; thin dashed arrows lead to them
    from what they read. `marked` edges have their numbers in `drawing` as `id`.
    """
    found = drawing(causal, view or View())
    lines = [HEAD.rstrip()]
    lines += _clusters(found.nodes, found.varying)
    lines += [_edge_line(edge, causal, marked and k) for k, edge in enumerate(found.edges)]
    lines += [
        f'  n{tail} -> n{head} [style=dashed, penwidth=0.7, color="#7a7a7a", arrowhead=vee, '
        "arrowsize=0.6, constraint=false];"
        for tail, head in found.signals
    ]
    return "\n".join((*lines, "}", ""))


def drawing(causal: CausalGraph | Procedure, view: View) -> Drawing:
    """Choose the nodes and edges of a drawing."""
    graph = causal.graph
    modulated = modulations(graph)
    nodes: dict[str, DrawnNode] = {}
    drawn = [
        view.node_of(nodes, graph, element, first)
        for element, first in enumerate(_merge_components(graph))
    ]
    varying = {drawn[k] for k, modulation in enumerate(modulated) if modulation.varies}
    signals = _signals(graph, view, modulated, drawn, nodes)
    edges = _edges(graph, drawn)
    return Drawing(tuple(nodes.values()), tuple(edges), tuple(signals), frozenset(varying))


def part_paths(graph: FlatGraph) -> set[str]:
    """The paths of all parts that hold elements, which a view may collapse."""
    paths = (element.name.split(".")[:-1] for element in graph.elements)
    return {".".join(path[: k + 1]) for path in paths for k in range(len(path))}


@dataclass(frozen=True, slots=True)
class DrawnNode:
    """A node of the drawing: its number, its path, and its label, empty for a signal."""

    number: int
    path: str
    label: str
    is_part: bool = False

    @property
    def symbol(self) -> str:
        """The label as it is drawn: `1` for J1."""
        kind = ELEMENTS.get(self.label)
        return (kind and kind.symbol) or self.label


@dataclass(frozen=True, slots=True)
class Drawing:
    """The nodes and edges of a drawing; `signals` are the dashed arrows, as numbers of nodes.

    `varying` are the numbers of the nodes that signals modulate.
    """

    nodes: tuple[DrawnNode, ...]
    edges: tuple[DrawnEdge, ...]
    signals: tuple[tuple[int, int], ...]
    varying: Set[int]


@dataclass(frozen=True, slots=True)
class View:
    """The parts that a drawing opens: those up to `depth` levels, without those of `collapsed`.

    A part that is not opened is one node. Without `depth` all are opened.
    """

    depth: int | None = None
    collapsed: tuple[str, ...] = ()

    def closed_part(self, name: str) -> str:
        """The outermost part around an element that is not opened; an empty text if none is."""
        steps = name.split(".")[:-1]
        for k in range(1, len(steps) + 1):
            part = ".".join(steps[:k])
            if part in self.collapsed or (self.depth is not None and k > self.depth):
                return part
        return ""

    def node_of(
        self, nodes: dict[str, DrawnNode], graph: FlatGraph, element: int, first: int
    ) -> int:
        """The number of the node of an element, which is made if it is new."""
        of = graph.elements[first]
        part = self.closed_part(of.name)
        key = f"part {part}" if part else f"element {first}"
        if key not in nodes:
            nodes[key] = (
                DrawnNode(first, part, "", is_part=True)
                if part
                else DrawnNode(first, of.name, of.kind)
            )
        if not part and element != first and nodes[key].path == of.name:
            path = _COMPONENT.sub("", of.name)  # several components: the name of the wide part
            nodes[key] = replace(nodes[key], path=path)
        return nodes[key].number


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


def _edges(graph: FlatGraph, drawn: Sequence[int]) -> list[DrawnEdge]:
    at = {(bond, sign): drawn[element] for bond, sign, element in port_ends(graph)}
    groups: dict[tuple[str, int, int], list[int]] = {}
    for bond in graph.bonds:
        tail, head = at[bond.index, -1], at[bond.index, 1]
        if tail == head:
            continue  # within a part that is not opened
        wide = bond.wide if bond.width > 1 else str(bond.index)
        groups.setdefault((wide, tail, head), []).append(bond.index)
    return [DrawnEdge(tail, head, tuple(bonds)) for (_, tail, head), bonds in groups.items()]


def _signals(
    graph: FlatGraph,
    view: View,
    modulated: Sequence[Modulation],
    drawn: Sequence[int],
    nodes: dict[str, DrawnNode],
) -> list[tuple[int, int]]:
    """The dashed arrows; declared states, unknowns and devices that they leave become nodes."""
    found: dict[tuple[int, int], None] = {}
    for head, modulation in zip(drawn, modulated, strict=True):
        for element in modulation.elements:
            found[drawn[element], head] = None
        for signal in modulation.signals:
            name = _COMPONENT.sub("", signal)
            part = view.closed_part(name)
            key = f"part {part}" if part else f"signal {name}"
            if key not in nodes:
                number = len(graph.elements) + len(nodes)
                nodes[key] = DrawnNode(number, part or name, "", is_part=bool(part))
            found[nodes[key].number, head] = None
    return [(tail, head) for tail, head in found if tail != head]


def _clusters(nodes: Iterable[DrawnNode], varying: Set[int]) -> list[str]:
    """Print the nodes, with a box around those of each part."""
    tree: dict[str, object] = {}
    for node in sorted(nodes, key=lambda node: node.number):
        *path, last = node.path.split(".")
        place = tree
        for step in path:
            inner = place.setdefault(f"{step}.", {})
            assert isinstance(inner, dict)
            place = inner
        # A name may stand for several elements (the two sides of a merged part).
        place[f"{last} {node.number}"] = (node, last)
    return list(_print_tree(tree, (), varying))


def _print_tree(tree: dict[str, object], path: tuple[str, ...], varying: Set[int]) -> Iterator[str]:
    indent = "  " * (len(path) + 1)
    for key, inner in tree.items():
        if isinstance(inner, dict):
            inside = (*path, key.removesuffix("."))
            yield f'{indent}subgraph "cluster_{escape(".".join(inside))}" {{'
            yield f'{indent}  label="{inside[-1]}"; labeljust=l; style=rounded; color="#bbbbbb";'
            yield from _print_tree(inner, inside, varying)
            yield f"{indent}}}"
        else:
            assert isinstance(inner, tuple)
            node, name = inner
            yield f"{indent}n{node.number} [{_label(node, name, node.number in varying)}];"


def _label(node: DrawnNode, name: str, varies: bool) -> str:
    grey = f'<font point-size="9" color="#555555">{escape(name)}</font>'
    if node.is_part:
        return f'label="{name}", peripheries=1, style=rounded, margin="0.12,0.08"'
    if not node.label:
        return f"label=<<i>{grey}</i>>"
    return f"label=<<b>{'M' if varies else ''}{node.symbol}</b><br/>{grey}>"


def _edge_line(edge: DrawnEdge, causal: CausalGraph | Procedure, mark: int | Literal[False]) -> str:
    strokes = [stroke for bond in edge.bonds if (stroke := causal.strokes[bond]) is not None]
    at_fault = isinstance(causal, Procedure) and not {*edge.bonds}.isdisjoint(causal.at_fault)
    colour = "#c62828" if at_fault else "black"
    at_head = sum(stroke.at_head for stroke in strokes)
    at_tail = len(strokes) - at_head
    facts = [] if mark is False else [f'id="{mark}"']
    facts += ["arrowhead=teelvee"] if at_head else []
    facts += ["arrowtail=tee"] if at_tail else []
    if len(edge.bonds) > 1:
        facts += [f'color="{colour}:invis:{colour}"', f'label="{len(edge.bonds)}"']
    elif at_fault:
        facts += [f'color="{colour}"']
    if at_head and at_tail:
        facts += [f'headlabel="{at_head}"', f'taillabel="{at_tail}"']
    reasons = "\n".join(dict.fromkeys(stroke.reason for stroke in strokes))
    facts.append(f'edgetooltip="{_quoted(reasons)}"')
    return f"  n{edge.tail} -> n{edge.head} [{', '.join(facts)}];"


def _quoted(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
