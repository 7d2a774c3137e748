"""Check that a model declares all items of its interfaces."""

from __future__ import annotations

from bgc.diagnostics.catalogue import slots
from bgc.diagnostics.collection import Report
from bgc.grammar import syntax
from bgc.resolution.modules import Declared, Module, ancestors, flatten
from bgc.values.units import parse_unit

_FITTING = {
    "param": {"param", "const"},
    "const": {"const"},
    "input": {"input"},
}
_READABLE = {"output", "signal", "let", "state", "param", "const", "unknown"}


def check_interfaces(module: Module, report: Report) -> None:
    """Report each statement of a file's interfaces that is not a declaration."""
    for declaration in module.file.declarations:
        if isinstance(declaration, syntax.Model) and declaration.interface:
            for item in declaration.items:
                if not isinstance(item, syntax.Value | syntax.Port | syntax.Part):
                    report.add(slots.statement_in_interface(item.span, declaration.name))


def check_conformance(declared: Declared[syntax.Model], report: Report) -> None:
    """Report each item of an interface that neither the model nor its base models declare.

    Items in both branches of an `if` count, since the condition is known only in a scene.
    """
    model = declared.syntax
    lineage = list(ancestors(declared))
    if model.interface:
        return
    items = [i for d in lineage if not d.syntax.interface for i in flatten(d.syntax.items)]
    members = {i.name: i for i in items if isinstance(i, syntax.Value | syntax.Port | syntax.Part)}
    for interface in (d.syntax for d in lineage if d.syntax.interface):
        for item in interface.items:
            if not isinstance(item, syntax.Value | syntax.Port | syntax.Part):
                continue
            missing = _missing(item, members.get(item.name))
            if missing:
                report.add(
                    slots.interface_misses(
                        model.name_span, model.name, interface.name, missing, item.name_span
                    )
                )


def _missing(item: syntax.Value | syntax.Port | syntax.Part, member: syntax.Item | None) -> str:
    """Describe the mismatch of a member with an interface's item; empty if it conforms."""
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
    """Return whether two units have one dimension; an absent or unknown unit matches any."""
    one = parse_unit(wanted) if wanted else None
    two = parse_unit(given) if given else None
    return one is None or two is None or one.dimension == two.dimension
