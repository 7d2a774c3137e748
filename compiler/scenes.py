"""Scenes: what they change of the model, what drives and observes it, and how it is run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from bgc.dag import Kind
from bgc.evaluate import to_double
from bgc.expressions import evaluate_constant, resolve_path
from bgc.grammar import syntax
from bgc.grammar.catalogue import names, scenes, values
from bgc.grammar.diagnostics import BgError
from bgc.grammar.parse import parse
from bgc.grammar.source import Source, Span
from bgc.graph import DeviceUse, Node, Observation, Plot, Requirement, SceneFacts, SolverChoice
from bgc.instantiate import MAX_WIDTH
from bgc.modules import Declared, Package
from bgc.quantities import component_names
from bgc.scope import Namespace
from bgc.scopes import Names, path_of
from bgc.statements import unit_symbol
from bgc.tree import Environment, Given, Instance, Pending, Quantity
from bgc.units import Dimension, describe_dimension, si_symbol
from bgc.value import Shape, Value, describe_shape
from bgc.world import Edits, World

ACCOUNTS = ("stored", "supplied", "dissipated", "residual")

_SECOND: Dimension = (0, 0, 1, 0, 0, 0, 0)
_METRE: Dimension = (0, 1, 0, 0, 0, 0, 0)
_SPEED: Dimension = (0, 1, -1, 0, 0, 0, 0)
_RATE: Dimension = (0, 0, -1, 0, 0, 0, 0)
_FORCE: Dimension = (1, 1, -2, 0, 0, 0, 0)
_TORQUE: Dimension = (1, 2, -2, 0, 0, 0, 0)

# Channels of a device: what it gives and what it takes.
_INPUTS: dict[str, tuple[Shape, Dimension | None]] = {
    "position": ((3,), _METRE),
    "orientation": ((4,), None),
    "velocity": ((3,), _SPEED),
    "angular_velocity": ((3,), _RATE),
    "gripper": ((), None),
    "buttons": ((8,), None),
}
_COMMANDS: dict[str, tuple[Shape, Dimension | None]] = {
    "force": ((3,), _FORCE),
    "torque": ((3,), _TORQUE),
    "gripper_force": ((), _FORCE),
}

Item = TypeVar("Item", bound=syntax.SceneItem)


@dataclass(slots=True, eq=False)
class Device:
    """A device of the scene: which channels are read, and the commands given to it."""

    item: syntax.Device
    first: int
    inputs: dict[str, int]  # channel -> index of its first INPUT symbol
    commands: dict[tuple[str, int], Node] = field(default_factory=dict)


@dataclass(slots=True, eq=False)
class Scene:
    """The chosen scene: its model, its statements, and the environment they are written in."""

    name: str
    model: Declared[syntax.Model]
    use: syntax.TypeUse
    items: tuple[syntax.SceneItem, ...]
    env: Environment
    implicit: bool
    devices: dict[str, Device] = field(default_factory=dict)

    def every(self, kind: type[Item]) -> Iterator[Item]:
        """The statements of one kind, in order."""
        return (item for item in self.items if isinstance(item, kind))


@dataclass(frozen=True, slots=True)
class DeviceView:
    """A device in an expression: its input channels."""

    world: World
    device: Device

    @property
    def description(self) -> str:
        """For messages."""
        return f"the device `{self.device.item.name}`"

    def member(self, name: str, span: Span) -> Value | Namespace:
        """A channel that the device gives."""
        if name not in self.device.inputs:
            raise BgError([scenes.unknown_channel(span, name, self.device.item.name, _INPUTS)])
        shape, unit = _INPUTS[name]
        first = self.device.inputs[name]
        nodes = (self.world.dag.symbol(Kind.INPUT, first + k) for k in range(_count(shape)))
        return Value.uniform(shape, nodes, unit)

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """A device has no index."""
        name = self.device.item.name
        raise BgError([names.no_such_index(span, name, indices, "no index")])


# --- before the model is built ----------------------------------------------------------


def choose_scene(package: Package, name: str | None) -> Scene:
    """The scene of that name, the file's first, or an implicit one of its last model."""
    module = package.root
    found = module.scenes
    if name is not None:
        chosen = [scene for scene in found if scene.name == name]
        if not chosen:
            raise BgError([scenes.unknown_scene(name, [scene.name for scene in found])])
        found = tuple(chosen)
    env = Environment(None, module, {})
    if found:
        scene = found[0]
        model = module.models[scene.model.name]
        return Scene(scene.name, model, scene.model, scene.items, env, implicit=False)
    models = module.own_models
    if not models:
        raise BgError([scenes.nothing_to_run(module.file.source.name)])
    complete = [m for m in models if all(f.default is not None for f in m.syntax.formals)]
    model = (complete or models)[-1]
    span = model.syntax.name_span
    if not complete:
        raise BgError([scenes.only_dimensioned(span, model.syntax.name)])
    use = syntax.TypeUse(model.syntax.name, (), (), span, span)
    return Scene("", model, use, (), env, implicit=True)


