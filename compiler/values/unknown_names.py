"""The diagnostic of a name that is not declared."""

from __future__ import annotations

import re
from collections.abc import Iterable

from bgc.diagnostics.catalogue import names, values
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.grammar.peers import value_advice
from bgc.values.units import parse_unit, ungrouped_unit


def unknown_name(expr: syntax.Name, candidates: Iterable[str], otherwise: str = "") -> Diagnostic:
    """Report an unknown name, or the unit with parentheses that it is a word of.

    `otherwise` is the help where no other advice is known.
    """
    source = expr.span.source
    unit = ungrouped_unit(source.text, expr.span.start)
    if unit is None or not re.match(r"[0-9.] ", source.text[max(unit[0] - 2, 0) : unit[0]]):
        return names.unknown_name(
            expr.span, expr.name, candidates, value_advice(expr.name), _as_unit(expr) or otherwise
        )
    start, end, spelled = unit
    return values.unit_with_parentheses(Span(source, start, end), spelled)


def _as_unit(expr: syntax.Name) -> str:
    """The place of a unit, where an unknown name may be meant as one: `1.5*mm`."""
    if parse_unit(expr.name) is None:
        return ""
    source, span = expr.span.source, expr.span
    declared = re.search(r"\b(\w+)\s*\[\s*$", source.text[: span.start])
    if declared is not None and re.match(r"\s*\]\s*=", source.text[span.end :]):
        return f"a unit follows a colon: `{declared[1]} : {expr.name} = ..`"
    return f"declare it, or write the unit behind its number: `3 {expr.name}`"
