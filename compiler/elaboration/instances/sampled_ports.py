"""Enter sampled ports: `port hand[3] out sampled 1 ms { position = x; stiffness = k; .. }`.

The coupling of such a port is an instance of a model of its own (`language/sampled_port.py`), whose
arguments are the law. It has the path of the port and is bonded to the port's inner side, so that
all that follows treats it as any other part.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from fractions import Fraction
from functools import cache
from typing import Any, Protocol

from bgc.diagnostics.catalogue import names, ports
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source, Span
from bgc.elaboration.instances.limits import MAX_WIDTH
from bgc.elaboration.instances.tree import (
    Environment,
    Given,
    Instance,
    Pending,
    PortEntry,
    Status,
)
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.grammar.parse import parse
from bgc.language.sampled_port import GIVEN, MODEL, NEEDED, port_model
from bgc.resolution.modules import Declared, Module

_MOST_COMPONENTS = 6  # components: translations and rotations of a device


class _Builds(Protocol):
    """The methods of the builder that sampled ports need."""

    world: World

    def instantiate(
        self,
        declared: Declared[syntax.Model],
        dims: tuple[int, ...],
        arguments: dict[str, Given],
        path: str,
        parent: Instance | None,
        span: Span,
    ) -> Instance:
        """Create an instance of a model."""


def enter_sampled_port(builder: _Builds, instance: Instance, port: PortEntry) -> None:
    """Create the coupling of a sampled port, and bond it to the port.

    Raises
    ------
    BgError
        BG470: the law, the width or the domain of the port is at fault.
    """
    item, env = port.declaration, port.env
    arguments = _arguments(item, env)
    if len(item.dims) != 1:
        raise BgError([ports.incomplete(item.name_span, item.name, "its width")])
    width = builder.world.whole(item.dims[0], env, "a width", 1, min(_MOST_COMPONENTS, MAX_WIDTH))
    wall = arguments.pop("one_sided", None)
    is_wall = wall is not None and builder.world.whole(wall.value, wall.env, "one_sided", 0, 1) == 1
    declared = _declared(
        port_model(width, is_wall, "age" in arguments, *_units(item, env)), item.name_span
    )
    sense = -1 if item.direction is syntax.Direction.IN else 1
    arguments["sense"] = Given(_number(sense, item.name_span), env, item.name_span)
    assert item.period is not None
    arguments["period"] = Given(item.period, env, item.period.span)
    coupling = builder.instantiate(
        declared, (width,), arguments, port.path, instance, item.name_span
    )
    port.coupling = coupling

    # The bond between both, and the coupling as a part: its name is none of the language.
    key = f"{item.name} coupling"
    use = syntax.TypeUse(MODEL, (), (), item.name_span, item.name_span)
    part = syntax.Part(key, (), use, None, None, item.doc, item.span, item.name_span)
    instance.members[key] = Pending(port.path, part, env, None, coupling, Status.DONE)
    outer, inner = syntax.Name(item.name, item.name_span), syntax.Name(key, item.name_span)
    stops = ((outer,), (inner,)) if sense < 0 else ((inner,), (outer,))
    instance.statements.append((syntax.Chain(stops, item.name_span), env))


def _arguments(item: syntax.Port, env: Environment) -> dict[str, Given]:
    """The law of a port by the names of its quantities."""
    found: dict[str, Given] = {}
    for law in item.law or ():
        target = law.left
        if not isinstance(target, syntax.Name) or target.name not in GIVEN:
            raise BgError([ports.unknown_quantity(target.span, target.span.text, tuple(GIVEN))])
        if target.name in found:
            raise BgError([names.given_twice(law.span, target.name, found[target.name].span)])
        found[target.name] = Given(law.right, env, law.span)
    missing = [name for name in NEEDED if name not in found]
    if missing:
        raise BgError([ports.incomplete(item.name_span, item.name, f"`{missing[0]} = ..`")])
    return found


def _units(item: syntax.Port, env: Environment) -> tuple[str, str]:
    """The units of effort and flow of all components: N and m/s without a domain."""
    if item.domain is None:
        return "N", "m/s"
    domain = env.module.domains[item.domain].syntax
    units = {
        kind: {v.unit for v in domain.variables if v.kind == kind} for kind in ("effort", "flow")
    }
    if domain.pseudo or any(len(found) != 1 or None in found for found in units.values()):
        what = "a domain with one unit of effort and one of flow"
        raise BgError([ports.incomplete(item.name_span, item.name, what)])
    (effort,), (flow,) = units["effort"], units["flow"]
    return str(effort), str(flow)


def _number(value: int, span: Span) -> syntax.Expr:
    return syntax.Number(Fraction(value), None, span)


def _declared(text: str, span: Span) -> Declared[syntax.Model]:
    """The model of the coupling, with all its places at the port."""
    file = _parsed(text)
    model = _placed(next(d for d in file.declarations if isinstance(d, syntax.Model)), span)
    assert isinstance(model, syntax.Model)
    module = Module(file)
    module.models[MODEL] = Declared(model, module)
    return module.models[MODEL]


@cache
def _parsed(text: str) -> syntax.File:
    file, diagnostics = parse(Source("<sampled port>", text))
    assert not diagnostics
    return file


def _placed(tree: Any, span: Span) -> Any:
    """A syntax tree in which everything stands at one place, that of the user's text."""
    if isinstance(tree, Span):
        return span
    if isinstance(tree, tuple):
        return tuple(_placed(item, span) for item in tree)
    if is_dataclass(tree) and not isinstance(tree, type):
        parts = {f.name: _placed(getattr(tree, f.name), span) for f in fields(tree)}
        return replace(tree, **parts)
    return tree