def collect_edits(world: World, scene: Scene, overrides: Sequence[tuple[str, str]]) -> None:
    """Note what the scene and the command line set, use and drive; devices get their symbols."""
    edits = world.edits
    _declare_devices(world, scene)
    for item in scene.items:
        with world.report.collecting():
            match item:
                case syntax.Set():
                    _note_set(world, scene, edits, item.target, item.value, item.span)
                case syntax.Use():
                    path = canonical_path(world, item.slot, scene.env)
                    _note(edits.uses, path, Given(item.type, scene.env, item.span))
                case syntax.Drive() if _device_of(item.target, scene) is None:
                    path = canonical_path(world, item.target, scene.env)
                    _note(edits.drives, path, Given(item.value, scene.env, item.span))
                case _:
                    pass
    for target, value in overrides:
        with world.report.collecting():
            left, right = _parse_override(target), _parse_override(value)
            path = canonical_path(world, left, scene.env)
            edits.sets.pop(path, None)  # the command line has the last word
            _note_set(world, scene, edits, left, right, right.span)


def _note_set(
    world: World,
    scene: Scene,
    edits: Edits,
    target: syntax.Expr,
    value: syntax.Expr,
    span: Span,
) -> None:
    given = Given(value, scene.env, span)
    if isinstance(target, syntax.Index):
        path = canonical_path(world, target.base, scene.env)
        index = tuple(
            world.whole(i, scene.env, "an index", 1, MAX_WIDTH)
            for i in target.indices
            if not isinstance(i, syntax.Range)
        )
        edits.parts.setdefault(path, {})[index] = given
    else:
        _note(edits.sets, canonical_path(world, target, scene.env), given)


def _note(table: dict[str, Given], path: str, given: Given) -> None:
    if table.setdefault(path, given) is not given:
        raise BgError([names.given_twice(given.span, path, table[path].span)])


def _parse_override(text: str) -> syntax.Expr:
    """The expression of one side of `--set name=value`."""
    source = Source("--set", f"const value = {text};")
    file, problems = parse(source)
    if problems:
        raise BgError(problems)
    (declaration,) = file.declarations
    assert isinstance(declaration, syntax.Value)
    assert declaration.value is not None
    return declaration.value


def canonical_path(world: World, expr: syntax.Expr, env: Environment) -> str:
    """A path as instances spell theirs: `body[2].mass`, indices worked out."""
    match expr:
        case syntax.Name():
            return expr.name
        case syntax.Member():
            return f"{canonical_path(world, expr.base, env)}.{expr.name}"
        case syntax.Index():
            index = (
                str(world.whole(i, env, "an index", -MAX_WIDTH, MAX_WIDTH))
                for i in expr.indices
                if not isinstance(i, syntax.Range)
            )
            return f"{canonical_path(world, expr.base, env)}[{','.join(index)}]"
        case _:
            what = "a parameter, slot or input"
            raise BgError([scenes.edit_without_target(expr.span, path_of(expr), what)])


