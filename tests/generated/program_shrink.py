"""Remove statements from a program for as long as its outcome stays what it is."""

from __future__ import annotations

import itertools
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from program_check import by_equations, by_reference, program_of
from program_text import write
from program_tree import Assign, Model, Part, Program, Statement, Value


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
    for model in program.models:
        for s in model.statements:
            if isinstance(s, Part | Value | Assign):
                yield _without(program, model, s)


def _without(program: Program, model: Model, gone: Statement) -> Program:
    """The program without a declaration and all that mentions its name."""
    mark = f"name='{gone.name}'"  # type: ignore[union-attr]
    kept = tuple(s for s in model.statements if mark not in repr(s))
    models = tuple(
        replace(m, statements=kept)
        if m is model
        else replace(m, statements=tuple(s for s in m.statements if mark not in repr(s)))
        for m in program.models
    )
    scene = program.scene
    observed = tuple(o for o in scene.observed if mark not in repr(o))
    return replace(program, models=models).with_scene(
        observed=observed,
        sets=tuple(s for s in scene.sets if mark not in repr(s)),
        drives=tuple(s for s in scene.drives if mark not in repr(s)),
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
            return now[0] == kind and (kind not in ("refused", "crash") or now[1] == about)

        return f"// {kind}: {about}\n{write(shrunk(program_of(seed), keeps))}"


if __name__ == "__main__":
    print(shrink_seed(int(sys.argv[1])))
