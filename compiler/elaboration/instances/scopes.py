"""The names that expressions see, and the paths that lead from them into parts of parts."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import cast

from bgc.diagnostics.catalogue import laws, names
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.protocols import Surroundings
from bgc.elaboration.instances.tree import (
    Element,
    Environment,
    Instance,
    Member,
    PartArray,
    Pending,
    PortEntry,
    Quantity,
)
from bgc.grammar import syntax
from bgc.resolution.modules import Declared, Module
from bgc.values.scope import FunctionUse, Namespace
from bgc.values.value import Value


@dataclass(frozen=True, slots=True)
class Names:
    """The scope of an expression: `extra` names (a law's variables), then its environment."""

    world: Surroundings
    env: Environment
    extra: Mapping[str, Value | Namespace]
    rates: bool

    @property
    def allows_rates(self) -> bool:
        """Whether `der(x)` may stand here."""
        return self.rates

    def lookup(self, name: str, span: Span) -> Value | Namespace | None:
        """What a name stands for: a law's variable, a local, a member, a file's constant."""
        extra = self.extra.get(name)
        if extra is not None:
            if isinstance(find_member(self.env, name), Quantity):
                raise BgError([laws.law_variable_is_a_name(span, name)])
            return extra
        local = self.env.locals.get(name)
        if local is not None:
            return (
                self.world.quantities.value(local, span) if isinstance(local, Quantity) else local
            )
        instance = self.env.instance
        if instance is not None and name in instance.members:
            return member_view(self.world, instance.members[name], span)
        declared = self.env.module.constants.get(name)
        return self.world.quantities.constant(declared, span) if declared else None

    def names(self) -> Collection[str]:
        """All names visible here."""
        members = self.env.instance.members if self.env.instance else {}
        tables = (self.extra, self.env.locals, members, self.env.module.constants)
        return ChainMap(*(cast(dict[str, object], table) for table in tables))

    def is_value(self, name: str) -> bool:
        """Whether a name stands for a law's variable, a local, a quantity or a constant."""
        if name in self.extra or name in self.env.locals:
            return True
        return isinstance(find_member(self.env, name), Quantity | Declared)

    def function(self, name: str) -> FunctionUse | None:
        """A function that the file sees; its body sees the constants of its own file."""
        declared = self.env.module.functions.get(name)
        if declared is None:
            return None
        return FunctionUse(declared.syntax, file_scope(self.world, declared.module))

    def function_names(self) -> Collection[str]:
        """The functions that the file sees."""
        return self.env.module.functions


def file_scope(world: Surroundings, module: Module) -> Names:
    """The scope of what stands outside any model."""
    return Names(world, Environment(None, module, {}), {}, False)


def find_member(env: Environment, name: str) -> object | None:
    """What a plain name stands for in an environment, unevaluated."""
    if name in env.locals:
        return env.locals[name]
    if env.instance is not None and name in env.instance.members:
        return env.instance.members[name]
    return env.module.constants.get(name)


def member_view(world: Surroundings, member: Member, span: Span) -> Value | Namespace:
    """A member as an expression sees it."""
    match member:
        case Quantity():
            return world.quantities.value(member, span)
        case PortEntry():
            return PortView(world, member)
        case PartArray():
            return ArrayView(world, member)
        case Pending():
            return part_view(world, world.builder.build(member))


def part_view(world: Surroundings, part: Instance | Element) -> Namespace:
    """A part as an expression sees it."""
    return InstanceView(world, part) if isinstance(part, Instance) else ElementView(world, part)


@dataclass(frozen=True, slots=True)
class InstanceView:
    """A model's instance: all of its members can be read."""

    world: Surroundings
    instance: Instance

    @property
    def description(self) -> str:
        """For messages."""
        kind = self.instance.declared.syntax.name
        return f"`{self.instance.path}` (a {kind})" if self.instance.path else f"the model {kind}"

    def member(self, name: str, span: Span) -> Value | Namespace:
        """A value, part or port of the model."""
        member = self.instance.members.get(name)
        if member is not None:
            return member_view(self.world, member, span)
        if name in self.instance.formals:
            return self.instance.formals[name]
        raise BgError([names.unknown_member(span, name, self.description, self.instance.members)])

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """A single part has no index."""
        raise BgError([names.no_such_index(span, self.instance.name, indices, "no index")])


@dataclass(frozen=True, slots=True)
class ElementView:
    """A basic element: its efforts, flows, charges and power."""

    world: Surroundings
    element: Element

    @property
    def description(self) -> str:
        """For messages."""
        return f"the {self.element.kind} `{self.element.path}`"

    def member(self, name: str, span: Span) -> Value | Namespace:
        """`e f p q power`, `e1 .. f2`, and of a junction what its domain names."""
        return self.world.bonds.of_element(self.element, name, span)

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """A single part has no index."""
        raise BgError([names.no_such_index(span, self.element.path, indices, "no index")])


@dataclass(frozen=True, slots=True)
class PortView:
    """A port of a model: what passes through it, and the signals of its domain."""

    world: Surroundings
    port: PortEntry

    @property
    def description(self) -> str:
        """For messages."""
        return f"the port `{self.port.path}`"

    def member(self, name: str, span: Span) -> Value | Namespace:
        """`e`, `f`, `power`, or a name of the domain."""
        return self.world.bonds.of_port(self.port, name, span)

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """A port has no index."""
        raise BgError([names.no_such_index(span, self.port.path, indices, "no index")])


@dataclass(frozen=True, slots=True)
class ArrayView:
    """An array of parts: only its elements have members."""

    world: Surroundings
    array: PartArray

    @property
    def description(self) -> str:
        """For messages."""
        return f"`{self.array.path}` ({self.array.description})"

    def member(self, name: str, span: Span) -> Value | Namespace:
        """An array has no members."""
        raise BgError([names.needs_index(span, self.array.path, self.array.description)])

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """One part of the array."""
        return part_view(self.world, self.world.builder.build(part_at(self.array, indices, span)))


def part_at(array: PartArray, indices: tuple[int, ...], span: Span) -> Pending:
    """The part of an array at an index; BgError when there is none."""
    pending = array.parts.get(indices)
    if pending is None:
        raise BgError([names.no_such_index(span, array.path, indices, array.description)])
    return pending


def path_of(expr: syntax.Expr) -> str:
    """A path as the reader wrote it, blanks removed: `crane.boom.mass`."""
    return "".join(expr.span.text.split())
