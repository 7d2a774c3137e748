"""Powers of elements over a run; the scene is compiled again to observe them.

The activity of an element is the integral over time of the absolute power that it exchanges; its
share of the sum is its activity index: L. S. Louca, J. L. Stein, G. M. Hulbert, J. Sprague, Proper
model generation: an energy-based methodology, Proc. ICBGM 1997. An element of several ports counts
the power of each port: a spring that passes power from one port to another is active even while
its stored energy is constant.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bgc.algebra.dag import Kind
from bgc.driver import compile_scene
from bgc.ir.graph import FlatGraph, Observation, Resistor, Storage
from bgc.record_class import dataclass, replace
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded_model import LoadedModel

_NAME = "power of port"  # names in a scene contain no blanks


@dataclass(frozen=True, slots=True)
class Activity:
    """The activity of an element (C, I, IC or R) in J."""

    element: str
    kind: str
    activity: float

    @property
    def part(self) -> str:
        """The part that the element belongs to; empty for an element of the scene's own model."""
        return self.element.rpartition(".")[0]


def metered_model(model: LoadedModel) -> tuple[LoadedModel, FlatGraph]:
    """The scene of a model with the power of every port of C, I and R observed, and its graph.

    Parts that the scene does without are compiled too, since their powers are observed.
    """
    stages = compile_scene(*model.source_for("powers"), prepare=_metered)
    metered = LoadedModel(stages.built, model.folder)
    metered.parameters.take(model.parameters)
    return metered, stages.graph


def _metered(graph: FlatGraph) -> FlatGraph:
    dag = graph.dag
    added = []
    for index, element in enumerate(graph.elements):
        if not isinstance(element, (Storage, Resistor)):
            continue
        for port in element.ports:
            if graph.bonds[port.bond].power:
                effort = dag.symbol(Kind.EFFORT, port.bond)
                node = dag.mul(effort, dag.symbol(Kind.FLOW, port.bond))
                name = f"{_NAME} {index} {port.bond}"
                added.append(Observation(name, "W", node, element.span))
    return replace(graph, observations=(*graph.observations, *added))


def activities(
    model: LoadedModel, graph: FlatGraph, times: Array, rows: Array
) -> tuple[tuple[Activity, ...], float]:
    """Compute the activities from the rows of a metered model, the largest first.

    Returns also the relative change of their sum if every second row is left out.
    """
    sums: dict[int, tuple[float, float]] = {}
    for column, variable in enumerate(model.measured):
        if not variable.name.startswith(_NAME):
            continue
        element = int(variable.name.removeprefix(_NAME).split()[0])
        power = np.abs(rows[:, column])
        fine, coarse = sums.get(element, (0.0, 0.0))
        sums[element] = (
            fine + float(np.trapezoid(power, times)),
            coarse + float(np.trapezoid(power[::2], times[::2])),
        )
    found = [
        Activity(graph.elements[k].name, graph.elements[k].kind, fine)
        for k, (fine, _) in sums.items()
    ]
    total = sum(fine for fine, _ in sums.values())
    coarse = sum(coarse for _, coarse in sums.values())
    found.sort(key=lambda activity: -activity.activity)
    return tuple(found), abs(coarse - total) / total if total > 0 else 0.0


def by_part(found: Sequence[Activity]) -> dict[str, float]:
    """Add up the activities of the elements of each part, the largest first.

    Elements of the scene's own model are listed by themselves.
    """
    sums: dict[str, float] = {}
    for activity in found:
        part = activity.part or activity.element
        sums[part] = sums.get(part, 0.0) + activity.activity
    return dict(sorted(sums.items(), key=lambda pair: -pair[1]))


def below(found: Sequence[Activity], part: str) -> float | None:
    """Add up the activities inside a part; None if it has no C, I or R."""
    inside = [a.activity for a in found if a.element.startswith(f"{part}.")]
    return sum(inside) if inside else None
