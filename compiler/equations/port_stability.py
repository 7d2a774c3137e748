"""Check sampled ports: what takes their effort, and whether their stiffness is stable with it.

The limits are those of `language/port_limits.py`, with the parameters at their defaults.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.ir.defaults import known_at_start, program_values
from bgc.ir.graph import FlatGraph, Node, SampledPort
from bgc.ir.program import Program
from bgc.language.port_limits import SHORT, PortNumbers, judged, largest
from bgc.record_class import dataclass, replace

_SAMPLE = 1e-3  # s: of the devices, in a scene without `step`


def with_port_checks(program: Program, graph: FlatGraph) -> Program:
    """The program with the warnings about its sampled ports.

    Raises
    ------
    BgError
        BG471, BG472, BG474: a port that cannot be stable.
    """
    if not graph.ports:
        return program
    point = _start_of(program, graph)
    if point is None:
        return program
    found = [d for port in graph.ports for d in _check(program, graph, port, point)]
    errors = [d for d in found if d.code != "BG473"]
    if errors:
        raise BgError(errors)
    return replace(program, warnings=(*program.warnings, *found))


@dataclass(frozen=True, slots=True)
class _Point:
    """The values of all symbols at the start, and the mass matrix there."""

    values: dict[Symbol, float]
    states: tuple[float, ...]
    mass: tuple[tuple[int, int, float], ...] | None


def _start_of(program: Program, graph: FlatGraph) -> _Point | None:
    """The start at the parameters' defaults; None where it has no finite value."""
    dag = program.dag
    values = known_at_start(program, program_values(program))
    for device in graph.devices:
        for k, (channel, component) in enumerate(device.inputs, device.first_input):
            values[Symbol(Kind.INPUT, k)] = float(channel == "orientation" and component == 1)
    held = evaluate_nodes(dag, [h.initial for h in program.held], values)
    values |= {Symbol(Kind.INPUT, h.index): v for h, v in zip(program.held, held, strict=True)}
    states = tuple(evaluate_nodes(dag, [s.initial for s in program.states], values))
    entries = program.mass
    numbers = evaluate_nodes(dag, [e.value for e in entries or ()], values)
    if not all(map(math.isfinite, (*states, *numbers))):
        return None
    mass = None
    if entries is not None:
        mass = tuple((e.row, e.column, n) for e, n in zip(entries, numbers, strict=True))
    return _Point(values, states, mass)


def _check(
    program: Program, graph: FlatGraph, port: SampledPort, point: _Point
) -> list[Diagnostic]:
    """The diagnostics of a port."""
    nodes = [port.stiffness, port.damping, port.mass, port.resolution, port.lag, port.period]
    numbers = PortNumbers(*evaluate_nodes(program.dag, nodes, point.values))
    step = (graph.scene.step or _SAMPLE) if graph.devices else None
    return [*judged(port.span, port.name, numbers, step, _response(program, port, point))]


def _response(program: Program, port: SampledPort, point: _Point) -> tuple[float, float] | None:
    """The largest flow and acceleration of the bond for a unit of effort, of all components.

    None where the bond is not there: nothing reads it.
    """
    places = {state.name: k for k, state in enumerate(program.states)}
    efforts = {held.name: held.index for held in program.held}
    names = [f"{port.name}.{{}}[{k}]" for k in range(1, port.width + 1)]
    moved = [places.get(name.format("moved")) for name in names]
    if None in moved or not all(name.format("effort") in efforts for name in names):
        return None
    rates = [state.derivative for state in program.states]
    flows = [rates[k] for k in moved if k is not None]
    dag = program.dag
    if any(dag.value(flow) != 0 and not _moves(program, flow) for flow in flows):
        return math.nan, math.nan
    begin = _evaluated(program, rates, point.values, point.states)
    steps, pushes = [], []
    for name in names:
        symbol = Symbol(Kind.INPUT, efforts[name.format("effort")])
        more = {**point.values, symbol: point.values[symbol] + 1.0}
        pushed = _evaluated(program, rates, more, point.states)
        change = _solved(point, [b - a for a, b in zip(begin, pushed, strict=True)])
        steps.append([change[k] for k in moved if k is not None])
        ahead = [x + SHORT * c for x, c in zip(point.states, change, strict=True)]
        later = _evaluated(program, flows, point.values, ahead)
        now = [begin[k] for k in moved if k is not None]
        pushes.append([(b - a) / SHORT for a, b in zip(now, later, strict=True)])
    return largest(steps), largest(pushes)


def _moves(program: Program, flow: Node) -> bool:
    """Return whether a flow depends on a state or an effort, and not on time and inputs alone."""
    held = {h.index for h in program.held}
    symbols = program.dag.symbols_in([flow], Kind.STATE, Kind.INPUT).values()
    return any(s.kind is Kind.STATE or s.index in held for s in symbols)


def _evaluated(
    program: Program, nodes: Sequence[Node], values: dict[Symbol, float], states: Sequence[float]
) -> list[float]:
    """Values of nodes at states."""
    at = {**values, **{Symbol(Kind.STATE, k): x for k, x in enumerate(states)}}
    return list(evaluate_nodes(program.dag, nodes, at))


def _solved(point: _Point, right: list[float]) -> list[float]:
    """The rates that belong to a right-hand side."""
    if point.mass is None:
        return right
    import numpy as np  # heavy, and needed by few models

    matrix = np.zeros((len(right), len(right)))
    for row, column, number in point.mass:
        matrix[row, column] += number
    return [float(x) for x in np.linalg.lstsq(matrix, np.array(right), rcond=None)[0]]