# --- devices ----------------------------------------------------------------------------


def _declare_devices(world: World, scene: Scene) -> None:
    """Number the input channels that the scene reads, device by device."""
    used = [_channels(item) for item in scene.items]
    next_input = 0
    for item in scene.every(syntax.Device):
        if item.name in scene.devices:
            first = scene.devices[item.name].item.span
            world.report.add(scenes.device_name_taken(item.span, item.name, first))
            continue
        read = {channel for pairs in used for name, channel in pairs if name == item.name}
        device = Device(item, next_input, {})
        for channel, (shape, _) in _INPUTS.items():
            if channel in read:
                device.inputs[channel] = next_input
                next_input += _count(shape)
        scene.devices[item.name] = device
        scene.env.locals[item.name] = DeviceView(world, device)


def _channels(item: syntax.SceneItem) -> list[tuple[str, str]]:
    """All `name.member` pairs of a statement."""
    match item:
        case syntax.Drive() | syntax.Observe() | syntax.Require() | syntax.Set():
            return list(_members(item.value))
        case syntax.Use():
            return [p for a in item.type.arguments for p in _members(a.value)]
        case _:
            return []


def _members(expr: syntax.Expr) -> Iterator[tuple[str, str]]:
    match expr:
        case syntax.Member(base=syntax.Name(name=name)):
            yield name, expr.name
        case syntax.Member() | syntax.Index():
            yield from _members(expr.base)
        case syntax.Unary():
            yield from _members(expr.operand)
        case syntax.Binary():
            yield from _members(expr.left)
            yield from _members(expr.right)
        case syntax.Conditional():
            for part in (expr.condition, expr.yes, expr.no):
                yield from _members(part)
        case syntax.Call() | syntax.Vector():
            parts = expr.arguments if isinstance(expr, syntax.Call) else expr.elements
            for part in parts:
                yield from _members(part)
        case syntax.TypeUse():
            for argument in expr.arguments:
                yield from _members(argument.value)
        case _:
            pass


def _device_of(target: syntax.Expr, scene: Scene) -> Device | None:
    """The device whose command a target names, if it does."""
    base = target.base if isinstance(target, syntax.Index) else target
    match base:
        case syntax.Member(base=syntax.Name(name=name)):
            return scene.devices.get(name)
        case _:
            return None


def _read_command(world: World, scene: Scene, item: syntax.Drive, device: Device) -> None:
    target = item.target
    base = target.base if isinstance(target, syntax.Index) else target
    assert isinstance(base, syntax.Member)
    if base.name not in _COMMANDS:
        raise BgError([scenes.unknown_channel(target.span, base.name, device.item.name, _COMMANDS)])
    shape, unit = _COMMANDS[base.name]
    value = world.evaluate(item.value, scene.env)
    what = f"`{path_of(target)}`"
    places = list(range(_count(shape)))
    if isinstance(target, syntax.Index):
        index = world.quantities.component_index(target, scene.env, shape, path_of(base))
        places, shape = [index[0] - 1], ()
    value = world.quantities.shaped(value, shape, item.value.span, what)
    world.quantities.check_units(value, unit, item.value.span, what)
    for place, node in zip(places, value.nodes, strict=True):
        key = (base.name, place + 1)
        if key in device.commands:
            raise BgError([names.given_twice(target.span, path_of(target), item.span)])
        device.commands[key] = node


