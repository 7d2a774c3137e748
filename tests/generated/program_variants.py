"""The same program written or run in other ways, which have to give the same numbers."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from program_runs import RTOL, Columns, Refused, run_text
from program_text import Style, Writer, write
from program_tree import Apply, Expr, Model, Num, Part, Program, Read, Step, Value

import bgc
from bgc.diagnostics.source import Source
from bgc.grammar.format import format_source


def _styled(**choices: bool) -> Callable[[Program, Path, int], Columns]:
    def run(program: Program, place: Path, seed: int) -> Columns:
        return run_text(write(program, Style(seed=seed, **choices)), place)

    return run


def _formatted(program: Program, place: Path, seed: int) -> Columns:
    return run_text(format_source(Source("program.bg", write(program))), place)


def _whole(program: Program, place: Path, seed: int) -> Columns:
    return run_text(write(program), place, whole=True)


def _sliced(program: Program, place: Path, seed: int) -> Columns:
    """One thing observed."""
    return run_text(_with_one_observed(program, seed), place)


def _with_one_observed(program: Program, seed: int) -> str:
    """The text without accounts of energy, which need every element of a program."""
    one = random.Random(seed).choice(list(program.scene.observed))
    return write(program.with_scene(observed=(one,), accounts=False))


def _constant(program: Program, place: Path, seed: int) -> Columns:
    """Every second parameter a constant, where its value is one."""
    rng = random.Random(seed)
    models = []
    for model in program.models:
        statements = []
        for s in model.statements:
            fixed = isinstance(s, Value) and s.word == "param" and isinstance(s.value, Num)
            if fixed and rng.random() < 0.5:
                s = Value("const", s.name, s.unit, s.value, s.shape)  # type: ignore[union-attr]
            statements.append(s)
        models.append(type(model)(model.name, tuple(statements), model.interface, model.dimension))
    changed = Program(tuple(models), program.interfaces, program.scene, program.seed)
    return run_text(write(changed), place)


def _set_at_run_time(program: Program, place: Path, seed: int) -> Columns:
    """The scene's values, set at run time."""
    sets = program.scene.sets
    writer = Writer(program)
    values = {writer.path(path): float(value.value) for path, value in sets}  # type: ignore[attr-defined]
    return run_text(write(program.with_scene(sets=())), place, parameters=values)


def _nested(program: Program, place: Path, seed: int) -> Columns:
    """The main model as the only part of another one."""
    inner = Step("machine")
    outer = Model("Around", (Part(inner.name, program.main.name),))

    def moved(e: Expr) -> Expr:
        match e:
            case Read(path=path, component=component):
                return Read((inner, *path), None if component is None else moved(component))
            case Apply(op=op, args=args):
                return Apply(op, tuple(map(moved, args)))
        return e

    scene = program.scene
    scene = replace(
        scene,
        uses=tuple(replace(use, name=f"{inner.name}.{use.name}") for use in scene.uses),
        sets=tuple(((inner, *path), value) for path, value in scene.sets),
        drives=tuple(((inner, *path), moved(value)) for path, value in scene.drives),
        observed=tuple(replace(o, value=moved(o.value)) for o in scene.observed),
    )
    nested = replace(program, models=(*program.models, outer), scene=scene)
    return run_text(write(nested), place)


def slice_and_whole(program: Program, place: Path, seed: int) -> tuple[Columns, Columns]:
    """One observed thing of a program: computed alone, and with the whole program."""
    text = _with_one_observed(program, seed)
    return run_text(text, place), run_text(text, place, whole=True)


def ensemble(program: Program, place: Path) -> Columns:
    """A lane of an ensemble, among others with other values of two parameters."""
    path = place / "program.bg"
    path.write_text(write(program), encoding="utf-8")
    try:
        model = bgc.compile(path, preview=True)
    except bgc.BgError as err:
        raise Refused(",".join(sorted({d.code for d in err.diagnostics}))) from err
    free = [p for p in model.parameters if model.parameters[p].value != 0][:2]
    own = {p: model.parameters[p].value for p in free}
    sets = [own, {p: 1.1 * value for p, value in own.items()}, own]
    many = model.simulate_many(sets, rtol=RTOL)
    if 2 in many.failures:
        raise Refused(many.failures[2].code)
    return dict(zip(many.names, many.values[2].T, strict=True))


VARIANTS: dict[str, Callable[[Program, Path, int], Columns]] = {
    "units": _styled(units=True),
    "unrolled": _styled(unrolled=True),
    "shuffled": _styled(shuffled=True),
    "renamed": _styled(renamed=True),
    "rewritten": _styled(units=True, unrolled=True, shuffled=True, renamed=True),
    "formatted": _formatted,
    "whole": _whole,
    "sliced": _sliced,
    "constant": _constant,
    "set": _set_at_run_time,
    "nested": _nested,
}
