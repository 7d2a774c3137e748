"""Inputs of an FMU besides the channels of devices: inputs of models, sources, parameters."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.algebra.dag import Kind, Level
from bgc.diagnostics.catalogue.analysis import input_in_mass
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import FlatGraph, Node
from bgc.ir.program import Program
from bgc.linearising.analysis_scene import (
    choose_inputs,
    input_candidates,
    with_followers,
    with_sources,
)
from bgc.record_class import dataclass, field, replace


@dataclass(slots=True)
class ChosenInputs:
    """The chosen inputs of a scene; `found` are their names and units, in order.

    An input is added to what the scene gives: at zero, which is its start, the scene is unchanged.
    Parameters whose defaults follow from a chosen one change with it.
    `replaced` are names of parameters that exist only to be varied.
    """

    texts: Sequence[str]
    found: list[tuple[str, str]] = field(default_factory=list)
    replaced: set[str] = field(default_factory=set)

    def applied_to(self, graph: FlatGraph) -> FlatGraph:
        """Add a symbol to each chosen source, input or parameter; device channels stay.

        The symbols follow those of the devices, before those of values that sampled parts hold.
        """
        candidates = input_candidates(graph)
        names = choose_inputs(candidates, self.texts)
        chosen = [(n, candidates[n]) for n in names if candidates[n].kind != "channel"]
        self.found[:] = [(name, candidate.unit) for name, candidate in chosen]
        dag, count = graph.dag, len(chosen)
        first = sum(len(device.inputs) for device in graph.devices)
        moved: dict[Node, Node] = {
            dag.symbol(Kind.INPUT, held.index): dag.symbol(Kind.INPUT, held.index + count)
            for held in graph.held
        }
        sources: dict[int, Node] = {}
        for k, (name, candidate) in enumerate(chosen):
            symbol = dag.symbol(Kind.INPUT, first + k)
            if candidate.kind == "source":
                sources[candidate.index] = symbol
                continue
            parameter = graph.parameters[candidate.index]
            node = dag.symbol(Kind.PARAM, candidate.index)
            if parameter.value == dag.zero:
                self.replaced.add(name)
                moved[node] = symbol
            else:
                moved[node] = dag.add(node, symbol)
        moved = with_followers(dag, graph.parameters, moved)
        roots = nodes_of(graph)
        new = dict(zip(roots, dag.substitute(roots, moved), strict=True))
        parameters = graph.parameters
        graph = replace(map_nodes(graph, dag, new.__getitem__), varied=count, parameters=parameters)
        held = tuple(replace(each, index=each.index + count) for each in graph.held)
        return replace(with_sources(graph, sources), held=held)

    def check(self, program: Program) -> None:
        """Raise BgError where an inertia depends on an input: it is constant during a run."""
        dag = program.dag
        nodes = [entry.value for entry in program.mass or ()]
        nodes += [state.scale for state in program.states]
        if self.found and any(dag.level[node] > Level.PARAM for node in nodes):
            raise BgError([input_in_mass(self.found[0][0])])