def read_devices(world: World, scene: Scene) -> tuple[DeviceUse, ...]:
    """The devices with the channels used and the commands given."""
    for item in scene.every(syntax.Drive):
        device = _device_of(item.target, scene)
        if device is not None:
            with world.report.collecting():
                _read_command(world, scene, item, device)
    found = []
    for device in scene.devices.values():
        with world.report.collecting():
            options = tuple(_device_option(world, scene, a, device) for a in device.item.arguments)
            inputs = tuple(
                (channel, k + 1)
                for channel in device.inputs
                for k in range(_count(_INPUTS[channel][0]))
            )
            found.append(
                DeviceUse(
                    device.item.name,
                    device.item.driver,
                    options,
                    device.first,
                    inputs,
                    tuple(device.commands),
                    tuple(device.commands.values()),
                    device.item.span,
                )
            )
    return tuple(found)


def _device_option(
    world: World, scene: Scene, argument: syntax.Argument, device: Device
) -> tuple[str, str]:
    what = f"the driver `{device.item.driver}`"
    if argument.name is None:
        raise BgError([scenes.device_option(argument.span, what)])
    if isinstance(argument.value, syntax.Text):
        return argument.name, argument.value.value
    number = _constant(world, scene, argument.value, f"`{argument.name}`", None)
    return argument.name, repr(number)


# --- after the model is built -----------------------------------------------------------


def check_edits(world: World, scene: Scene) -> None:
    """Report each `set`, `use` and `drive` that changed nothing, since its path fits nothing."""
    edits = world.edits
    tables = {
        "sets": (edits.sets, "a parameter or constant"),
        "uses": (edits.uses, "a slot"),
        "drives": (edits.drives, "an input"),
    }
    unused: list[tuple[syntax.Expr, Span, str, str]] = []
    for item in scene.items:
        with world.report.collecting():
            match item:
                case syntax.Set():
                    indexed = isinstance(item.target, syntax.Index)
                    base = (
                        item.target.base if isinstance(item.target, syntax.Index) else item.target
                    )
                    kind = "parts" if indexed else "sets"
                    path = canonical_path(world, base, scene.env)
                    unused.append((item.target, item.target.span, kind, path))
                case syntax.Use():
                    path = canonical_path(world, item.slot, scene.env)
                    unused.append((item.slot, item.slot.span, "uses", path))
                case syntax.Drive() if _device_of(item.target, scene) is None:
                    path = canonical_path(world, item.target, scene.env)
                    unused.append((item.target, item.target.span, "drives", path))
                case _:
                    pass
    for expr, span, kind, path in unused:
        if (kind, path) not in edits.used:
            with world.report.collecting():
                resolve_path(expr, Names(world, scene.env, {}, False), world.dag)
                what = tables.get(kind, (None, "a parameter or constant"))[1]
                raise BgError([scenes.edit_without_target(span, path, what)])


def check_overrides(world: World, scene: Scene, overrides: Sequence[tuple[str, str]]) -> None:
    """The same for the command line."""
    for target, _ in overrides:
        with world.report.collecting():
            expr = _parse_override(target)
            base = expr.base if isinstance(expr, syntax.Index) else expr
            path = canonical_path(world, base, scene.env)
            kind = "parts" if isinstance(expr, syntax.Index) else "sets"
            if (kind, path) not in world.edits.used:
                resolve_path(expr, Names(world, scene.env, {}, False), world.dag)
                what = "a parameter or constant"
                raise BgError([scenes.edit_without_target(expr.span, path, what)])


@dataclass(frozen=True, slots=True)
class Observed:
    """What the scene observes: columns in order, the accounts among them."""

    observations: tuple[Observation, ...]
    accounts: tuple[str, ...]
    columns: tuple[str, ...]


