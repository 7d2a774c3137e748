"""The outcome of a program drawn from a seed.

Two checks are there. `by_equations` observes every variable of a program and puts the columns into
its raw equations (`equation_check.py`). `by_reference` compares a few columns with the
integrated raw equations (`dense_dae.py`). Both can try variants (`program_variants.py`).

========== ========================================================================
agrees     equations or reference are satisfied, and the variants give the same numbers
rest       the same, but nothing moves: all columns are zero
loose      numbers differ, though less than 30 times the tolerance at default settings, and
           agree at tighter ones
refused    the compiler refuses or the run ends, and the reference has a solution
modulus    the compiler refuses to divide by a modulus of the program that may vanish
reference  the compiler refuses, the reference does not get through, and the raw equations are
           regular near random points
ends       the run ends with a status and satisfies its equations until then; the coefficient of an
           unknown vanishes at that time and the reference ends too, or it ends at that time
open       the reference finds the program ill-posed, the compiler runs it
ill        both refuse, or the raw equations are singular near random points
differs    numbers differ: from equations or reference, or between variants
crash      an exception that is not a diagnostic
========== ========================================================================
"""

from __future__ import annotations

import random
import re
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from dense_dae import IllPosed, NoSolution, Reference, Trajectory
from dense_pencil import is_singular
from equation_check import LEAST, Checked, check_columns
from flat_expressions import Var, variables
from observed_variables import with_all_observed
from program_draw import COUPLED, draw_program
from program_ends import cut_before, vanishing
from program_runs import (
    ACCOUNTS,
    CLOSE,
    Columns,
    Refused,
    difference,
    first_difference,
    first_row,
    run_text,
    scales_of,
    scales_of_columns,
)
from program_text import write
from program_tree import Program
from program_variants import VARIANTS
from raw_equations import Raw, raw_equations
from raw_instances import Unconnected
from sizes_of_values import sized

DEFAULT_RTOL = 1e-6
PROMISED = 30 * DEFAULT_RTOL  # of the size of a column, the most that a run with defaults may err
PROMISED_AT_ROOTS = 30 * DEFAULT_RTOL**0.5  # of the flow of a throttle whose effort is nearly zero
STILL = 1e-18  # J: a program whose energies change by less is at rest
AT_REST = 1e-2  # in SI: what rounding makes of the effort of a throttle at rest
ROWS = 200  # of a table whose rates are integrated
RESIDUAL = 1e-7  # of the size of a row
RATE = 1e-5  # of the change of a state
START = 1e-9
VARYING = ("BG502", "BG508", "BG512", "BG513", "BG522", "BG523")  # where a modulus may vanish
VANISHING = ("cos(", "root")  # in moduli that are drawn: the others keep their sign
LAST = re.compile(r"finds no solution at t = (\S+)$")  # of the reference
SAME_END = 0.01  # of the time at which a run ends
MISSED_AT_START = 1e-4  # of the terms of a row


@dataclass(frozen=True)
class Outcome:
    seed: int
    kind: str
    about: str
    seconds: float = 0.0

    def row(self) -> str:
        return f"{self.seed}\t{self.kind}\t{self.about}\t{self.seconds:.2f}"


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
    except (IllPosed, NoSolution, Unconnected, np.linalg.LinAlgError):
        return draw_program(seed, initials=False)
    return program


