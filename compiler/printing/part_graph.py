"""Draw the bond graph of a model as it is written: its parts, ports and bonds, one level deep.

Input: a declared model. Output: text of Graphviz's `dot` language, which `draw.lay_out` makes a
picture of. There are no causal strokes, which depend on what a model is connected to. A double line
is a bond of more than one component, with its width.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape

from bgc.grammar import syntax
from bgc.language.elements import ELEMENTS, Family
from bgc.printing.draw import HEAD
from bgc.record_class import dataclass
from bgc.resolution.modules import Declared, Module, ancestors, flatten


@dataclass(frozen=True, slots=True)
class _End:
    """An end of a bond: the node it meets, the port of a part that it names, its width.

    `whole` says that the width is that of all bonds of the node: a junction without a slice.
    """

    node: str
    port: str
    width: str
    whole: bool


def part_graph(declared: Declared[syntax.Model]) -> str:
    """Print the graph of a model with its inherited parts; empty where it has no bonds."""
    items = list(_items(declared))
    chains = [item for item in items if isinstance(item, syntax.Chain)]
    if not chains:
        return ""
    nodes = {item.name: item for item in items if isinstance(item, syntax.Part | syntax.Port)}
    edges = [edge for chain in chains for edge in _edges(chain, nodes, declared.module)]
    widths = _widths(edges)
    used = {end.node for edge in edges for end in edge}
    lines = [HEAD.rstrip(), '  bgcolor="white"; size="9,6";']
    lines += [_node(name, item) for name, item in nodes.items() if name in used]
    lines += [_edge(edge, width) for edge, width in zip(edges, widths, strict=True)]
    return "\n".join((*lines, "}", ""))


def _items(declared: Declared[syntax.Model]) -> Iterator[syntax.Item]:
    for owner in reversed(list(ancestors(declared))):
        if not owner.syntax.interface or owner.syntax is declared.syntax:
            yield from flatten(owner.syntax.items)


# --- bonds --------------------------------------------------------------------------------


def _edges(
    chain: syntax.Chain, nodes: dict[str, syntax.Part | syntax.Port], module: Module
) -> Iterator[tuple[_End, _End]]:
    for tail, head in chain.links:
        yield _end(tail, nodes, module, False), _end(head, nodes, module, True)


def _end(
    expr: syntax.Expr,
    nodes: dict[str, syntax.Part | syntax.Port],
    module: Module,
    is_head: bool,
) -> _End:
    """Read `hub`, `hub[1..3]`, `joint.shaft`, `mass[i]`."""
    index: tuple[syntax.Expr | syntax.Range, ...] = ()
    port = ""
    while not isinstance(expr, syntax.Name):
        match expr:
            case syntax.Member():
                port, expr = expr.name, expr.base
            case syntax.Index():
                index, expr = expr.indices, expr.base
            case _:
                raise AssertionError("an end of a bond is a path")
    item = nodes[expr.name]
    if isinstance(item, syntax.Port):
        return _End(expr.name, port, _port_width(item, module, {}), False)
    if item.type.name in ELEMENTS:
        whole = ELEMENTS[item.type.name].family is Family.JUNCTION and not index
        return _End(expr.name, port, _element_width(item, index, is_head), whole)
    return _End(expr.name, port, _model_width(item, port, module, is_head), False)


def _widths(edges: Sequence[tuple[_End, _End]]) -> list[str]:
    """Return the width of each bond, where it is known: those of a junction are one width."""
    found = [head.width or tail.width for tail, head in edges]
    at: dict[str, str] = {}
    for _ in edges:
        for place, edge in enumerate(edges):
            for end in edge:
                if end.whole and found[place]:
                    at.setdefault(end.node, found[place])
                if end.whole and not found[place]:
                    found[place] = at.get(end.node, "")
    return found


def _element_width(
    part: syntax.Part, index: Iterable[syntax.Expr | syntax.Range], is_head: bool
) -> str:
    sizes = [_text(size) for size in part.type.dims]
    joined = part.type.name == ("Demux" if is_head else "Mux")
    if joined and all(size.isdigit() for size in sizes):
        return str(sum(map(int, sizes)))
    if any(isinstance(i, syntax.Range) for i in index) or len(sizes) != 1:
        return ""
    return sizes[0]


def _model_width(part: syntax.Part, name: str, module: Module, is_head: bool) -> str:
    """The width of the port that a part shows there, as its model declares it."""
    model = module.models.get(part.type.name)
    if model is None:
        return ""
    ports = [item for item in _items(model) if isinstance(item, syntax.Port)]
    wanted = syntax.Direction.IN if is_head else syntax.Direction.OUT
    fitting = [
        port for port in ports if (port.name == name if name else port.direction in (wanted, None))
    ]
    chosen = [port for port in fitting if port.main] if len(fitting) > 1 else fitting
    formals = (formal.name for formal in model.syntax.formals)
    sizes = dict(zip(formals, map(_text, part.type.dims), strict=False))
    return _port_width(chosen[0], model.module, sizes) if len(chosen) == 1 else ""


def _port_width(port: syntax.Port, module: Module, sizes: Mapping[str, str]) -> str:
    """The width of a port, dimensions of its model replaced by their `sizes`."""
    if port.dims:
        width = _text(port.dims[0])
        return sizes.get(width, width)
    domain = module.domains.get(port.domain) if port.domain else None
    if domain is None:
        return ""
    efforts = [v.dims for v in domain.syntax.variables if v.kind == "effort"]
    return str(sum(int(_text(d[0])) if d and _text(d[0]).isdigit() else 1 for d in efforts))


# --- text of dot ----------------------------------------------------------------------------


def _text(expr: syntax.Expr) -> str:
    return "".join(expr.span.text.split())


def _node(name: str, item: syntax.Part | syntax.Port) -> str:
    if isinstance(item, syntax.Port):
        label = f'<font color="#0072B2">{escape(name)}</font>'
        return f'  "{name}" [label=<{label}>];'
    kind = item.type.name
    sizes = ", ".join(_text(size) for size in item.type.dims)
    row = ELEMENTS.get(kind)
    shown = ((row and row.symbol) or kind) + (f"[{sizes}]" if sizes else "")
    index = f"[{', '.join(_text(i) for i in item.index)}]" if item.index else ""
    label = (
        f"<b>{escape(shown)}</b><br/>"
        f'<font point-size="9" color="#555555">{escape(name + index)}</font>'
    )
    box = "" if row else ' peripheries=1 style=rounded color="#999999"'
    return f'  "{name}" [label=<{label}>{box}];'


def _edge(ends: tuple[_End, _End], width: str) -> str:
    tail, head = ends
    facts = []
    if width not in ("", "1"):
        facts += ['color="black:invis:black"', f'label="{escape(width)}"']
    facts += [f'taillabel="{tail.port}"'] if tail.port else []
    facts += [f'headlabel="{head.port}"'] if head.port else []
    attributes = f" [{', '.join(facts)}]" if facts else ""
    return f'  "{tail.node}" -> "{head.node}"{attributes};'
