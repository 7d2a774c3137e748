"""Read the devices of a scene: the input channels in use and the commands."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from bgc.algebra.dag import Kind
from bgc.diagnostics.catalogue import names, scenes
from bgc.diagnostics.catalogue.devices import no_driver_path
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.checks import check_units, fit_shape
from bgc.elaboration.instances.scopes import path_of
from bgc.elaboration.instances.world import World
from bgc.elaboration.scenes.scene_choice import Device, Scene, constant_of
from bgc.grammar import syntax
from bgc.grammar.scene_statements import expressions_in
from bgc.ir.scene_nodes import DeviceUse
from bgc.language.scene_tables import (
    DEVICE_COMMANDS,
    DEVICE_INPUTS,
    DRIVER_BY_PATH,
    DRIVER_OPTIONS,
)
from bgc.record_class import dataclass
from bgc.resolution.modules import Package
from bgc.values.scope import Namespace
from bgc.values.units import si_symbol
from bgc.values.value import Shape, Value


def channel_unit(channel: str) -> str:
    """The SI unit of an input channel; empty if it has none."""
    unit = DEVICE_INPUTS[channel].dimension
    return si_symbol(unit) if unit is not None else ""


def command_unit(channel: str) -> str:
    """The SI unit of a channel that is written; empty if it has none."""
    unit = DEVICE_COMMANDS[channel].dimension
    return si_symbol(unit) if unit is not None else ""


@dataclass(frozen=True, slots=True)
class DeviceView:
    """A device in an expression; its members are the input channels."""

    world: World
    device: Device

    @property
    def description(self) -> str:
        """For messages."""
        return f"the device `{self.device.item.name}`"

    def member(self, name: str, span: Span) -> Value | Namespace:
        """The value of an input channel."""
        if name not in self.device.inputs:
            raise BgError(
                [scenes.unknown_channel(span, name, self.device.item.name, DEVICE_INPUTS)]
            )
        channel = DEVICE_INPUTS[name]
        first = self.device.inputs[name]
        nodes = (self.world.dag.symbol(Kind.INPUT, first + k) for k in range(_count(channel.shape)))
        return Value.uniform(channel.shape, nodes, channel.dimension)

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """A device has no index."""
        name = self.device.item.name
        raise BgError([names.no_such_index(span, name, indices, "no index")])


def declare_devices(world: World, scene: Scene) -> None:
    """Number the input channels read by the scene, device by device."""
    used = [pair for item in scene.items for e in expressions_in(item) for pair in _members(e)]
    next_input = 0
    for item in scene.statements(syntax.Device):
        if item.name in scene.devices:
            first = scene.devices[item.name].item.span
            world.report.add(scenes.device_name_taken(item.span, item.name, first))
            continue
        read = {channel for name, channel in used if name == item.name}
        device = Device(item, next_input, {})
        for channel, facts in DEVICE_INPUTS.items():
            if channel in read:
                device.inputs[channel] = next_input
                next_input += _count(facts.shape)
        scene.devices[item.name] = device
        scene.env.locals[item.name] = DeviceView(world, device)
    world.quantities.first_held = next_input


def _members(expr: syntax.Expr) -> Iterator[tuple[str, str]]:
    match expr:
        case syntax.Member(base=syntax.Name(name=name)):
            yield name, expr.name
        case syntax.Member() | syntax.Index():
            yield from _members(expr.base)
        case syntax.Unary():
            yield from _members(expr.operand)
        case syntax.Binary():
            for operand in expr.operands():
                yield from _members(operand)
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


def device_of(target: syntax.Expr, scene: Scene) -> Device | None:
    """The device whose command a target names; None for any other target."""
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
    if base.name not in DEVICE_COMMANDS:
        raise BgError(
            [scenes.unknown_channel(target.span, base.name, device.item.name, DEVICE_COMMANDS)]
        )
    shape, unit = DEVICE_COMMANDS[base.name].shape, DEVICE_COMMANDS[base.name].dimension
    value = world.evaluate(item.value, scene.env)
    what = f"`{path_of(target)}`"
    places = list(range(_count(shape)))
    if isinstance(target, syntax.Index):
        index = world.quantities.component_index(target, scene.env, shape, path_of(base))
        places, shape = [index[0] - 1], ()
    value = fit_shape(world.dag, value, shape, item.value.span, what)
    check_units(value, unit, item.value.span, what)
    for place, node in zip(places, value.nodes, strict=True):
        key = (base.name, place + 1)
        if key in device.commands:
            raise BgError([names.given_twice(target.span, path_of(target), item.span)])
        device.commands[key] = node


def read_devices(world: World, scene: Scene) -> tuple[DeviceUse, ...]:
    """Read the devices with the input channels in use and the values of their commands."""
    for item in scene.statements(syntax.Drive):
        device = device_of(item.target, scene)
        if device is not None:
            with world.report.collecting():
                _read_command(world, scene, item, device)
    found = []
    for device in scene.devices.values():
        with world.report.collecting():
            options = tuple(_device_option(world, scene, a, device) for a in device.item.arguments)
            _check_options(world, device.item)
            inputs = tuple(
                (channel, k + 1)
                for channel in device.inputs
                for k in range(_count(DEVICE_INPUTS[channel].shape))
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


def _check_options(world: World, item: syntax.Device) -> None:
    """Report options that the driver does not have, and those that it needs."""
    if item.driver == DRIVER_BY_PATH and not any(map(_is_path, item.arguments)):
        world.report.add(no_driver_path(item.span))
    known = DRIVER_OPTIONS.get(item.driver)
    if known is None:
        return
    what = f"the driver `{item.driver}`"
    given = {argument.name for argument in item.arguments}
    for argument in item.arguments:
        if argument.name is not None and argument.name not in known:
            world.report.add(names.unknown_argument(argument.span, argument.name, what, known))
    for name, is_needed in known.items():
        if is_needed and name not in given:
            world.report.add(scenes.device_option(item.span, what, name))


def _is_path(argument: syntax.Argument) -> bool:
    """Return whether it is the path of a shared object: a text without a name."""
    return argument.name is None and isinstance(argument.value, syntax.Text)


def _device_option(
    world: World, scene: Scene, argument: syntax.Argument, device: Device
) -> tuple[str, str]:
    what = f"the driver `{device.item.driver}`"
    if device.item.driver == DRIVER_BY_PATH and _is_path(argument):
        assert isinstance(argument.value, syntax.Text)
        return "file", _from_root(world.package, argument, argument.value.value)
    if argument.name is None:
        raise BgError([scenes.device_option(argument.span, what)])
    if isinstance(argument.value, syntax.Text):
        text = argument.value.value
        own = argument.name == "file"
        return argument.name, _from_root(world.package, argument, text) if own else text
    if argument.name == "file":
        raise BgError([scenes.device_option(argument.value.span, what)])
    number = constant_of(world, scene, argument.value, f"`{argument.name}`", None)
    return argument.name, repr(number)


def _from_root(package: Package, argument: syntax.Argument, path: str) -> str:
    """A path that counts from the file of an imported scene, counted from the root file."""
    home = next((f.path for f in package.files if f.source is argument.span.source), None)
    root = package.files[-1].path
    if home is None or root is None or home.parent == root.parent:
        return path
    folder = home.resolve().parent
    try:
        return (Path(os.path.relpath(folder, root.resolve().parent)) / path).as_posix()
    except ValueError:  # on another drive
        return str(folder / path)


def _count(shape: Shape) -> int:
    count = 1
    for size in shape:
        count *= size
    return count