def read_observed(world: World, scene: Scene, root: Instance) -> Observed:
    """The observed columns; two of one name are an error."""
    observations: list[Observation] = []
    accounts: list[str] = []
    columns: dict[str, Span] = {}
    for item in scene.every(syntax.Observe):
        with world.report.collecting():
            account = _account(item, root)
            if account is not None:
                name = item.alias or f"energy.{account}"
                accounts.append(account)
                added = [name]
                _add_columns(columns, added, item.span)
                continue
            if item.alias is None and not _is_path(item.value):
                raise BgError([scenes.observe_needs_name(item.value.span)])
            value = world.evaluate(item.value, scene.env)
            name = item.alias or path_of(item.value)
            labels = list(component_names(name, value.shape))
            _add_columns(columns, labels, item.span)
            units = _units(world, scene, item.value, value)
            for label, node, unit in zip(labels, value.nodes, units, strict=True):
                observations.append(Observation(label, unit, node, item.span))
    return Observed(tuple(observations), tuple(accounts), tuple(columns))


def _add_columns(columns: dict[str, Span], labels: Sequence[str], span: Span) -> None:
    for label in labels:
        if label in columns:
            raise BgError([scenes.column_twice(span, label, columns[label])])
        columns[label] = span


def _account(item: syntax.Observe, root: Instance) -> str | None:
    """The energy account that is observed, if it is one."""
    match item.value:
        case syntax.Member(base=syntax.Name(name="energy"), name=name):
            if "energy" in root.members:
                return None
            if name not in ACCOUNTS:
                raise BgError([scenes.unknown_account(item.value.span, name, ACCOUNTS)])
            return name
        case _:
            return None


def _is_path(expr: syntax.Expr) -> bool:
    match expr:
        case syntax.Name():
            return True
        case syntax.Member() | syntax.Index():
            return _is_path(expr.base)
        case _:
            return False


def _units(world: World, scene: Scene, expr: syntax.Expr, value: Value) -> list[str]:
    """Units for the header: as declared where a declared value is observed, else SI."""
    quantity = _quantity(world, scene, expr)
    if quantity is not None:
        return [unit_symbol(quantity, unit) for unit in value.units]
    return [si_symbol(unit) if unit is not None else "" for unit in value.units]


def _quantity(world: World, scene: Scene, expr: syntax.Expr) -> Quantity | None:
    """The declared value that a path of plain names leads to, if it does."""
    match expr:
        case syntax.Name() if scene.env.instance is not None:
            member = scene.env.instance.members.get(expr.name)
            return member if isinstance(member, Quantity) else None
        case syntax.Index():
            return _quantity(world, scene, expr.base)
        case syntax.Member(base=base) if _is_path(base):
            part = _part(world, scene, base)
            member = part.members.get(expr.name) if part else None
            if isinstance(member, Quantity):
                return member
            return _quantity(world, scene, base) if expr.name in {"x", "y", "z"} else None
        case _:
            return None


def _part(world: World, scene: Scene, expr: syntax.Expr) -> Instance | None:
    """The instance that a path of plain names leads to."""
    match expr:
        case syntax.Name():
            above = scene.env.instance
        case syntax.Member():
            above = _part(world, scene, expr.base)
        case _:
            return None
    member = above.members.get(expr.name) if above else None
    built = world.builder.build(member) if isinstance(member, Pending) else None
    return built if isinstance(built, Instance) else None


def read_requirements(world: World, scene: Scene) -> tuple[Requirement, ...]:
    """The accuracies asked for, component by component."""
    found: list[Requirement] = []
    for item in scene.every(syntax.Require):
        with world.report.collecting():
            value = world.evaluate(item.value, scene.env)
            tolerance = _constant(world, scene, item.tolerance, "the tolerance", value.unit)
            if not tolerance > 0:
                raise BgError(
                    [scenes.not_positive(item.tolerance.span, "the tolerance", tolerance)]
                )
            labels = component_names(path_of(item.value), value.shape)
            for label, node in zip(labels, value.nodes, strict=True):
                found.append(Requirement(label, node, tolerance, item.span))
    return tuple(found)


def read_kept(world: World, scene: Scene) -> tuple[str, ...]:
    """The paths after `keep`."""
    found = []
    for item in scene.every(syntax.Keep):
        with world.report.collecting():
            resolve_path(item.target, Names(world, scene.env, {}, False), world.dag)
            found.append(canonical_path(world, item.target, scene.env))
    return tuple(found)