def check_seed(seed: int, *, variants: int = 2) -> Outcome:
    """The outcome of a seed by the reference, and the processor time that it took."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        kind, about = by_reference(program_of(seed), Path(folder), variants)
    return Outcome(seed, kind, about, time.process_time() - began)


def check_equations(seed: int, *, variants: int = 0) -> Outcome:
    """The outcome of a seed by its equations, and the processor time that it took.

    A program that is refused for its initial values, or that the reference finds ill-posed for
    them, is checked without them too.
    """
    began = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        program, place = draw_program(seed), Path(folder)
        kind, about = by_equations(program, place, variants)
        if about.startswith("BG516") or (kind == "ill" and "initial values" in about):
            if kind == "refused":
                return Outcome(seed, kind, about, time.process_time() - began)
            bare = draw_program(seed, initials=False)
            kind, about = by_equations(bare, place, variants)
            about = f"{about} (without initial values)"
    return Outcome(seed, kind, about, time.process_time() - began)


# --- by equations -----------------------------------------------------------------------------


def by_equations(program: Program, place: Path, variants: int) -> tuple[str, str]:
    """Kind and detail of a program's outcome by its raw equations."""
    try:
        program = with_all_observed(program).with_scene(rows=ROWS)
        raw = raw_equations(program)
    except Unconnected as err:
        return _unconnected(program, place, str(err))
    try:
        base = run_text(write(program), place)
    except Refused as err:
        return _ended(program, place, err) or _judged(program, str(err))
    except Exception as err:
        return "crash", f"{type(err).__name__}: {err}"[:100]
    found = check_columns(raw, base, float(program.scene.duration))
    kind, about = _satisfied(found)
    if kind == "differs" and found.residual <= RESIDUAL and found.start <= START:
        kind, about = _satisfied_by_more_rows(program, raw, place) or (kind, about)
    if kind == "differs" and _rests(base, found):
        return "rest", f"but for rounding: {about}"
    if kind == "differs":
        kind, about = _confirmed_by_equations(program, raw, place, about)
    if kind != "agrees":
        return kind, about
    tried = _variants(program, place, scales_of_columns(base), base, variants)
    if tried is not None:
        rounded = tried[0] == "differs" and "refused" not in tried[1] and _is_still(base)
        return ("rest", f"but for rounding: {tried[1]}") if rounded else tried
    coarse = _at_defaults(program, raw, place)
    if coarse is not None:
        return coarse
    if all(not column.any() for column in base.values()):
        return "rest", ""
    return "agrees", about


def _ended(program: Program, place: Path, refused: Refused) -> tuple[str, str] | None:
    """The outcome of a run that ends with a status where the equations end; else None."""
    if not refused.end:
        return None
    short = cut_before(with_all_observed(program).with_scene(rows=ROWS), refused.end)
    kind, _ = by_equations(short, place, 0)
    if kind not in ("agrees", "loose"):
        return None
    raw = raw_equations(short)
    row = vanishing(raw, run_text(write(short), place), refused.end)
    at = f"{refused} at t = {refused.end:.4g}"
    for method, most in (("LSODA", 2.0), ("Radau", 6.0)):
        try:
            reference_of(program.with_scene(rows=20), rtol=1e-6, method=method, most=most)
        except NoSolution as err:
            found = LAST.search(str(err))
            if row:
                return "ends", f"{at}: a coefficient of {row} vanishes"
            if found is not None and abs(float(found[1]) / refused.end - 1) <= SAME_END:
                return "ends", f"{at}; {method}: {err}"[:120]
        except (IllPosed, np.linalg.LinAlgError):
            return ("ends", f"{at}: a coefficient of {row} vanishes") if row else None
        else:
            return None  # a solution passes this time
    return None


def _unconnected(program: Program, place: Path, about: str) -> tuple[str, str]:
    """The outcome of a program that reads the variable of a junction without bonds."""
    try:
        run_text(write(program), place)
    except Refused as err:
        return "ill", f"{err}; {about}"
    return "open", about


def _satisfied(found: Checked) -> tuple[str, str]:
    missed = []
    if not found.residual <= RESIDUAL:
        missed.append(f"row of {found.row} by {found.residual:.1e}")
    if not found.rate <= RATE:
        missed.append(f"rate of {found.state} by {found.rate:.1e}")
    if not found.start <= START:
        missed.append(f"start of {found.given} by {found.start:.1e}")
    if missed:
        return "differs", "; ".join(missed)
    left = f", {len(found.unknown)} not checked" if found.unknown else ""
    return "agrees", f"{found.checked} rows{left}"


