"""Inherited statements about parts that a `use` has removed: they are dropped, with a note."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from bgc.diagnostics.catalogue.inherited_scenes import statement_dropped
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.elaboration.instances.limits import MAX_TURNS
from bgc.elaboration.instances.tree import Element, Instance, Member, PartArray, Pending
from bgc.elaboration.instances.world import World
from bgc.elaboration.scenes.scene_choice import Scene
from bgc.grammar import syntax
from bgc.grammar.scene_statements import expressions_in, statement_of
from bgc.resolution.modules import Inherited
from bgc.resolution.scene_inheritance import text_of


def without_removed(world: World, scene: Scene) -> tuple[Scene, tuple[Diagnostic, ...]] | None:
    """Drop the inherited statements that name a part or value which is not there any more.

    A statement counts only where a scene below the one that wrote it fills the slot of that part.
    Of an inherited `plot` only the dropped columns go, of a `start` the paths. Returns None if
    nothing is dropped, else the scene without the statements, and a note for each.
    """
    dropped: dict[int, Diagnostic] = {}
    columns: list[str] = []
    shortened: dict[int, syntax.SceneItem] = {}
    for each in scene.inherited:
        for path in _paths_in(each.item):
            slot = _slot_above(path, each.slots)
            if slot and _is_missing(world, scene, path):
                word = statement_of(each.item).word
                shorter = _shortened(world, scene, each)
                what = f"`{word}`" if shorter is None else f"path of `{word}`"
                dropped[id(each.item)] = statement_dropped(path.span, what, text_of(path), slot)
                if shorter is not None:
                    shortened[id(each.item)] = shorter
                if isinstance(each.item, syntax.Observe):
                    columns.append(each.item.alias or text_of(each.item.value))
                break
    if not dropped:
        return None
    inherited = {id(each.item) for each in scene.inherited}
    items: list[syntax.SceneItem] = []
    for item in scene.items:
        if id(item) in shortened:
            items.append(shortened[id(item)])
            continue
        if id(item) in dropped:
            continue
        reduced = _reduced(item, columns) if id(item) in inherited else item
        if reduced is not None:
            items.append(reduced)
    kept = tuple(each for each in scene.inherited if id(each.item) not in dropped)
    env = replace(scene.env, instance=None, locals={})
    changed = replace(scene, items=tuple(items), inherited=kept, env=env, devices={})
    return changed, tuple(dropped.values())


def _shortened(world: World, scene: Scene, each: Inherited) -> syntax.SceneItem | None:
    """A statement with lists of paths, without those that are gone; None for other statements."""
    named = {name: getattr(each.item, name) for name in statement_of(each.item).paths}
    lists = {name: paths for name, paths in named.items() if isinstance(paths, tuple)}

    def stays(path: syntax.Expr) -> bool:
        return not (_slot_above(path, each.slots) and _is_missing(world, scene, path))

    kept: dict[str, Any] = {name: tuple(filter(stays, paths)) for name, paths in lists.items()}
    return replace(each.item, **kept) if kept else None


def _reduced(item: syntax.SceneItem, columns: Sequence[str]) -> syntax.SceneItem | None:
    """A `plot` or `require` without dropped columns; None if nothing is left of it."""
    match item:
        case syntax.Plot():
            drawn = tuple(c for c in item.columns if not _is_column(c, columns))
            if not drawn or (item.against is not None and _is_column(item.against, columns)):
                return None
            return replace(item, columns=drawn)
        case syntax.Require() if any(_is_column(side, columns) for side in _sides(item.value)):
            return None
        case _:
            return item


def _sides(value: syntax.Expr) -> tuple[syntax.Expr, ...]:
    """The value of a requirement, or the sides of its comparison, without `abs`."""
    match value:
        case syntax.Binary(left=left, right=right):
            return (*_sides(left), *_sides(right))
        case syntax.Call(function="abs", arguments=(inner,)):
            return (inner,)
        case _:
            return (value,)


def _is_column(path: syntax.Expr, columns: Sequence[str]) -> bool:
    """Return whether a path names one of these columns or a component of one."""
    name = text_of(path)
    return any(name == c or name.startswith((f"{c}.", f"{c}[")) for c in columns)


def _slot_above(path: syntax.Expr, slots: Sequence[str]) -> str | None:
    """The one of these slots that contains the target of a path."""
    name = text_of(path)
    return next((s for s in slots if name.startswith((f"{s}.", f"{s}["))), None)


def _is_missing(world: World, scene: Scene, path: syntax.Expr) -> bool:
    """Return whether a path leads to a part or value that the model does not have."""
    steps: list[syntax.Expr] = []
    while isinstance(path, syntax.Member | syntax.Index):
        steps.append(path)
        path = path.base
    root = scene.env.instance
    if not isinstance(path, syntax.Name) or root is None or path.name in scene.devices:
        return False
    found: Member | Instance | Element | None = root.members.get(path.name)
    for step in reversed(steps):
        if isinstance(found, Pending):
            pending, found = found, None
            with world.report.collecting():  # a choice that does not fit is reported by itself
                found = world.builder.build(pending)
        match found, step:
            case Instance(), syntax.Member(name=name):
                if name not in found.members and name not in found.formals:
                    return True
                found = found.members.get(name)
            case PartArray(), syntax.Index():
                index = tuple(
                    world.whole(i, scene.env, "an index", -MAX_TURNS, MAX_TURNS)
                    for i in step.indices
                    if not isinstance(i, syntax.Range)
                )
                if index not in found.parts:
                    return True
                found = found.parts[index]
            case _:
                return False  # a value, a port or an element: errors are reported where it is read
    return False


def _paths_in(item: syntax.SceneItem) -> Iterator[syntax.Expr]:
    """Yield the paths that a statement names."""
    for expr in expressions_in(item, statement_of(item).paths):
        yield from _paths(expr)


def _paths(expr: syntax.Expr | syntax.Range) -> Iterator[syntax.Expr]:
    """Yield the longest paths in an expression, and those within their indices."""
    match expr:
        case syntax.Name():
            yield expr
        case syntax.Member() | syntax.Index():
            yield expr
            inner: syntax.Expr = expr
            while isinstance(inner, syntax.Member | syntax.Index):
                if isinstance(inner, syntax.Index):
                    for index in inner.indices:
                        yield from _paths(index)
                inner = inner.base
            if not isinstance(inner, syntax.Name):
                yield from _paths(inner)
        case syntax.Range():
            yield from _paths(expr.first)
            yield from _paths(expr.last)
        case syntax.Unary():
            yield from _paths(expr.operand)
        case syntax.Binary():
            yield from _paths(expr.left)
            yield from _paths(expr.right)
        case syntax.Conditional():
            for part in (expr.condition, expr.yes, expr.no):
                yield from _paths(part)
        case syntax.Call():
            for part in expr.arguments:
                yield from _paths(part)
        case syntax.Vector():
            for part in expr.elements:
                yield from _paths(part)
        case syntax.TypeUse():
            for argument in expr.arguments:
                yield from _paths(argument.value)
        case syntax.Number() | syntax.Text():
            pass
