"""Enter sampled parts: `sample period { .. }`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol

from bgc.diagnostics.catalogue import names, samples
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.fmu_calls import is_fmu_call, read_call
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.tree import Environment, Instance, Quantity, SampledPart
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax

_HELD = {"state", "output", "signal"}
_LOCAL = {"let", "const"}
_NAMES: Mapping[type[syntax.Item], str] = {
    syntax.Part: "a part",
    syntax.Chain: "a bond",
    syntax.Port: "a port",
    syntax.Derivative: "`der(..) = ..;`",
    syntax.When: "`when`",
    syntax.Sample: "another `sample`",
}  # of statements that a `sample` does not hold


class _Builds(Protocol):
    """The methods of the builder that sampled parts need."""

    world: World

    def enter(self, instance: Instance, name: str, member: Quantity, span: Span) -> None:
        """Enter a member of an instance."""

    def turns(self, loop: syntax.For, env: Environment) -> Iterator[Environment]:
        """The environment of each iteration of a loop."""


def enter_sampled(
    builder: _Builds, instance: Instance, item: syntax.Sample, env: Environment
) -> None:
    """Enter the states and outputs of a `sample` into its instance, and keep its statements.

    Within the block the name of an output means its definition, so that outputs may follow from
    each other; the member of the instance is the held value.
    """
    part = SampledPart(item, env)
    instance.sampled.append(part)
    _enter_items(builder, instance, part, item.items, env.nested(), in_loop=False)


def _enter_items(
    builder: _Builds,
    instance: Instance,
    part: SampledPart,
    items: Sequence[syntax.Item],
    env: Environment,
    *,
    in_loop: bool,
) -> None:
    """Enter values first, since statements may come before the declarations that they name."""
    values = [item for item in items if isinstance(item, syntax.Value)]
    for value in values:
        with builder.world.report.collecting(note(env)):
            _enter_value(builder, instance, part, value, env, in_loop)
    for item in items:
        if not isinstance(item, syntax.Value):
            with builder.world.report.collecting(note(env)):
                _enter_statement(builder, instance, part, item, env, in_loop)


def _enter_value(
    builder: _Builds,
    instance: Instance,
    part: SampledPart,
    item: syntax.Value,
    env: Environment,
    in_loop: bool,
) -> None:
    path = instance.within(item.name)
    if item.kind in _LOCAL:
        if item.name in env.locals or item.name in instance.members:
            raise BgError([names.duplicate_name(item.name_span, item.name, None)])
        env.locals[item.name] = Quantity(path, item, env, None)
        return
    if item.kind not in _HELD:
        raise BgError([samples.not_in_sample(item.span, f"`{item.kind}`")])
    if in_loop:
        raise BgError([names.misplaced_in_loop(item.span, item.kind)])
    if item.kind != "state" and is_fmu_call(item):
        call = read_call(builder.world, path, item, env)
        builder.enter(instance, item.name, call.got, item.name_span)
        part.held += (call.got, call.given)
        part.fmus.append(call)
        return
    held = Quantity(path, item, env, None, sampled=True)
    builder.enter(instance, item.name, held, item.name_span)
    part.held.append(held)
    if item.kind != "state":
        definition = Quantity(path, item, env, None)
        env.locals[item.name] = definition
        part.definitions[held] = definition


def _enter_statement(
    builder: _Builds,
    instance: Instance,
    part: SampledPart,
    item: syntax.Item,
    env: Environment,
    in_loop: bool,
) -> None:
    world = builder.world
    match item:
        case syntax.Next():
            part.nexts.append((item, env))
        case syntax.Assign(
            target=syntax.Name(name=name) | syntax.Index(base=syntax.Name(name=name))
        ):
            definition = env.locals.get(name)
            if (
                not isinstance(definition, Quantity)
                or definition not in part.definitions.values()
                or definition.declaration.value is not None
            ):
                raise BgError([samples.not_in_sample(item.span, f"a definition of `{name}`")])
            world.quantities.definitions.setdefault(definition, []).append((item, env))
        case syntax.For():
            for inside in builder.turns(item, env):
                _enter_items(builder, instance, part, item.items, inside, in_loop=True)
        case syntax.If():
            chosen = item.yes if world.holds(item.condition, env) else item.no
            _enter_items(builder, instance, part, chosen, env, in_loop=in_loop)
        case _:
            raise BgError(
                [samples.not_in_sample(item.span, _NAMES.get(type(item), "this statement"))]
            )
