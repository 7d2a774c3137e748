"""Collect and check the changes of a model by `set`, `use`, `drive` and the command line."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from bgc.diagnostics.catalogue import listed, names, scenes, with_article
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source, Span
from bgc.elaboration.bonds.shape_probe import WidthUnknown
from bgc.elaboration.instances.limits import MAX_WIDTH
from bgc.elaboration.instances.scopes import ElementView, Names, path_of
from bgc.elaboration.instances.tree import Environment, Given
from bgc.elaboration.instances.world import Edits, World
from bgc.elaboration.scenes.observations import declared_value
from bgc.elaboration.scenes.scene_choice import Scene
from bgc.elaboration.scenes.scene_devices import declare_devices, device_of
from bgc.grammar import syntax
from bgc.grammar.parse import parse_setting
from bgc.language.elements import ELEMENTS
from bgc.values.expressions import resolve_path
from bgc.values.scope import Namespace
from bgc.values.value import Value

_CONSTANT_OF_A_FILE = "a constant of a file"


def collect_edits(world: World, scene: Scene, overrides: Sequence[tuple[str, str]]) -> None:
    """Enter the scene's edits, then the command line's; number the channels of devices."""
    edits = world.edits
    declare_devices(world, scene)
    for item in scene.items:
        with world.report.collecting():
            match item:
                case syntax.Set():
                    _note_set(world, scene, edits, item.target, item.value, item.span)
                case syntax.Use():
                    path = canonical_path(world, item.slot, scene.env)
                    _note(edits.uses, path, Given(item.type, scene.env, item.span))
                case syntax.Drive() if device_of(item.target, scene) is None:
                    path = canonical_path(world, item.target, scene.env)
                    _note(edits.drives, path, Given(item.value, scene.env, item.span))
                case _:
                    pass
    for override in overrides:
        with world.report.collecting():
            setting = _read_override(override)
            path = canonical_path(world, setting.target, scene.env)
            edits.sets.pop(path, None)  # the command line overrides the scene
            _note_set(world, scene, edits, setting.target, setting.value, setting.value.span)


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


def _read_override(override: tuple[str, str]) -> syntax.Set:
    """Parse the two sides of `--set name=value`, with spans in the user's text."""
    return parse_setting(Source("--set", "=".join(override)))


def canonical_path(world: World, expr: syntax.Expr, env: Environment) -> str:
    """A path as instances spell theirs, with indices evaluated: `body[2].mass`."""
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


def check_edits(world: World, scene: Scene, slots: Sequence[str]) -> None:
    """Report each `set`, `use` and `drive` that was not applied, since its path has no target."""
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
                case syntax.Drive() if device_of(item.target, scene) is None:
                    path = canonical_path(world, item.target, scene.env)
                    unused.append((item.target, item.target.span, "drives", path))
                case _:
                    pass
    for expr, span, kind, path in unused:
        if (kind, path) not in edits.used:
            with world.report.collecting():
                _refuse_argument(world, scene, expr)
                target = _check_path(world, scene, expr)
                what = tables.get(kind, (None, "a parameter or constant"))[1]
                found, way = _mismatch(world, scene, expr, None if kind == "uses" else target)
                what = "a parameter" if found == _CONSTANT_OF_A_FILE else what
                if kind == "drives" and isinstance(expr, syntax.Index) and found == "an input":
                    found, whole = "a component of an input", path_of(expr.base)
                    way = f"drive all components together: `drive {whole} = [..];`"
                if kind == "uses" and not way and slots:
                    way = f"name a slot of the scene: {listed(slots)}"
                raise BgError([scenes.edit_without_target(span, path, what, found, way)])


def check_overrides(world: World, scene: Scene, overrides: Sequence[tuple[str, str]]) -> None:
    """Report each override of the command line whose path has no target."""
    for override in overrides:
        with world.report.collecting():
            expr = _read_override(override).target
            base = expr.base if isinstance(expr, syntax.Index) else expr
            path = canonical_path(world, base, scene.env)
            kind = "parts" if isinstance(expr, syntax.Index) else "sets"
            if (kind, path) not in world.edits.used:
                _refuse_argument(world, scene, expr)
                target = _check_path(world, scene, expr)
                what = "a parameter or constant"
                found, way = _mismatch(world, scene, expr, target)
                what = "a parameter" if found == _CONSTANT_OF_A_FILE else what
                raise BgError([scenes.edit_without_target(expr.span, path, what, found, way)])


def _refuse_argument(world: World, scene: Scene, expr: syntax.Expr) -> None:
    """Refuse a path such as `body.inertia`, which ends at an argument of an element, as BG603."""
    if not isinstance(expr, syntax.Member):
        return
    target = None
    with suppress(BgError):
        target = _check_path(world, scene, expr.base)
    if isinstance(target, ElementView):
        kind, name = target.element.kind, target.element.path
        if expr.name in {argument.name for argument in ELEMENTS[kind].arguments}:
            found = f"an argument of {with_article(kind)}"
            way = f"declare a `param` or `input`, and use it in `{name}`"
            what = "a parameter or constant"
            raise BgError([scenes.edit_without_target(expr.span, path_of(expr), what, found, way)])


def _mismatch(
    world: World, scene: Scene, expr: syntax.Expr, target: Value | Namespace | None
) -> tuple[str, str]:
    """A description of a target that cannot be changed in this way, and the remedy; or empty."""
    if isinstance(target, ElementView):
        kind, name = target.element.kind, target.element.path
        return with_article(kind), f"declare a `param` or `input`, and use it in `{name}`"
    quantity = declared_value(world, scene, expr)
    if quantity is None:
        root = scene.env.instance
        own = root is not None and isinstance(expr, syntax.Name) and expr.name in root.members
        if isinstance(expr, syntax.Name) and not own and expr.name in scene.env.module.constants:
            way = f"declare it with `param {expr.name} = ..;` at the top level of its file"
            return _CONSTANT_OF_A_FILE, way
        return "", ""
    path = path_of(expr)
    match quantity.kind:
        case "input":
            return "an input", f"write `drive {path} = ..;`, or give it as an argument"
        case "param" | "const":
            return (
                "a parameter",
                f"write `set {path} = ..;`, or declare it as an `input` to drive it",
            )
        case "state" | "unknown":
            return (
                f"the {quantity.kind} of a model",
                "set the parameter that gives its initial value",
            )
        case _:
            return "computed by the model", "set a parameter that it depends on"


def _check_path(world: World, scene: Scene, expr: syntax.Expr) -> Value | Namespace | None:
    """Return the target of a path, None for a variable of unknown width; BgError without one."""
    with suppress(WidthUnknown):
        return resolve_path(expr, Names(world, scene.env, {}, False), world.dag)
    return None
