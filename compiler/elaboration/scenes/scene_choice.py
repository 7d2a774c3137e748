"""Choose the scene to compile: its model, statements and devices."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from bgc.algebra.evaluate import to_double
from bgc.diagnostics.catalogue import scenes, values
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.scopes import Names
from bgc.elaboration.instances.tree import Environment
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.ir.graph import Node
from bgc.record_class import dataclass, field, replace
from bgc.resolution.modules import Declared, Inherited, Package, flatten
from bgc.values.expressions import evaluate_constant
from bgc.values.units import Dimension, describe_dimension
from bgc.values.value import describe_shape

Item = TypeVar("Item", bound=syntax.SceneItem)


@dataclass(slots=True, eq=False)
class Device:
    """A device of the scene: the input channels in use, and its commands.

    `first` is the index of its first INPUT symbol; `commands` maps a channel and a component
    (from 1) to a value.
    """

    item: syntax.Device
    first: int
    inputs: dict[str, int]  # channel -> index of its first INPUT symbol
    commands: dict[tuple[str, int], Node] = field(default_factory=dict)


@dataclass(slots=True, eq=False)
class Scene:
    """The chosen scene: its model, its statements and their environment.

    `implicit` is True for a file without scenes, whose states and outputs are all observed.
    `inherited` are statements from scenes that it extends.
    """

    name: str
    model: Declared[syntax.Model]
    use: syntax.TypeUse
    items: tuple[syntax.SceneItem, ...]
    env: Environment
    implicit: bool
    inherited: tuple[Inherited, ...] = ()
    devices: dict[str, Device] = field(default_factory=dict)

    def statements(self, kind: type[Item]) -> Iterator[Item]:
        """The statements of one kind, in source order."""
        return (item for item in self.items if isinstance(item, kind))


def stands_alone(package: Package) -> bool:
    """Return whether a file compiles by itself: it has a scene, or its last model is complete.

    A file of library parts cannot: its models have ports to bond and values to be supplied.
    """
    root = package.root
    if root.scenes or not root.file.declarations:  # an empty file is not a library
        return True
    return bool(root.own_models) and not _is_incomplete(root.own_models[-1], frozenset())


def models_alone(package: Package) -> Iterator[Package]:
    """Yield, for each complete model that no scene and no other model uses, a package to check it.

    Such a model is not reached from the file's scenes. The root file of the package holds this
    one declaration and no scene.
    """
    root = package.root
    reached = {name for d in root.file.declarations for name in _types_in(d)}
    for model in root.own_models:
        if model.syntax.name not in reached and not _is_incomplete(model, frozenset()):
            file = replace(root.file, declarations=(model.syntax,))
            yield replace(package, root=replace(root, file=file, scenes=()))


def _types_in(declaration: syntax.Declaration) -> Iterator[str]:
    """Yield the names of the types that a declaration uses; a slot's may stand in a `use`."""
    match declaration:
        case syntax.Model():
            if declaration.base is not None:
                yield declaration.base.name
            for item in flatten(declaration.items):
                if isinstance(item, syntax.Part):
                    yield from (use.name for use in (item.type, item.default) if use is not None)
        case syntax.Scene():
            if declaration.model is not None:
                yield declaration.model.name
            for statement in declaration.items:
                if isinstance(statement, syntax.Use):
                    yield statement.type.name
        case _:
            pass


def _is_incomplete(model: Declared[syntax.Model], given: frozenset[str]) -> bool:
    """Return whether a model has ports, or dimensions or values without a default."""
    if any(formal.default is None for formal in model.syntax.formals):
        return True
    for item in model.syntax.items:
        match item:
            case syntax.Port():
                return True
            case syntax.Value(kind="param" | "input", value=None) if item.name not in given:
                return True
    base = model.syntax.base
    above = model.module.models.get(base.name) if base else None
    if base is None or above is None or above.syntax.interface:
        return False
    return _is_incomplete(above, given | {a.name for a in base.arguments if a.name is not None})


def choose_scene(package: Package, name: str | None) -> Scene:
    """Choose the scene of a name, else the file's first, else an implicit one of its last model."""
    module = package.root
    found = module.scenes
    if name is not None:
        chosen = [scene for scene in found if scene.declaration.name == name]
        if not chosen:
            raise BgError([scenes.unknown_scene(name, package.scene_names)])
        found = tuple(chosen)
    env = Environment(None, module, {})
    if found:
        scene = found[0]
        model = module.models[scene.model.name]
        own = scene.declaration.name
        return Scene(own, model, scene.model, scene.items, env, False, scene.inherited)
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


def constant_of(
    world: World, scene: Scene, expr: syntax.Expr, what: str, unit: Dimension | None
) -> float:
    """Evaluate a compile-time number in SI units; BgError for a unit other than `unit`."""
    value = world.evaluate(expr, scene.env)
    found = value.unit
    if unit is not None and found is not None and found != unit:
        expected = describe_dimension(unit)
        raise BgError([values.wrong_unit(expr.span, what, expected, describe_dimension(found))])
    if len(value.nodes) != 1:
        raise BgError(
            [shape_messages.wrong_shape(expr.span, what, "a scalar", describe_shape(value.shape))]
        )
    exact = evaluate_constant(expr, Names(world, scene.env, {}, False), world.dag, what)
    return to_double(exact)
