"""Compare generated programs with the reference, and with themselves written in other ways.

`check_seed` gives an outcome in one word and what it is about. The classes are

========== ========================================================================
agrees     reference and compiled program give the same trajectories and energies,
           and so do the variants that were tried
same       the reference did not get through, but all variants give the same numbers
refused    the compiler refuses or the run ends, and the reference has a solution
open       the reference finds the program ill-posed, the compiler runs it
ill        both refuse
differs    numbers differ: of the reference, or between variants
crash      an exception that is no diagnostic
========== ========================================================================
"""

from __future__ import annotations

import random
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from dense_dae import IllPosed, NoSolution, Reference, Trajectory
from program_draw import Wishes, draw_program
from program_text import Style, Writer, write
from program_tree import Num, Program, Value
from raw_equations import raw_equations

import bgc
from bgc.diagnostics.source import Source
from bgc.grammar.format import format_source

RTOL = 1e-9
CLOSE = 1e-5  # of the largest value of a column, or of a hundredth of its size in the program
ACCOUNTS = ("energy.stored", "energy.supplied", "energy.dissipated")
Columns = dict[str, np.ndarray]


@dataclass(frozen=True)
class Outcome:
    seed: int
    kind: str
    about: str
    seconds: float = 0.0

    def row(self) -> str:
        return f"{self.seed}\t{self.kind}\t{self.about}\t{self.seconds:.2f}"


class Refused(Exception):
    """A diagnostic of the compiler or of the run; the text is its code."""


def run_text(
    text: str,
    place: Path,
    *,
    rtol: float = RTOL,
    solver: str | None = None,
    parameters: Mapping[str, float] | None = None,
    whole: bool = False,
) -> Columns:
    """Compile a program and run its scene."""
    path = place / "program.bg"
    path.write_text(text, encoding="utf-8")
    try:
        model = bgc.compile(path, preview=True, whole=whole)
        result = model.simulate(rtol=rtol, solver=solver, parameters=parameters)
    except bgc.BgError as err:
        raise Refused(",".join(sorted({d.code for d in err.diagnostics}))) from err
    return {name.removesuffix("[1]"): np.asarray(column) for name, column in result.columns.items()}


def difference(
    a: Columns, b: Columns, scales: Mapping[str, float], *, first: int = 0
) -> tuple[float, str]:
    """The largest difference from a row on, relative to the size of its column, and the column."""
    worst, where = 0.0, ""
    for name in sorted(set(a) & set(b) & set(scales)):
        size = np.abs(a[name]).max() + 1e-2 * scales[name]
        error = float(np.abs(a[name] - b[name])[first:].max() / size)
        if not error <= worst:
            worst, where = error, name
    return worst, where


def scales_of(program: Program) -> dict[str, float]:
    """The sizes of the columns; energies are those of a second in the least powerful domain."""
    return {o.name: o.scale for o in program.scene.observed} | dict.fromkeys(ACCOUNTS, 1.0)


def first_row(program: Program) -> int:
    """The first row to compare with the reference.

    States that start at 0 start at the kink of many laws, and what depends on the slope of such a
    law (reactions of dependent storage) has two values there.
    """
    return int(any(word in write(program) for word in (" if ", "(if", "abs(", "min(", "max(")))


# --- variants ---------------------------------------------------------------------------------


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
    one = random.Random(seed).choice(list(program.scene.observed))
    return run_text(write(program.with_scene(observed=(one,))), place)


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
    """Move the settings of the scene to the run."""
    sets = program.scene.sets
    writer = Writer(program)
    values = {writer.path(path): float(value.value) for path, value in sets}  # type: ignore[attr-defined]
    return run_text(write(program.with_scene(sets=())), place, parameters=values)


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
}


# --- one seed -----------------------------------------------------------------------------------


def reference_of(
    program: Program, *, rtol: float = 1e-9, method: str = "LSODA", most: float = 2.0
) -> Trajectory:
    """The solution of the raw equations, given up after `most` seconds of processor time."""
    scene = program.scene
    solved = Reference(raw_equations(program))
    return solved.run(float(scene.duration), scene.rows, rtol=rtol, method=method, most=most)


def program_of(seed: int) -> Program:
    """The program of a seed; without initial values where they contradict each other."""
    program = draw_program(seed)
    try:
        Reference(raw_equations(program)).start()
    except (IllPosed, NoSolution, np.linalg.LinAlgError):
        return draw_program(seed, Wishes(initials=False))
    return program


def check_seed(seed: int, *, variants: int = 2) -> Outcome:
    """The outcome of a seed with some variants, and the processor time that it took."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        kind, about = checked(program_of(seed), Path(folder), variants)
    return Outcome(seed, kind, about, time.process_time() - began)


def checked(program: Program, place: Path, variants: int, *, most: float = 2.0) -> tuple[str, str]:
    """Kind and detail of a program's outcome; `most` seconds are given to the reference."""
    scales = scales_of(program)
    expected: Trajectory | None = None
    trouble = ""
    try:
        expected = reference_of(program, most=most)
    except IllPosed as err:
        trouble = f"ill-posed: {err}"
    except (NoSolution, np.linalg.LinAlgError) as err:
        trouble = f"no solution: {err}"
    try:
        base = run_text(write(program), place)
    except Refused as err:
        if expected is not None:
            return "refused", str(err)
        return ("ill" if trouble.startswith("ill") else "reference"), f"{err}; {trouble}"
    except Exception as err:
        return "crash", f"{type(err).__name__}: {err}"[:100]
    if expected is not None:
        error, where = difference(expected.columns, base, scales, first=first_row(program))
        if not error <= CLOSE:
            return _confirmed(program, place, scales, where)
    names = random.Random(program.seed).sample(sorted(VARIANTS), variants)
    for name in names:
        found = _variant(program, place, scales, name, base)
        if found is not None:
            return found
    if expected is None:
        return ("open" if trouble.startswith("ill") else "same"), trouble[:80]
    return "agrees", " ".join(names)


def _variant(
    program: Program, place: Path, scales: Mapping[str, float], name: str, base: Columns
) -> tuple[str, str] | None:
    """Describe the fault of a variant; None if it has none."""
    try:
        other = VARIANTS[name](program, place, program.seed)
    except Refused as err:
        return "differs", f"{name}: refused {err}"
    except Exception as err:
        return "crash", f"{name}: {type(err).__name__}: {err}"[:100]
    error, where = difference(base, other, scales)
    if error <= CLOSE:
        return None
    return "differs", f"{name}: {where} by {error:.1e}"


def _confirmed(
    program: Program, place: Path, scales: Mapping[str, float], where: str
) -> tuple[str, str]:
    """Return whether a difference stays at tighter tolerances; else it is of the tolerances."""
    try:
        tight = reference_of(program, rtol=1e-11, most=20.0)
        base = run_text(write(program), place, rtol=1e-11)
    except (IllPosed, NoSolution, Refused) as err:
        return "differs", f"{where}; unconfirmed: {err}"
    error, where = difference(tight.columns, base, scales, first=first_row(program))
    if error <= CLOSE:
        return "agrees", "at tighter tolerances"
    return "differs", f"{where} by {error:.1e}"
