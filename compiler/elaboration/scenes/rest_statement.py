"""Read the start at rest of a scene: the values to hold, and the parameters to vary."""

from __future__ import annotations

from bgc.algebra.dag import Kind, Symbol
from bgc.diagnostics.catalogue import scenes
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.components import component_names
from bgc.elaboration.instances.scopes import path_of
from bgc.elaboration.instances.world import World
from bgc.elaboration.scenes.observations import Observed
from bgc.elaboration.scenes.scene_choice import Scene
from bgc.grammar import syntax
from bgc.ir.graph import Node, Observation
from bgc.language.scene import Rest
from bgc.record_class import dataclass
from bgc.values.units import shown_of, si_text


@dataclass(frozen=True, slots=True)
class StartAtRest:
    """The start at rest of a scene, with the observations that held values need besides columns."""

    facts: Rest
    observations: tuple[Observation, ...]


def read_start(world: World, scene: Scene, observed: Observed) -> StartAtRest | None:
    """Read `start rest hold .. vary ..`; None if the scene has no such statement.

    A held value is an output of the compiled model: a column of the scene, or an additional one.
    """
    item = next(scene.statements(syntax.Start), None)
    if item is None:
        return None
    added: dict[Node, Observation] = {o.node: o for o in reversed(observed.observations)}
    hold: dict[str, None] = {}
    vary: dict[str, None] = {}
    for path in item.hold:
        with world.report.collecting():
            for held in _held(world, scene, path, observed):
                hold[added.setdefault(held.node, held).name] = None
    for path in item.vary:
        with world.report.collecting():
            for node in world.evaluate(path, scene.env).nodes:
                vary[_parameter(world, path, node)] = None
    hidden = tuple(o for o in added.values() if o not in observed.observations)
    return StartAtRest(Rest(tuple(hold), tuple(vary)), hidden)


def _held(world: World, scene: Scene, path: syntax.Expr, observed: Observed) -> list[Observation]:
    """The components of a value to hold, as observations."""
    value = world.evaluate(path, scene.env)
    symbols = map(world.dag.symbol_of, world.dag.reachable(value.nodes))
    if not any(s is not None and _moves(world, s) for s in symbols):
        raise BgError([scenes.hold_without_state(path.span, path_of(path))])
    labels = component_names(path_of(path), value.shape)
    return [
        Observation(
            f"{label} (held)" if label in observed.columns else label,
            si_text(unit),
            node,
            path.span,
            shown_of(unit),
        )
        for label, unit, node in zip(labels, value.units, value.nodes, strict=True)
    ]


def _moves(world: World, symbol: Symbol) -> bool:
    """Return whether a start at rest can move a symbol: states, and what sampled parts hold."""
    if symbol.kind is Kind.INPUT:
        return symbol.index >= world.quantities.first_held
    return symbol.kind not in (Kind.PARAM, Kind.TIME)


def _parameter(world: World, path: syntax.Expr, node: Node) -> str:
    """The name of the parameter that a node is; BgError for anything else."""
    symbol = world.dag.symbol_of(node)
    if symbol is None or symbol.kind is not Kind.PARAM:
        raise BgError([scenes.vary_without_parameter(path.span, path_of(path))])
    return world.quantities.parameters[symbol.index].name
