"""The diagnostic of a name that is not declared."""

from __future__ import annotations

import re
from collections.abc import Iterable

from bgc.diagnostics.catalogue import names, values
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.grammar.peers import value_advice
from bgc.values.units import ungrouped_unit


def unknown_name(expr: syntax.Name, candidates: Iterable[str]) -> Diagnostic:
    """Report an unknown name, or the unit with parentheses that it is a word of."""
    source = expr.span.source
    unit = ungrouped_unit(source.text, expr.span.start)
    if unit is None or not re.match(r"[0-9.] ", source.text[max(unit[0] - 2, 0) : unit[0]]):
        return names.unknown_name(expr.span, expr.name, candidates, value_advice(expr.name))
    start, end, spelled = unit
    return values.unit_with_parentheses(Span(source, start, end), spelled)
