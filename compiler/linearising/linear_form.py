"""Differentiate an opened program by its states and inputs, exactly, as nodes."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.emission.differentiate import forward_rows
from bgc.ir.graph import Node
from bgc.linearising.analysis_scene import Opened
from bgc.record_class import dataclass

Entries = tuple[tuple[int, int, Node], ...]  # row, column, value


@dataclass(frozen=True, slots=True)
class LinearForm:
    """`M x' = f(t, x, u)`, `y = g(t, x, u)` with all derivatives, as nodes of `dag`.

    `by_state` holds the entries of df/dx and, in the rows below, of dg/dx; `by_input` likewise
    those of df/du and dg/du.
    """

    dag: Dag
    rates: tuple[Node, ...]  # f
    outputs: tuple[Node, ...]  # g
    by_state: Entries
    by_input: Entries


def linear_form(opened: Opened) -> LinearForm:
    """Differentiate the rates and the outputs of an opened program.

    The program is unchanged. Columns are in the order of its states and of its inputs.
    """
    program = opened.program
    dag = program.dag.copy()
    size = len(program.states)
    places = {varied.index: size + k for k, varied in enumerate(opened.inputs)}

    def column(symbol: Symbol) -> int | None:
        match symbol.kind:
            case Kind.STATE:
                return symbol.index
            case Kind.INPUT:
                return places.get(symbol.index)
            case _:
                return None

    rates = tuple(state.derivative for state in program.states)
    outputs = tuple(o.node for o in program.observations)
    rows = forward_rows(dag, (*rates, *outputs), column)
    return LinearForm(
        dag,
        rates,
        outputs,
        _entries(rows, 0, size),
        _entries(rows, size, size + len(places)),
    )


def _entries(rows: Sequence[dict[int, Node]], first: int, last: int) -> Entries:
    """The entries in columns from `first` to before `last`, renumbered from zero."""
    return tuple(
        (row, column - first, node)
        for row, derivatives in enumerate(rows)
        for column, node in sorted(derivatives.items())
        if first <= column < last
    )