def read_facts(world: World, scene: Scene, observed: Observed) -> SceneFacts:
    """How the run is made."""
    run = _only(world, scene, syntax.Run, "run")
    step = _only(world, scene, syntax.Step, "step")
    deadline = _only(world, scene, syntax.Deadline, "deadline")
    solver = _only(world, scene, syntax.Solver, "solver")
    duration = _time(world, scene, run.duration if run else None, "the duration")
    every = _time(world, scene, run.every if run else None, "the interval")
    return SceneFacts(
        scene.name,
        scene.model.syntax.name,
        _solver(world, scene, solver) if solver else None,
        _time(world, scene, step.value if step else None, "the step"),
        duration,
        every,
        _time(world, scene, deadline.value if deadline else None, "the deadline"),
        observed.accounts,
        observed.columns,
        _plots(world, scene, observed.columns),
    )


def _plots(world: World, scene: Scene, columns: Sequence[str]) -> tuple[Plot, ...]:
    """The panels of the scene's plot: columns, or vectors by the name their columns share."""
    vectors = (column.rpartition("[")[0] for column in columns if column.endswith("]"))
    known = dict.fromkeys(("time", *columns, *vectors))
    found = []
    for item in scene.every(syntax.Plot):
        with world.report.collecting():
            paths = (*item.columns, *((item.against,) if item.against else ()))
            for path in paths:
                if path_of(path) not in known:
                    raise BgError([scenes.plot_unobserved(path.span, path_of(path), list(known))])
            drawn = tuple(path_of(path) for path in item.columns)
            found.append(Plot(drawn, path_of(item.against) if item.against else None))
    return tuple(found)


def _only(world: World, scene: Scene, kind: type[Item], what: str) -> Item | None:
    found = list(scene.every(kind))
    if len(found) > 1:
        world.report.add(scenes.said_twice(found[1].span, what, found[0].span))
    return found[0] if found else None


def _time(world: World, scene: Scene, expr: syntax.Expr | None, what: str) -> float | None:
    """A time in seconds; a number without a unit is in seconds."""
    if expr is None:
        return None
    with world.report.collecting():
        number = _constant(world, scene, expr, what, _SECOND)
        if not number > 0:
            raise BgError([scenes.not_positive(expr.span, what, number)])
        return number
    return None


def _constant(
    world: World, scene: Scene, expr: syntax.Expr, what: str, unit: Dimension | None
) -> float:
    """A number known at compile time, in SI units, of the kind asked for."""
    value = world.evaluate(expr, scene.env)
    found = value.unit
    if unit is not None and found is not None and found != unit:
        expected = describe_dimension(unit)
        raise BgError([values.wrong_unit(expr.span, what, expected, describe_dimension(found))])
    if len(value.nodes) != 1:
        raise BgError(
            [values.wrong_shape(expr.span, what, "a scalar", describe_shape(value.shape))]
        )
    exact = evaluate_constant(expr, Names(world, scene.env, {}, False), world.dag, what)
    return to_double(exact)


def _solver(world: World, scene: Scene, solver: syntax.Solver) -> SolverChoice | None:
    options: dict[str, float] = {}
    for argument in solver.arguments:
        with world.report.collecting():
            if argument.name is None or isinstance(argument.value, syntax.Text):
                what = f"solver `{solver.name}`"
                raise BgError([scenes.device_option(argument.span, what)])
            if argument.name in options:
                raise BgError(
                    [names.given_twice(argument.span, argument.name, solver.arguments[0].span)]
                )
            options[argument.name] = _constant(
                world, scene, argument.value, f"`{argument.name}`", None
            )
    return SolverChoice(solver.name, tuple(options.items()), solver.span)


def _count(shape: Shape) -> int:
    count = 1
    for size in shape:
        count *= size
    return count
