"""Read the observations of a scene: the columns of its result, with their units."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from bgc.algebra.dag import Kind
from bgc.diagnostics.catalogue import scenes
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.components import component_names
from bgc.elaboration.instances.quantities import dimension_of
from bgc.elaboration.instances.scopes import path_of
from bgc.elaboration.instances.tree import Instance, Pending, Quantity
from bgc.elaboration.instances.world import World
from bgc.elaboration.scenes.scene_choice import Scene
from bgc.grammar import syntax
from bgc.ir.graph import FlatGraph, Observation, SampledPort
from bgc.language.column_names import AccountColumn, column_in
from bgc.language.scene_tables import ACCOUNTS, CREATED
from bgc.record_class import dataclass, replace
from bgc.values.units import Dimension, describe_dimension, parse_unit, shown_of, si_text
from bgc.values.value import Value

_JOULE: Dimension = (1, 2, -2, 0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class Observed:
    """The observations and energy accounts of a scene, and the columns of both in order.

    `refused` are the names of those observations that are in error.
    """

    observations: tuple[Observation, ...]
    accounts: tuple[AccountColumn, ...]
    columns: tuple[str, ...]
    refused: tuple[str, ...] = ()


def read_observed(
    world: World, scene: Scene, root: Instance, ports: Sequence[SampledPort] = ()
) -> Observed:
    """Read the observed columns; two of the same name are reported."""
    observations: list[Observation] = []
    accounts: list[AccountColumn] = []
    columns: dict[str, Span] = {}
    refused: dict[str, None] = {}
    for item in scene.statements(syntax.Observe):
        named = item.alias or (path_of(item.value) if is_path(item.value) else "")
        refused[named] = None
        with world.report.collecting():
            account = _account(item, root)
            if item.alias is None and not is_path(item.value):
                raise BgError([scenes.observe_needs_name(item.value.span)])
            name = item.alias or path_of(item.value)
            if account == CREATED:
                symbols = (
                    world.dag.symbol(Kind.INPUT, port.coupling_energies[2]) for port in ports
                )
                value = Value.scalar(world.dag.sum(symbols), _JOULE)
            elif account is not None:
                value = Value.scalar(world.dag.zero, _JOULE)  # the runtime integrates it
            else:
                value = world.evaluate(item.value, scene.env)
            factor = Fraction(1)
            if item.unit is not None:
                factor = _factor(item.unit, item.unit_span, value)
            labels = [column_in(label, item.unit) for label in component_names(name, value.shape)]
            _add_columns(columns, labels, item.span)
            del refused[named]
            if account is not None and account != CREATED:
                written = item.unit or "J"
                accounts.append(AccountColumn(account, labels[0], written, float(factor)))
                continue
            for label, node, unit in zip(labels, value.nodes, value.units, strict=True):
                if item.unit is None:
                    found = Observation(label, si_text(unit), node, item.span, shown_of(unit))
                else:
                    inside = world.dag.div(node, world.dag.const(factor))
                    found = Observation(label, item.unit, inside, item.span)
                observations.append(found)
    return Observed(tuple(observations), tuple(accounts), tuple(columns), tuple(refused))


def _factor(text: str, span: Span, value: Value) -> Fraction:
    """The factor of the unit in which a value is observed; BgError if it does not fit."""
    dimension = dimension_of(text, span)
    for found in value.units:
        if found is not None and found != dimension:
            raise BgError([scenes.unit_of_column(span, text, describe_dimension(found))])
    unit = parse_unit(text)
    assert unit is not None
    return unit.factor


def with_accounts(graph: FlatGraph) -> FlatGraph:
    """The graph with all energy accounts observed, in place of those of the scene."""
    columns = dict.fromkeys(c for c in graph.scene.columns if c not in _account_columns(graph))
    # A blank keeps these names distinct from all names of the language.
    own = tuple(AccountColumn(account, f"account {account}") for account in ACCOUNTS)
    names = (found.column for found in own)
    return replace(graph, scene=replace(graph.scene, accounts=own, columns=(*columns, *names)))


def _account_columns(graph: FlatGraph) -> set[str]:
    """The columns of the accounts that the scene observes: those that are not observations."""
    return {found.column for found in graph.scene.accounts}


def _add_columns(columns: dict[str, Span], labels: Sequence[str], span: Span) -> None:
    for label in labels:
        if label in columns:
            raise BgError([scenes.column_twice(span, label, columns[label])])
        columns[label] = span


def _account(item: syntax.Observe, root: Instance) -> str | None:
    """The energy account that a statement observes; None for any other expression."""
    match item.value:
        case syntax.Member(base=syntax.Name(name="energy"), name=name):
            if "energy" in root.members:
                return None
            if name == CREATED:
                return name
            if name not in ACCOUNTS:
                raise BgError([scenes.unknown_account(item.value.span, name, tuple(ACCOUNTS))])
            return name
        case _:
            return None


def is_path(expr: syntax.Expr) -> bool:
    """Return whether an expression is a path, which can serve as the name of its column."""
    match expr:
        case syntax.Name():
            return True
        case syntax.Member() | syntax.Index():
            return is_path(expr.base)
        case _:
            return False


def declared_value(world: World, scene: Scene, expr: syntax.Expr) -> Quantity | None:
    """The declared value at a path of plain names; None for any other expression.

    An index, or a component `.x`, `.y` or `.z`, belongs to the value before it.
    """
    match expr:
        case syntax.Name() if scene.env.instance is not None:
            member = scene.env.instance.members.get(expr.name)
            return member if isinstance(member, Quantity) else None
        case syntax.Index():
            return declared_value(world, scene, expr.base)
        case syntax.Member(base=base) if is_path(base):
            part = _instance_at(world, scene, base)
            member = part.members.get(expr.name) if part else None
            if isinstance(member, Quantity):
                return member
            return declared_value(world, scene, base) if expr.name in {"x", "y", "z"} else None
        case _:
            return None


def _instance_at(world: World, scene: Scene, expr: syntax.Expr) -> Instance | None:
    """The instance at a path of plain names; None for any other expression."""
    match expr:
        case syntax.Name():
            above = scene.env.instance
        case syntax.Member():
            above = _instance_at(world, scene, expr.base)
        case _:
            return None
    member = above.members.get(expr.name) if above else None
    built = world.builder.build(member) if isinstance(member, Pending) else None
    return built if isinstance(built, Instance) else None
