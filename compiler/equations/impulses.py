"""Warn of flows and efforts with impulses, which the rates of dependent storage leave out.

A dependent capacitor has the charge that a source gives it. Where the source jumps, so does the
charge, and the flow has an impulse of that size. The equations hold the rate between jumps only.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from bgc.algebra.dag import Kind
from bgc.algebra.discontinuities import holding_sudden, jumps_in
from bgc.diagnostics.catalogue import equations as catalogue
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span
from bgc.equations.jumps import reset_places
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Node, Storage
from bgc.ir.program import StateJump


def impulse_warnings(
    variables: Variables, rates: Iterable[tuple[Node, Node]], resets: Sequence[StateJump]
) -> tuple[Diagnostic, ...]:
    """The warnings for rates that something reads: raw symbols, and the nodes whose rates they are.

    One warning for each element, whatever its width. `resets` are the jumps of states.
    """
    dag, fingerprints = variables.dag, variables.causal.fingerprints
    rates = list(rates)
    sudden = holding_sudden(dag, [node for _, node in rates])
    jumping = reset_places(resets)
    found: dict[int, dict[Span, None]] = {}
    for symbol, node in rates:
        if moved := _reset_in(variables, node, jumping):
            found.setdefault(variables.places.element_of(symbol), {}).update(moved)
        jumps = jumps_in(dag, fingerprints, node) if node in sudden else []
        if jumps:
            places = found.setdefault(variables.places.element_of(symbol), {})
            places |= {dag.places[n]: None for n in jumps if n in dag.places}
    warnings = []
    for index, places in found.items():
        element = variables.causal.graph.elements[index]
        if isinstance(element, Storage):
            what = {"C": "flow", "I": "effort"}.get(element.kind, "reaction")
            warnings.append(catalogue.impulses(element.span, element.name, what, list(places)))
        else:
            warnings.append(catalogue.modulus_jumps(element.span, element.name, list(places)))
    return tuple(warnings)


def _reset_in(
    variables: Variables, node: Node, jumping: Mapping[int, StateJump]
) -> dict[Span, None]:
    """The places of the jumps that reset a state in a node."""
    if not jumping:
        return {}
    states = variables.dag.symbols_in([node], Kind.STATE).values()
    return {jumping[s.index].span: None for s in states if s.index in jumping}
