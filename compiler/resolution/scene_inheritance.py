"""Scenes that extend other scenes: the statements that each takes over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bgc.diagnostics.catalogue import inherited_scenes as messages
from bgc.diagnostics.collection import Report
from bgc.grammar import syntax
from bgc.grammar.scene_statements import statement_of
from bgc.resolution.modules import Inherited, Module, WholeScene

MAX_BASES = 100  # of a scene, by `is`


def collect_scenes(module: Module, report: Report) -> None:
    """Complete the scenes of a file by those that they extend, and report what is wrong.

    `module.seen_scenes` holds the imported scenes before; those of the file replace imported ones
    of their names. A scene without a sound base is left out.
    """
    declared = {s.name: s for s in reversed(module.scene_declarations)}
    done: dict[str, WholeScene | None] = {}
    for scene in module.scene_declarations:
        _complete(scene, declared, done, module, report)
    # The order of the file; of two scenes of one name, which is reported, the first.
    found = (done[scene.name] for scene in module.scene_declarations)
    module.scenes = tuple({id(whole): whole for whole in found if whole is not None}.values())
    for whole in module.scenes:
        module.seen_scenes[whole.declaration.name] = [whole]


def _complete(
    scene: syntax.Scene,
    declared: dict[str, syntax.Scene],
    done: dict[str, WholeScene | None],
    module: Module,
    report: Report,
) -> None:
    """Complete a scene after those of the same file that it extends."""
    if scene.name in done:
        return
    line = [scene]
    while (base := line[-1].base) is not None and base.name in declared and base.name not in done:
        above = declared[base.name]
        if above in line:
            cycle = line[line.index(above) :]
            first = min(cycle, key=lambda s: s.span.start)
            names = [s.name for s in (*cycle, above)]
            at = names.index(first.name)
            assert first.base is not None
            shown = [*names[at:-1], *names[:at], first.name]
            report.add(messages.scene_extends_itself(first.base.span, shown))
            done.update((s.name, None) for s in line)
            return
        line.append(above)
    for each in reversed(line):
        done.setdefault(each.name, _whole(each, done, module, report))


def _whole(
    scene: syntax.Scene,
    done: dict[str, WholeScene | None],
    module: Module,
    report: Report,
) -> WholeScene | None:
    """Return a scene with what it takes over; None, with a report, if its base is not sound."""
    if scene.base is None:
        return None if scene.model is None else WholeScene(scene, scene.model, scene.items)
    name, span = scene.base.name, scene.base.span
    found = [done[name]] if name in done else [*module.seen_scenes.get(name, ())]
    if not found:
        known = sorted({*module.seen_scenes, *(s.name for s in module.scene_declarations)})
        report.add(messages.unknown_base_scene(span, name, known, name in module.models))
        return None
    if len(found) > 1:
        places = [whole.declaration.name_span for whole in found if whole is not None]
        report.add(messages.ambiguous_base_scene(span, name, places))
        return None
    (base,) = found
    if base is None:
        return None
    if base.bases >= MAX_BASES:
        report.add(messages.too_many_bases(span, MAX_BASES))
        return None
    return extended(base, scene)


def extended(base: WholeScene, scene: syntax.Scene) -> WholeScene:
    """Return a scene with the statements of its base that it does not replace, these first."""
    own = set(map(_key, scene.items))
    kept = [item for item in base.items if own.isdisjoint(_replaced_by(item))]
    slots = {text_of(item.slot): None for item in scene.items if isinstance(item, syntax.Use)}
    before = {id(each.item): each.slots for each in base.inherited}
    inherited = tuple(
        Inherited(item, tuple(dict.fromkeys((*before.get(id(item), ()), *slots)))) for item in kept
    )
    items = (*kept, *replacing(base.items, scene.items))
    return WholeScene(scene, base.model, items, inherited, base.bases + 1)


def replacing(
    before: Sequence[syntax.SceneItem], items: Sequence[syntax.SceneItem]
) -> list[syntax.SceneItem]:
    """Tell each `use` that keeps arguments the type of the one before that it replaces."""
    types = {text_of(item.slot): item.type for item in before if isinstance(item, syntax.Use)}
    return [
        replace(item, type=replace(item.type, replaced=types.get(text_of(item.slot))))
        if isinstance(item, syntax.Use) and item.type.keeps
        else item
        for item in items
    ]


def _key(item: syntax.SceneItem) -> tuple[str, str] | None:
    """The key of a statement, with its word; None where statements add to others."""
    row = statement_of(item)
    if row.key is None:
        return None
    key = getattr(item, row.key) if row.key else ""
    return row.word, key if isinstance(key, str) else text_of(key)


def _replaced_by(item: syntax.SceneItem) -> set[tuple[str, str]]:
    """The keys by which a statement is replaced: its own, and that of a whole value it sets."""
    key = _key(item)
    found = set() if key is None else {key}
    match item:
        case (
            syntax.Set(target=syntax.Index() as target)
            | syntax.Drive(target=syntax.Index() as target)
        ):
            found.add((statement_of(item).word, text_of(target.base)))
        case _:
            pass
    return found


def text_of(path: syntax.Expr) -> str:
    """A path as written, without blanks and comments: `crane.boom.mass`, `body[2].mass`."""
    match path:
        case syntax.Name():
            return path.name
        case syntax.Member():
            return f"{text_of(path.base)}.{path.name}"
        case syntax.Index():
            return f"{text_of(path.base)}[{','.join(_plain(i.span.text) for i in path.indices)}]"
        case _:
            return _plain(path.span.text)


def _plain(text: str) -> str:
    return "".join(text.split())
