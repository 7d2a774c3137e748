"""Remove statements from a program for as long as its outcome stays what it is."""

from __future__ import annotations

import itertools
import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from program_check import by_equations, by_reference, program_of
from program_text import write
from program_tree import (
    Assign,
    Bond,
    Equation,
    For,
    Model,
    Part,
    Program,
    Sampled,
    Statement,
    Value,
)

NUMBER = r"[0-9][0-9.e+-]*"


def shrunk(program: Program, keeps: Callable[[Program], bool]) -> Program:
    """The smallest program reached by removing one name, or one observation, after the other.

    What could not be removed is tried again only after a round over all the others.
    """
    again = True
    while again:
        again, place = False, 0
        while True:
            smaller = next(itertools.islice(_smaller(program), place, None), None)
            if smaller is None:
                break
            if keeps(smaller):
                program, again = smaller, True
            else:
                place += 1
    return program


def _smaller(program: Program) -> Iterator[Program]:
    observed = program.scene.observed
    if len(observed) > 1:
        for k in range(len(observed)):
            yield program.with_scene(observed=observed[k : k + 1])
    for field in ("sets", "drives", "uses"):
        if getattr(program.scene, field):
            yield program.with_scene(**{field: ()})
    if program.scene.accounts:
        yield program.with_scene(accounts=False)
    unused = _unused(program)
    if unused:
        models = tuple(m for m in program.models if m.name not in unused)
        interfaces = tuple(i for i in program.interfaces if i.name not in unused)
        yield replace(program, models=models, interfaces=interfaces)
    for model in program.models:
        for s in model.statements:
            if isinstance(s, Part | Value | Assign | Sampled):
                yield _without(program, model, s)
                yield _without(program, model, s, alone=True)
        for k, s in enumerate(model.statements):
            if isinstance(s, Bond | For | Equation):
                yield _with_statement(program, model, k)
            if isinstance(s, Part) and s.arguments:
                bare = tuple(a for a in s.arguments if a[0][-1] != "0")
                if bare != s.arguments:
                    yield _with_statement(program, model, k, replace(s, arguments=bare))


def _unused(program: Program) -> set[str]:
    """The models and interfaces that no other names, but for that of the scene."""
    uses = repr([[m.statements for m in program.models], program.scene.uses])
    named = uses + repr([m.interface for m in program.models])
    found = {m.name for m in program.models[:-1] if f"type='{m.name}'" not in uses}
    return found | {i.name for i in program.interfaces if f"'{i.name}'" not in named}


def _with_statement(program: Program, model: Model, place: int, *instead: Statement) -> Program:
    """The program with something else, or nothing, at a place of a model."""
    kept = (*model.statements[:place], *instead, *model.statements[place + 1 :])
    changed = replace(model, statements=kept)
    return replace(program, models=tuple(changed if m is model else m for m in program.models))


def signature(kind: str, about: str) -> str:
    """What an outcome keeps while its program shrinks: its kind, codes and what is missed."""
    if kind == "crash":
        return f"{kind} {re.sub(NUMBER, '', about)[:60]}"
    said = re.findall(r"BG\d+", about) or re.findall(r"^\S+", about)
    return " ".join([kind, *(said if kind != "agrees" else [])])


def _without(program: Program, model: Model, gone: Statement, *, alone: bool = False) -> Program:
    """The program without a declaration and all that mentions its name.

    With `alone` the parts to which no bond leads then go with it.
    """
    mark = f"name='{gone.name}'"  # type: ignore[union-attr]
    kept = tuple(s for s in model.statements if mark not in repr(s))
    marks = {mark}
    if alone:
        bonds = repr([s for s in kept if isinstance(s, Bond | For)])
        names = {f"name='{s.name}'" for s in kept if isinstance(s, Part)}
        marks |= {name for name in names if name not in bonds}

    def clean(thing: object) -> bool:
        return not any(mark in repr(thing) for mark in marks)

    models = tuple(
        replace(m, statements=tuple(s for s in m.statements if clean(s))) for m in program.models
    )
    scene = program.scene
    return replace(program, models=models).with_scene(
        observed=tuple(o for o in scene.observed if clean(o)),
        sets=tuple(s for s in scene.sets if clean(s)),
        drives=tuple(s for s in scene.drives if clean(s)),
    )


def shrink_seed(seed: int) -> str:
    """Text of a small program with the outcome of a seed."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        check = by_reference if seed % 20 == 0 else by_equations  # as a campaign does
        kind, about = check(program_of(seed), place, 0)

        def keeps(program: Program) -> bool:
            try:
                now = check(program, place, 0)
            except Exception:
                return False
            return signature(*now) == signature(kind, about)

        return f"// {kind}: {about}\n{write(shrunk(program_of(seed), keeps))}"


if __name__ == "__main__":
    print(shrink_seed(int(sys.argv[1])))
