"""Hints within the text: causal strokes and widths of bonds, units of values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bgc.editing.facts import BondFact, Facts, place_of
from bgc.grammar import syntax
from bgc.printing.causality_table import ranges
from bgc.record_class import dataclass
from bgc.resolution.modules import flatten

_LINES = 8  # different strokes that one explanation lists


@dataclass(frozen=True, slots=True)
class Hint:
    """A text at an offset, and what a pointer on it shows."""

    offset: int
    text: str
    explanation: str
    before: bool  # whether it belongs to what follows it


def hints(file: syntax.File, facts: Facts) -> tuple[Hint, ...]:
    """Return the hints of a file in the order of the text."""
    found: list[Hint] = []
    for declaration in file.declarations:
        if isinstance(declaration, syntax.Value):
            found += _unit(declaration, facts)
        if isinstance(declaration, syntax.Model):
            for item in flatten(declaration.items):
                match item:
                    case syntax.Chain():
                        found += _strokes(item, facts)
                    case syntax.Value():
                        found += _unit(item, facts)
                    case _:
                        pass
    return tuple(sorted(found, key=lambda hint: hint.offset))


def _strokes(chain: syntax.Chain, facts: Facts) -> Iterator[Hint]:
    """A hint for each bond: before its head, or behind its tail where several share a head."""
    first = chain.stops[0]  # of the stops with a bond behind them, only this one may be a list
    for tail, head in chain.links:
        if bonds := facts.bonds.get(place_of(tail.span.to(head.span))):
            at_tail = len(first) > 1 and tail in first
            place = tail.span.end if at_tail else head.span.start
            yield Hint(place, stroke_text(bonds), bond_text(bonds), before=not at_tail)


def stroke_text(bonds: Sequence[BondFact]) -> str:
    """Show on which side the stroke stands: `->|`, `|->`, with the width of a wide bond."""
    width = bonds[0].width
    sides = {fact.at_head for fact in bonds}
    if len(sides) == 1:
        arrow = "->|" if sides.pop() else "|->"
    else:
        arrow = ", ".join(
            f"{arrow}{ranges(some)}" if width > 1 else arrow
            for arrow, some in (
                ("->|", _components(bonds, True)),
                ("|->", _components(bonds, False)),
            )
        )
    return f"{arrow} {width}" if width > 1 and "[" not in arrow else arrow


def _components(bonds: Sequence[BondFact], at_head: bool) -> list[int]:
    return sorted({fact.component for fact in bonds if fact.at_head is at_head})


def bond_text(bonds: Sequence[BondFact]) -> str:
    """Explain a bond: its units, and the reason of its stroke; one line for each different one."""
    efforts = dict.fromkeys(b.effort_unit for b in bonds if b.effort_unit)
    flows = dict.fromkeys(b.flow_unit for b in bonds if b.flow_unit)
    lines: dict[str, set[int]] = {}
    for bond in bonds:
        tail, _, head = bond.name.partition(" -> ")
        arrow = "->|" if bond.at_head else "|->"
        reason = bond.reason.replace(f"[{bond.component}]`", "`")
        line = f"`{tail} {arrow} {head}`: {bond.rule}, {reason}"
        lines.setdefault(line, set()).add(bond.component)
    shown = [
        text if len(found) == bonds[0].width else f"{text}{ranges(sorted(found))}"
        for text, found in lines.items()
    ]
    if len(shown) > _LINES:
        shown[_LINES:] = [f"and {len(shown) - _LINES} more"]
    if efforts and flows:
        shown.append(f"effort in {', '.join(efforts)}; flow in {', '.join(flows)}")
    return "\n\n".join(shown)


def _unit(value: syntax.Value, facts: Facts) -> Iterator[Hint]:
    """The unit of a value that declares none and whose default shows none."""
    if value.unit is not None:
        return
    found = facts.values.get(place_of(value.name_span), ())
    units = {fact.unit for fact in found} - {"1", ""}
    if len(units) != 1 or (isinstance(value.value, syntax.Number) and value.value.unit):
        return
    (unit,) = units
    end = value.dims[-1].span.end + 1 if value.dims else value.name_span.end
    yield Hint(end, f": {unit}", "the unit that the compiler found, in SI", before=False)
