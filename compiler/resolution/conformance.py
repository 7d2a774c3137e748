"""Whether models have what the interfaces list that they are declared to be."""

from __future__ import annotations

from bgc.diagnostics.catalogue import names
from bgc.diagnostics.report import Report
from bgc.grammar import syntax
from bgc.resolution.modules import Declared, ancestors, flatten
from bgc.values.units import parse_unit

_FITTING = {
    "param": {"param", "const"},
    "const": {"const"},
    "input": {"input"},
}
_READABLE = {"output", "signal", "let", "state", "param", "const", "unknown"}


def check_conformance(declared: Declared[syntax.Model], report: Report) -> None:
    """Report each item of an interface that the model, or what it extends, does not declare.

    Both branches of an `if` count: which one is taken is not known before the model is used.
    """
    model = declared.syntax
    line = list(ancestors(declared))
    if model.interface:
        return
    items = [i for d in line if not d.syntax.interface for i in flatten(d.syntax.items)]
    members = {i.name: i for i in items if isinstance(i, syntax.Value | syntax.Port | syntax.Part)}
    for interface in (d.syntax for d in line if d.syntax.interface):
        for item in interface.items:
            if not isinstance(item, syntax.Value | syntax.Port | syntax.Part):
                continue
            missing = _missing(item, members.get(item.name))
            if missing:
                report.add(
                    names.interface_misses(
                        model.name_span, model.name, interface.name, missing, item.name_span
                    )
                )


def _missing(item: syntax.Value | syntax.Port | syntax.Part, member: syntax.Item | None) -> str:
    """What is missing where `member` stands for an interface's item, in words; empty if nothing."""
    match item:
        case syntax.Value():
            kind = member.kind if isinstance(member, syntax.Value) else ""
            if kind not in _FITTING.get(item.kind, _READABLE):
                return f"{item.kind} `{item.name}`"
            assert isinstance(member, syntax.Value)
            fits = _same_kind(item.unit, member.unit)
            return "" if fits else f"{item.kind} `{item.name}` in {item.unit}"
        case syntax.Port():
            wanted = f"`{item.direction.value}` " if item.direction else ""
            if isinstance(member, syntax.Port) and item.direction in (None, member.direction):
                return ""
            return f"{wanted}port `{item.name}`"
        case syntax.Part():
            return "" if isinstance(member, syntax.Part) else f"part `{item.name}`"


def _same_kind(wanted: str | None, given: str | None) -> bool:
    """Whether two units as written are of one kind; what is not written, or no unit, may be."""
    one = parse_unit(wanted) if wanted else None
    two = parse_unit(given) if given else None
    return one is None or two is None or one.dimension == two.dimension