def _satisfied_by_more_rows(program: Program, raw: Raw, place: Path) -> tuple[str, str] | None:
    """Return the outcome with ten times the rows if it is right, else None.

    Simpson's rule takes no notice of a motion that is as fast as the rows.
    """
    more = program.with_scene(rows=10 * ROWS)
    try:
        columns = run_text(write(more), place)
    except Refused:
        return None
    kind, about = _satisfied(check_columns(raw, columns, float(program.scene.duration)))
    return (kind, f"{about} at {10 * ROWS} points") if kind == "agrees" else None


def _confirmed_by_equations(program: Program, raw: Raw, place: Path, about: str) -> tuple[str, str]:
    """Return whether equations that a run misses are satisfied at tighter tolerances."""
    duration = float(program.scene.duration)
    try:
        tight = run_text(write(program), place, rtol=1e-12)
    except Refused:
        tight = None
    if tight is not None and _satisfied(check_columns(raw, tight, duration))[0] == "agrees":
        about = f"{about}; none at 1e-12"
    try:
        usual = run_text(write(program), place, rtol=DEFAULT_RTOL)
    except Refused as err:
        return "differs", f"{about}; with defaults {err}"
    found = check_columns(raw, usual, duration, floor=1.0)
    missed = max(found.residual, found.rate, found.start)
    promised = PROMISED
    if about.endswith("none at 1e-12") and "sqrt(abs(" in write(program):
        promised = PROMISED_AT_ROOTS
    return ("loose" if missed <= promised else "differs"), f"{about}; with defaults {missed:.1e}"


def _at_defaults(program: Program, raw: Raw, place: Path) -> tuple[str, str] | None:
    """The outcome where a run at the default tolerance errs by more than it promises, else None."""
    try:
        columns = run_text(write(program), place, rtol=DEFAULT_RTOL)
    except Refused as err:
        return "refused", f"with defaults {err}"
    found = check_columns(raw, columns, float(program.scene.duration), floor=1.0)
    missed = max(found.residual, found.rate, found.start)
    promised = PROMISED_AT_ROOTS if "sqrt(abs(" in write(program) else PROMISED
    if missed <= promised or _rests(columns, found):
        return None
    return "differs", f"with defaults {_satisfied(found)[1]}"


def _is_still(base: Columns) -> bool:
    """Return whether energies stay as they are, but for rounding."""
    return all(np.abs(base[name]).max() <= STILL for name in ACCOUNTS)


def _rests(base: Columns, found: Checked) -> bool:
    """Return whether nothing moves, and rows are missed by what a root makes of rounding."""
    return _is_still(base) and found.residual * LEAST <= AT_REST and found.start <= START


def _judged(program: Program, codes: str) -> tuple[str, str]:
    """Return whether a program that the compiler refuses has a solution."""
    raw = raw_equations(program)
    try:
        if codes == "BG516":  # initial values contradict each other
            _start_row_by_row(raw)
        elif is_singular(raw):
            return "ill", f"{codes}; no single solution near random points"
        else:
            reference_of(program.with_scene(rows=20), most=2.0, rtol=1e-6)
    except IllPosed as err:
        return "ill", f"{codes}; {err}"[:120]
    except (NoSolution, np.linalg.LinAlgError) as err:
        kind = "modulus" if _refused(program, codes) == "modulus" else "reference"
        return kind, f"{codes}; {err}"[:120]
    return _refused(program, codes), codes


def _refused(program: Program, codes: str) -> str:
    """The kind of a refusal of a program that has a solution, or may have one."""
    moduli = [line for line in write(program).splitlines() if "MTF" in line or "MGY" in line]
    drawn_so = program.seed < COUPLED
    vanishes = drawn_so and any(word in line for line in moduli for word in VANISHING)
    return "modulus" if codes in VARYING and vanishes else "refused"


