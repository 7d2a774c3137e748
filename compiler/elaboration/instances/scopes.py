"""Name lookup in expressions, and views of parts and ports for paths such as `body.tip.f`."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Collection, Hashable, Iterator, Mapping
from contextlib import contextmanager
from typing import cast

from bgc.diagnostics.catalogue import laws, names, with_article
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.protocols import Services
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
from bgc.language.sampled_port import READ
from bgc.record_class import dataclass
from bgc.resolution.modules import Declared, Module
from bgc.values.scope import ByComponent, FunctionUse, Namespace
from bgc.values.value import Value


@dataclass(frozen=True, slots=True)
class Names:
    """The scope of an expression: `extra` names (the variables of a law), then `env`.

    `rates` permits `der(x)`.
    """

    world: Services
    env: Environment
    extra: Mapping[str, Value | Namespace]
    rates: bool

    @property
    def allows_rates(self) -> bool:
        """Return whether `der(x)` is permitted here."""
        return self.rates

    def lookup(self, name: str, span: Span) -> Value | Namespace | None:
        """Resolve a name: a variable of the law, a local, a member, a constant of the file.

        Returns None for an unknown name.
        """
        extra = self.extra.get(name)
        if extra is not None:
            if isinstance(find_member(self.env, name), Quantity):
                raise BgError([laws.law_variable_is_a_name(span, name)])
            return extra
        local = self.env.locals.get(name)
        if local is not None:
            return (
                self.world.quantities.found(local, span) if isinstance(local, Quantity) else local
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
        """Return whether a name is a variable of the law, a local, a quantity or a constant."""
        if name in self.extra or name in self.env.locals:
            return True
        return isinstance(find_member(self.env, name), Quantity | Declared)

    def component_of(self, name: str) -> ByComponent | None:
        """The components of a value of that name that is assigned by component."""
        if name in self.extra:
            return None
        member = find_member(self.env, name)
        return self.world.quantities.by_component(member) if isinstance(member, Quantity) else None

    def function(self, name: str) -> FunctionUse | None:
        """A function visible in the file, with the scope of the file that declares it."""
        declared = self.env.module.functions.get(name)
        if declared is None:
            return None
        return FunctionUse(declared.syntax, file_scope(self.world, declared.module))

    def data(self, file: str, span: Span) -> Namespace:
        """The contents of a data file."""
        return self.world.data(file, span)

    def function_names(self) -> Collection[str]:
        """The names of the functions visible in the file."""
        return self.env.module.functions

    def variable(self, path: syntax.Expr, owner: Value | Namespace | None) -> Hashable | None:
        """The quantity that a path names, if it is an input, signal, output or let."""
        found: object = None
        match path:
            case syntax.Name(name=name) if name not in self.extra:
                found = find_member(self.env, name)
            case syntax.Member(name=name) if isinstance(owner, InstanceView):
                found = owner.instance.members.get(name)
        return found if isinstance(found, Quantity) and found.kind in _VARIABLES else None

    @contextmanager
    def assuming(self, values: Mapping[Hashable, Value]) -> Iterator[Names]:
        """The names while quantities have other values, and with them all that they define."""
        assumed = {key: value for key, value in values.items() if isinstance(key, Quantity)}
        with self.world.quantities.assuming(assumed):
            yield self


_VARIABLES = frozenset({"input", "let", "output", "signal"})


def file_scope(world: Services, module: Module) -> Names:
    """The scope of a file, outside any model."""
    return Names(world, Environment(None, module, {}), {}, False)


def find_member(env: Environment, name: str) -> object | None:
    """Find the declaration of a plain name in an environment, without evaluating it."""
    if name in env.locals:
        return env.locals[name]
    if env.instance is not None and name in env.instance.members:
        return env.instance.members[name]
    return env.module.constants.get(name)


def member_view(world: Services, member: Member, span: Span) -> Value | Namespace:
    """The value of a member, or a view of a port or part."""
    match member:
        case Quantity():
            return world.quantities.found(member, span)
        case PortEntry():
            return PortView(world, member)
        case PartArray():
            return ArrayView(world, member)
        case Pending():
            return part_view(world, world.builder.build(member))


def part_view(world: Services, part: Instance | Element) -> Namespace:
    """A view of a part for expressions."""
    return InstanceView(world, part) if isinstance(part, Instance) else ElementView(world, part)


@dataclass(frozen=True, slots=True)
class InstanceView:
    """An instance of a model in an expression; all its members can be read."""

    world: Services
    instance: Instance

    @property
    def description(self) -> str:
        """For messages."""
        kind = self.instance.declared.syntax.name
        return (
            f"`{self.instance.path}` ({with_article(kind)})"
            if self.instance.path
            else f"the model {kind}"
        )

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
    """A basic element in an expression: its efforts, flows, stored variables and power."""

    world: Services
    element: Element

    @property
    def description(self) -> str:
        """For messages."""
        return f"the {self.element.kind} `{self.element.path}`"

    def member(self, name: str, span: Span) -> Value | Namespace:
        """One of `e f p q power`, `e1 f1 e2 f2`, or a name of the domain at a junction."""
        return self.world.bonds.of_element(self.element, name, span)

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """A single part has no index."""
        raise BgError([names.no_such_index(span, self.element.path, indices, "no index")])


@dataclass(frozen=True, slots=True)
class PortView:
    """A port in an expression: its effort, flow, power, and the signals of its domain."""

    world: Services
    port: PortEntry

    @property
    def description(self) -> str:
        """For messages."""
        return f"the port `{self.port.path}`"

    def member(self, name: str, span: Span) -> Value | Namespace:
        """One of `e`, `f`, `power`, or a name of the domain; of a sampled port, an energy."""
        if self.port.coupling is not None and name in READ:
            return member_view(self.world, self.port.coupling.members[name], span)
        return self.world.bonds.of_port(self.port, name, span)

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """A port has no index."""
        raise BgError([names.no_such_index(span, self.port.path, indices, "no index")])


@dataclass(frozen=True, slots=True)
class ArrayView:
    """An array of parts in an expression; only its indexed parts have members."""

    world: Services
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
    """The part at an index of an array; BgError if there is none."""
    pending = array.parts.get(indices)
    if pending is None:
        raise BgError([names.no_such_index(span, array.path, indices, array.description)])
    return pending


def path_of(expr: syntax.Expr) -> str:
    """The source text of a path without blanks: `crane.boom.mass`."""
    return "".join(expr.span.text.split())
