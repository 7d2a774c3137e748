"""Build the instance tree: bind arguments, fill slots, expand loops and compile-time `if`.

Parts are built when they are first needed, so declarations may come in any order.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from bgc.diagnostics.catalogue import graph, laws, names, samples, slots
from bgc.diagnostics.catalogue import widths as width_messages
from bgc.diagnostics.collection import already_reported
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.faces import Face
from bgc.elaboration.instances.fills import choose_fill, former_fill, given_arguments, takes
from bgc.elaboration.instances.instance_notes import note, note_of
from bgc.elaboration.instances.limits import MAX_DEPTH, MAX_PARTS, MAX_TURNS, MAX_WIDTH
from bgc.elaboration.instances.sample_blocks import enter_sampled
from bgc.elaboration.instances.sampled_ports import enter_sampled_port
from bgc.elaboration.instances.scopes import path_of
from bgc.elaboration.instances.tree import (
    Element,
    Environment,
    Given,
    Instance,
    PartArray,
    Pending,
    PortEntry,
    Quantity,
    Status,
)
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.ir.graph import Slot
from bgc.language.elements import ELEMENTS, Family
from bgc.resolution.modules import Declared
from bgc.values.value import Value

_LEVELS_SHOWN = 6  # levels of the path that a message shows for endlessly nested models

_LOCAL_KINDS = {"const", "let", "signal"}


class Builder:
    """Builds instances and elements of one elaboration."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.slots: list[Slot] = []
        self._parts = 0
        self._turns = 0
        self._is_too_large = False
        self._endless: set[int] = set()  # models that are reported as too deep

    # --- models ---------------------------------------------------------------------

    def instantiate(
        self,
        declared: Declared[syntax.Model],
        dims: tuple[int, ...],
        arguments: Mapping[str, Given],
        path: str,
        parent: Instance | None,
        span: Span,
        home: Environment | None = None,
    ) -> Instance:
        """Create an instance of a model; its parts remain pending.

        `home` is the environment of a scene, in which the names of the new instance become visible
        before its items are entered.
        """
        depth = parent.depth + 1 if parent else 0
        if id(declared.syntax) in self._endless:
            raise already_reported()
        if depth > MAX_DEPTH:
            self._endless.add(id(declared.syntax))
            shown = ".".join(path.split(".")[:_LEVELS_SHOWN])
            outer = parent
            while outer is not None and outer.declared.syntax is not declared.syntax:
                outer = outer.parent
            if outer is None:
                raise BgError([names.nested_too_deeply(span, MAX_DEPTH, shown)])
            raise BgError([names.contains_itself(span, declared.syntax.name, shown, depth)])
        instance = Instance(path, declared, parent, depth, span)
        if home is not None:
            home.instance = instance
        dims = self._with_set(instance, declared.syntax, dims)
        self._enter_model(instance, declared, dims, arguments)
        self._check_arguments(instance, arguments)
        return instance

    def _with_set(
        self, instance: Instance, model: syntax.Model, dims: tuple[int, ...]
    ) -> tuple[int, ...]:
        """Replace the dimensions that a scene sets: `set boom.n = 4;`."""
        found = []
        for formal, size in zip(model.formals, dims, strict=True):
            given = self.world.edits.take("sets", instance.within(formal.name))
            if given is not None:
                size = self.world.whole(given.value, given.env, "a dimension", 0, MAX_WIDTH)
            found.append(size)
        return tuple(found)

    def _enter_model(
        self,
        instance: Instance,
        declared: Declared[syntax.Model],
        dims: tuple[int, ...],
        arguments: Mapping[str, Given],
    ) -> None:
        """Enter the items of a model into an instance, those of its base model first."""
        model = declared.syntax
        instance.kinds.append((declared, dims))
        formals = {
            formal.name: Value.scalar(self.world.dag.const(size))
            for formal, size in zip(model.formals, dims, strict=True)
        }
        instance.formals.update(formals)
        env = Environment(instance, declared.module, dict(formals))
        if model.base is not None:
            base = declared.module.models[model.base.name]
            base_dims = self.dimensions(base.syntax, model.base, env)
            if base.syntax.interface:
                self._note_interface(instance, base, base_dims)
            else:
                preset = self.arguments_by_name(model.base, env, base.syntax.name)
                self._enter_model(instance, base, base_dims, {**preset, **arguments})
        self._register(model.items, env, arguments, in_loop=False)

    def _note_interface(
        self, instance: Instance, declared: Declared[syntax.Model], dims: tuple[int, ...]
    ) -> None:
        """Record an interface of the instance and the interfaces that this one extends."""
        instance.kinds.append((declared, dims))
        base = declared.syntax.base
        if base is not None:
            formals = zip(declared.syntax.formals, dims, strict=True)
            values = {f.name: Value.scalar(self.world.dag.const(n)) for f, n in formals}
            env = Environment(None, declared.module, dict(values))
            parent = declared.module.models[base.name]
            self._note_interface(instance, parent, self.dimensions(parent.syntax, base, env))

    def dimensions(
        self, model: syntax.Model, use: syntax.TypeUse, env: Environment
    ) -> tuple[int, ...]:
        """Evaluate the dimensions in a use of a model, with defaults for omitted ones."""
        formals = model.formals
        needed = sum(formal.default is None for formal in formals)
        if not needed <= len(use.dims) <= len(formals):
            count = f"{needed} to {len(formals)}" if needed != len(formals) else f"{needed}"
            noun = "dimension" if len(formals) == 1 else "dimensions"
            expected = f"{count} {noun}" if formals else "no dimensions"
            raise BgError(
                [names.wrong_dimensions(use.name_span, model.name, expected, len(use.dims))]
            )
        given = [self.world.whole(d, env, "a dimension", 0, MAX_WIDTH) for d in use.dims]
        home = env.module.models.get(model.name)
        module = home.module if home else env.module
        for formal in formals[len(given) :]:
            assert formal.default is not None
            before = zip(formals, given, strict=False)
            values = {f.name: Value.scalar(self.world.dag.const(n)) for f, n in before}
            at_file = Environment(None, module, dict(values))
            given.append(self.world.whole(formal.default, at_file, "a dimension", 0, MAX_WIDTH))
        return tuple(given)

    def arguments_by_name(
        self, use: syntax.TypeUse, env: Environment, owner: str
    ) -> dict[str, Given]:
        """The arguments of a model by name; BgError for a positional argument."""
        found: dict[str, Given] = {}
        for argument in use.arguments:
            if argument.name is None:
                declared = env.module.models[use.name].syntax
                expected = [
                    i.name
                    for i in declared.items
                    if isinstance(i, syntax.Value) and i.kind in {"param", "input"}
                ]
                raise BgError([names.positional_argument(argument.span, f"`{owner}`", expected)])
            given = Given(argument.value, env, argument.span)
            if found.setdefault(argument.name, given) is not given:
                first = found[argument.name].span
                self._report(names.given_twice(argument.span, argument.name, first), env)
        return found

    def _check_arguments(self, instance: Instance, arguments: Mapping[str, Given]) -> None:
        takes = [n for n, m in instance.members.items() if self._can_be_given(m)]
        for name, given in arguments.items():
            member = instance.members.get(name)
            match member:
                case Quantity() if member.kind in {"param", "const", "input"}:
                    continue
                case Pending() if self.is_slot(member):
                    continue
                case None:
                    owner = f"`{instance.declared.syntax.name}`"
                    problem = names.unknown_argument(given.span, name, owner, takes)
                case Quantity():
                    problem = names.cannot_be_given(given.span, name, member.kind, takes)
                case PortEntry():
                    problem = names.cannot_be_given(given.span, name, "port", takes)
                case _:
                    problem = names.cannot_be_given(given.span, name, "part", takes)
            self._report(problem, given.env)

    def _can_be_given(self, member: object) -> bool:
        if isinstance(member, Quantity):
            return member.kind in {"param", "const", "input"}
        return isinstance(member, Pending) and self.is_slot(member)

    def is_slot(self, pending: Pending) -> bool:
        """Return whether a part is replaceable: its type is an interface, or it has a default."""
        declared = pending.env.module.models.get(pending.part.type.name)
        return pending.part.default is not None or (
            declared is not None and declared.syntax.interface
        )

    # --- items ----------------------------------------------------------------------

    def _register(
        self,
        items: Sequence[syntax.Item],
        env: Environment,
        arguments: Mapping[str, Given],
        in_loop: bool,
    ) -> None:
        """Enter items: values, ports and single parts first, which loop bounds may refer to."""
        later: list[syntax.Item] = []
        for item in items:
            match item:
                case syntax.Value():
                    self._register_value(item, env, arguments, in_loop)
                case syntax.Port() if in_loop:
                    self._report(names.misplaced_in_loop(item.span, "port"), env)
                case syntax.Port():
                    self._register_port(item, env)
                    if item.period is not None:
                        later.append(item)
                case syntax.Part() if not item.index:
                    self._register_part(item, env, arguments)
                case _:
                    later.append(item)
        for item in later:
            with self.world.report.collecting(note(env)):
                self._register_deferred(item, env, arguments, in_loop)

    def _register_deferred(
        self,
        item: syntax.Item,
        env: Environment,
        arguments: Mapping[str, Given],
        in_loop: bool,
    ) -> None:
        instance = env.instance
        assert instance is not None
        match item:
            case syntax.Part():
                self._register_indexed(item, env)
            case syntax.For():
                for inside in self.turns(item, env):
                    self._register(item.items, inside, arguments, in_loop=True)
            case syntax.If():
                chosen = item.yes if self.world.holds(item.condition, env) else item.no
                self._register(chosen, env, arguments, in_loop)
            case syntax.Sample():
                enter_sampled(self, instance, item, env)
            case syntax.Next():
                raise BgError([samples.next_of_what(item.target.span, path_of(item.target))])
            case syntax.Port():
                port = instance.members[item.name]
                if isinstance(port, PortEntry) and port.declaration is item:
                    enter_sampled_port(self, instance, port)
            case syntax.Value():
                raise AssertionError("values are entered first")
            case _:
                instance.statements.append((item, env))

    def turns(self, loop: syntax.For, env: Environment) -> Iterator[Environment]:
        """The environment of each iteration of a loop; BgError where there are too many."""
        first = self.world.whole(loop.first, env, "the start", -MAX_TURNS, MAX_TURNS)
        last = self.world.whole(loop.last, env, "the end", -MAX_TURNS, MAX_TURNS)
        for turn in range(first, last + 1):
            self._turns += 1
            if self._turns > MAX_PARTS:
                raise self._too_many(loop.span)
            inside = env.nested()
            inside.locals[loop.variable] = Value.scalar(self.world.dag.const(turn))
            yield inside

    def _too_many(self, span: Span) -> BgError:
        """The error for too many parts or loop iterations, reported once."""
        if self._is_too_large:
            return already_reported()
        self._is_too_large = True
        return BgError([graph.too_many_parts(span, MAX_PARTS)])

    def _register_value(
        self,
        item: syntax.Value,
        env: Environment,
        arguments: Mapping[str, Given],
        in_loop: bool,
    ) -> None:
        instance = env.instance
        assert instance is not None
        if in_loop:
            if item.kind not in _LOCAL_KINDS:
                self._report(names.misplaced_in_loop(item.span, item.kind), env)
            elif item.name in env.locals or item.name in instance.members:
                self._report(names.duplicate_name(item.name_span, item.name, None), env)
            else:
                path = instance.within(item.name)
                env.locals[item.name] = Quantity(path, item, env, None)
            return
        path = instance.within(item.name)
        edits = self.world.edits
        given = arguments.get(item.name) if item.kind in {"param", "const", "input"} else None
        parts: Mapping[tuple[int, ...], Given] = {}
        if item.kind in {"param", "const"}:
            given = edits.take("sets", path) or given
            parts = edits.take_parts(path)
        elif item.kind == "input":
            driven = edits.take("drives", path)
            if driven is not None and given is not None:
                self._report(names.given_twice(driven.span, path, given.span), env)
            given = driven or given
        self.enter(instance, item.name, Quantity(path, item, env, given, parts), item.name_span)

    def _register_port(self, item: syntax.Port, env: Environment) -> None:
        instance = env.instance
        assert instance is not None
        path = instance.within(item.name)
        outer = Face(path, item.name_span, junction=False)
        inner = Face(path, item.name_span, junction=False)
        port = PortEntry(path, item, env, instance, outer, inner)
        self.enter(instance, item.name, port, item.name_span)

    def _register_part(
        self, item: syntax.Part, env: Environment, arguments: Mapping[str, Given]
    ) -> None:
        instance = env.instance
        assert instance is not None
        pending = Pending(instance.within(item.name), item, env, arguments.get(item.name))
        self.enter(instance, item.name, pending, item.name_span)

    def _register_indexed(self, item: syntax.Part, env: Environment) -> None:
        instance = env.instance
        assert instance is not None
        index = tuple(
            self.world.whole(i, env, "an index", -MAX_TURNS, MAX_TURNS) for i in item.index
        )
        array = instance.members.get(item.name)
        if array is None:
            array = PartArray(instance.within(item.name), item.name_span)
            instance.members[item.name] = array
        if not isinstance(array, PartArray) or index in array.parts:
            first = array.span if isinstance(array, PartArray) else _span(array)
            raise BgError([names.duplicate_name(item.name_span, item.name, first)])
        path = f"{array.path}[{','.join(map(str, index))}]"
        array.parts[index] = Pending(path, item, env, None)

    def enter(
        self, instance: Instance, name: str, member: Quantity | PortEntry | Pending, span: Span
    ) -> None:
        """Enter a member into an instance; report a name that is taken."""
        present = instance.members.get(name)
        if present is not None:
            self.world.report.add(
                names.duplicate_name(span, name, _span(present)), note=note_of(instance)
            )
        elif name in member.env.locals:
            self.world.report.add(names.duplicate_name(span, name, None), note=note_of(instance))
        else:
            instance.members[name] = member

    # --- parts ----------------------------------------------------------------------

    def build(self, pending: Pending) -> Instance | Element:
        """Return a part, which is built at the first call."""
        if pending.built is not None:
            return pending.built
        if pending.status is Status.FAILED:
            raise already_reported()
        if pending.status is Status.OPEN:
            cycle = [pending.path, pending.path]
            raise BgError([names.defined_by_itself(pending.part.name_span, cycle)])
        return self.world.demands.meet(pending, partial(self._build, pending))

    def _build(self, pending: Pending) -> Instance | Element:
        turns = self._turns
        try:
            if self._parts >= MAX_PARTS:
                raise self._too_many(pending.part.span)
            built = self._construct(pending)
        except BgError as err:
            self.world.report.add(*err.diagnostics, note=note(pending.env))
            raise already_reported() from err
        except BaseException:  # suspended: its loops will be counted again
            self._turns = turns
            raise
        self._parts += 1
        pending.built = built
        pending.status = Status.DONE
        return built

    def _construct(self, pending: Pending) -> Instance | Element:
        part, env = pending.part, pending.env
        declared = env.module.models.get(part.type.name)
        if declared is not None:
            if self.is_slot(pending):
                return self._build_slot(pending, declared)
            dims = self.dimensions(declared.syntax, part.type, env)
            arguments = self.arguments_by_name(part.type, env, part.type.name)
            self._check_law(part)
            return self.instantiate(
                declared, dims, arguments, pending.path, env.instance, part.name_span
            )
        if part.type.name not in ELEMENTS:
            raise already_reported()
        return self._build_element(pending)

    def _check_law(self, part: syntax.Part) -> None:
        if part.law is not None:
            raise BgError([laws.law_of_model(part.name_span, part.type.name)])

    def _build_slot(self, pending: Pending, interface: Declared[syntax.Model]) -> Instance:
        """Instantiate the model that fills a slot, and check its dimensions."""
        part, env = pending.part, pending.env
        self._check_law(part)
        used = self.world.edits.take("uses", pending.path)
        fill, fill_env, model = choose_fill(pending, interface, used)
        arguments = self.arguments_by_name(fill, fill_env, fill.name)
        for name, given in given_arguments(fill, fill_env, pending):
            if takes(model, name):
                arguments.setdefault(name, given)
        for name, given in self.arguments_by_name(part.type, env, part.type.name).items():
            if name in arguments:
                first = arguments[name].span
                raise BgError([names.given_twice(given.span, name, first)])
            arguments[name] = given
        dims = tuple(self._sizes(fill, fill_env, pending).values())
        built = self.instantiate(model, dims, arguments, pending.path, env.instance, part.name_span)
        required = self.dimensions(interface.syntax, part.type, env)
        have = next(d for k, d in built.kinds if k.syntax is interface.syntax)
        if have != required:
            raise BgError(
                [
                    width_messages.slot_width(
                        fill.span, fill.name, part.type.name, required, have, part.span
                    )
                ]
            )
        names_given = tuple(name for name, _ in given_arguments(fill, fill_env, pending))
        self.slots.append(Slot(pending.path, part.type.name, required, fill.name, names_given))
        return built

    def _sizes(self, fill: syntax.TypeUse, env: Environment, pending: Pending) -> dict[str, int]:
        """The dimensions of a type that fills a slot: its own, or all those of the one before."""
        declared = env.module.models.get(fill.name)
        if declared is None:
            return {}
        model = declared.syntax
        names = [formal.name for formal in model.formals]
        former = former_fill(fill, env, pending) if fill.keeps and not fill.dims else None
        kept = {} if former is None else self._sizes(*former, pending)
        if kept.keys() >= set(names):
            return {name: kept[name] for name in names}
        return dict(zip(names, self.dimensions(model, fill, env), strict=True))

    def _build_element(self, pending: Pending) -> Element:
        part, env = pending.part, pending.env
        kind = part.type.name
        if part.default is not None:
            raise BgError([slots.not_a_slot(part.name_span, part.name, f"an element `{kind}`")])
        dims = tuple(self.world.whole(d, env, "a width", 1, MAX_WIDTH) for d in part.type.dims)
        row = ELEMENTS[kind]
        most = row.widths or MAX_WIDTH
        if len(dims) > most:
            expected = f"at most {most} width" + "s" * (most > 1)
            raise BgError([names.wrong_dimensions(part.type.name_span, kind, expected, len(dims))])
        faces = {
            side: Face(pending.path, part.name_span, junction=row.family is Family.JUNCTION)
            for side in row.sides
        }
        return Element(pending.path, kind, part.type, part.law, env, dims, part.name_span, faces)

    def _report(self, diagnostic: Diagnostic, env: Environment) -> None:
        self.world.report.add(diagnostic, note=note(env))


def _span(member: Quantity | PortEntry | Pending | PartArray) -> Span:
    match member:
        case Quantity() | PortEntry():
            return member.declaration.name_span
        case Pending():
            return member.part.name_span
        case PartArray():
            return member.span