def _start_row_by_row(raw: Raw) -> None:
    """Raise IllPosed if a raw equation is missed at the start that the reference finds.

    The reference combines rows of different units, and misses contradictions of small flows.
    """
    reference = Reference(raw)
    x = reference.start()
    z = reference.zx @ x + reference.z0 + (reference.n @ reference._w if reference.m else 0.0)
    known = {Var(kind, k): v for kind, values in (("x", x), ("z", z)) for k, v in enumerate(values)}
    values = {var: (np.array([v]), np.array([abs(v)])) for var, v in known.items()}
    for name, row in zip(raw.row_names, raw.rows, strict=True):
        if all(v in values for v in variables(row) if isinstance(v, Var)):
            missed, size = sized(row, values, np.zeros(1))
            if abs(missed[0]) > MISSED_AT_START * size[0]:
                raise IllPosed(f"initial values contradict each other at {name}")


# --- by the reference ---------------------------------------------------------------------------


def by_reference(
    program: Program, place: Path, variants: int, *, most: float = 2.0
) -> tuple[str, str]:
    """Kind and detail of a program's outcome; `most` seconds are given to the reference."""
    scales = scales_of(program)
    expected: Trajectory | None = None
    trouble = ""
    try:
        expected = reference_of(program, most=most)
    except (IllPosed, Unconnected) as err:
        trouble = f"ill-posed: {err}"
    except (NoSolution, np.linalg.LinAlgError) as err:
        trouble = f"no solution: {err}"
    try:
        base = run_text(write(program), place)
    except Refused as err:
        if expected is not None:
            return _refused(program, str(err)), str(err)
        ended = _ended(program, place, err)
        return ended or ("ill" if trouble.startswith("ill") else "reference", f"{err}; {trouble}")
    except Exception as err:
        return "crash", f"{type(err).__name__}: {err}"[:100]
    if expected is not None:
        error, where = difference(expected.columns, base, scales, first=first_row(program))
        if not error <= CLOSE:
            return _confirmed(program, place, scales, where)
    if expected is None:
        kind, about = by_equations(program, place, variants)
        if kind not in ("agrees", "rest"):
            return kind, about
        return ("open" if trouble.startswith("ill") else kind), f"{about}; {trouble[:80]}"
    return _variants(program, place, scales, base, variants) or ("agrees", "")


def _confirmed(
    program: Program, place: Path, scales: Mapping[str, float], where: str
) -> tuple[str, str]:
    """Return whether a difference stays at tighter tolerances, else its size with defaults."""
    first = first_row(program)
    try:
        tight = reference_of(program, rtol=1e-11, most=20.0)
        base = run_text(write(program), place, rtol=1e-11)
        usual = run_text(write(program), place, rtol=DEFAULT_RTOL)
    except (IllPosed, NoSolution, Refused) as err:
        return "differs", f"{where}; unconfirmed: {err}"
    error, where = difference(tight.columns, base, scales, first=first)
    if not error <= CLOSE:
        if first_difference(tight.columns, base, scales, CLOSE) <= 1:
            kind, _ = by_equations(program, place, 0)
            if kind == "agrees":
                return "agrees", f"from another start: {where} by {error:.1e}"
        return "differs", f"{where} by {error:.1e}"
    error, where = difference(tight.columns, usual, scales, first=first)
    return ("loose" if error <= PROMISED else "differs"), f"{where} by {error:.1e} with defaults"


# --- variants -----------------------------------------------------------------------------------


def _variants(
    program: Program, place: Path, scales: Mapping[str, float], base: Columns, count: int
) -> tuple[str, str] | None:
    """Describe the first fault of some variants; None without a fault."""
    for name in random.Random(program.seed).sample(sorted(VARIANTS), count):
        try:
            other = VARIANTS[name](program, place, program.seed)
        except Refused as err:
            return "differs", f"{name}: refused {err}"
        except Exception as err:
            return "crash", f"{name}: {type(err).__name__}: {err}"[:100]
        error, where = difference(base, other, scales)
        if not error <= CLOSE:
            return "differs", f"{name}: {where} by {error:.1e}"
    return None
