"""Derivatives of rates, outputs, commands and energies by states and inputs, for FMUs."""

from __future__ import annotations

from bgc.algebra.dag import Kind, Symbol
from bgc.emission.differentiate import forward_rows
from bgc.emission.inverses import with_inverses
from bgc.emission.kernels import hoisted_nodes
from bgc.ir.graph import Node
from bgc.ir.lowered import Kernel, Lowered, Reads, Store
from bgc.record_class import dataclass, replace

PARTIALS = "partials"


@dataclass(frozen=True, slots=True)
class Pattern:
    """The places of the entries that the kernel `partials` fills, in their order.

    Those of df/dx are not among them: the runtime has them. Rows are those of f, outputs, commands,
    and stored energy, supplied and dissipated power; columns are states, then inputs.
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]


def with_partials(lowered: Lowered, energies: bool) -> tuple[Lowered, Pattern]:
    """Add the kernel `partials` to a lowered program, on a DAG of its own.

    Modes of switches and values that sampled parts hold are constants. Without `energies`, the
    rows of the energies are empty.
    """
    program = lowered.program
    dag = program.dag.copy()
    size, inputs = len(program.states), program.inputs - program.slots

    def input_column(symbol: Symbol) -> int | None:
        is_free = symbol.kind is Kind.INPUT and symbol.index < inputs
        return size + symbol.index if is_free else None

    def column(symbol: Symbol) -> int | None:
        return symbol.index if symbol.kind is Kind.STATE else input_column(symbol)

    others = [o.node for o in program.observations]
    others += [value for device in program.devices for value in device.values]
    energy = program.energy
    others += (energy.stored, energy.supplied, energy.dissipated) if energies else ()
    derivatives = [state.derivative for state in program.states]
    entries: dict[tuple[int, int], Node] = {}
    if inputs:
        for row, found in enumerate(forward_rows(dag, derivatives, input_column)):
            entries |= {(row, k): node for k, node in found.items()}
    for row, found in enumerate(forward_rows(dag, others, column), size):
        entries |= {(row, k): node for k, node in found.items()}
    places = sorted(place for place, node in entries.items() if node != dag.zero)
    kernel = Kernel(
        PARTIALS,
        "Derivatives of f by inputs; of outputs, commands and energies by states and inputs.",
        ("h", "t", "x", "u"),
        ("j",),
        Reads.HOISTED,
        tuple(Store("j", k, entries[place]) for k, place in enumerate(places)),
    )
    prepare, *running = lowered.kernels
    hoisted = with_inverses(dag, hoisted_nodes(dag, (*running, kernel, *lowered.range_kernels)))
    prepare = replace(prepare, stores=tuple(Store("h", k, n) for k, n in enumerate(hoisted)))
    changed = replace(
        lowered,
        program=replace(program, dag=dag),
        hoisted=hoisted,
        kernels=(prepare, *running, kernel),
    )
    return changed, Pattern(tuple(r for r, _ in places), tuple(c for _, c in places))
