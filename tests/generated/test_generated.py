"""Whole programs drawn at random, against the dense reference and written in other ways.

README.md has the classes of programs and the counts of longer campaigns.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from curves import OPERATORS, curve
from dense_pencil import is_singular
from equation_check import check_columns
from observed_variables import with_all_observed
from program_check import (
    DEFAULT_RTOL,
    PROMISED,
    RATE,
    RESIDUAL,
    ROWS,
    START,
    by_equations,
    by_reference,
    check_equations,
    program_of,
)
from program_draw import COUPLED, TIMED, draw_program
from program_ends import cut_before, vanishing
from program_loops import loop_differences
from program_modes import slope_errors
from program_runs import CLOSE, Refused, difference, run_text, scales_of
from program_shrink import shrunk, signature
from program_text import Style, write
from program_tree import For, Model, Part, Program
from program_variants import slice_and_whole
from raw_equations import raw_equations

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.options import Options

pytestmark = pytest.mark.slow
SAMPLED = 200039  # a seed with a sampled part and a switch at an instant of it
SEEDS = (2, 4, 5, 6, 7, 10, 17, 20, 22, 29, 32, 33, 34, 41, 43, 46, 48, 51, 52, 53, 54, 55, 62)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_program_agrees_with_the_reference_and_with_its_variants(
    seed: int, tmp_path: Path
) -> None:
    kind, about = by_reference(program_of(seed), tmp_path, variants=2, most=60.0)
    assert (kind, about) == ("agrees", about)


@pytest.mark.parametrize(
    "seed", [1022, 1028, 1065, 1155, 1137, 1877, 1956, 6035, 6681, 10251, 101211, 102067]
)
def test_a_run_satisfies_all_equations(seed: int, tmp_path: Path) -> None:
    kind, about = by_equations(draw_program(seed), tmp_path, variants=0)
    assert (kind, about) == ("agrees", about)


@pytest.mark.parametrize("seed", [101399, 102252, 102488, 103368, 103570, 103700, 103833, 103924])
def test_a_program_that_was_refused_has_equations(seed: int, tmp_path: Path) -> None:
    """Gyrators that turn, moduli that only together keep off zero, wide laws that start jointly."""
    path = tmp_path / "program.bg"
    path.write_text(write(draw_program(seed)), encoding="utf-8")
    compile_scene(path, Options(), until="equations")


def test_a_choice_with_a_motion_of_nothing_is_refused(tmp_path: Path) -> None:
    """Rows taken in sequence leave a motion there that powers no element."""
    path = tmp_path / "program.bg"
    path.write_text(write(draw_program(104404)), encoding="utf-8")
    with pytest.raises(BgError, match="BG512"):
        compile_scene(path, Options(), until="equations")


@pytest.mark.parametrize("seed", [101115, 103043])
def test_rates_are_not_divided_by_a_pivot_that_may_vanish(seed: int, tmp_path: Path) -> None:
    """The rates of momenta that a nonlinear law hides, where their equations stay regular."""
    path = tmp_path / "program.bg"
    path.write_text(write(draw_program(seed)), encoding="utf-8")
    equations = compile_scene(path, Options(), until="equations").equations
    assert not equations.divisors


def test_a_run_with_defaults_leaves_the_root_that_it_starts_at(tmp_path: Path) -> None:
    """At the start a throttle without flow has an infinite slope, and an event follows at once.

    The rates of all states, integrated, are their changes; the error of a row is that of defaults.
    """
    drawn = draw_program(30433, initials=False)
    program = with_all_observed(drawn).with_scene(rows=ROWS)
    columns = run_text(write(program), tmp_path, rtol=DEFAULT_RTOL)
    found = check_columns(raw_equations(program), columns, float(program.scene.duration))
    assert found.residual <= RESIDUAL and found.rate <= PROMISED, found


@pytest.mark.parametrize("seed", [20003, 20011])
def test_slopes_are_those_of_the_rates(seed: int, tmp_path: Path) -> None:
    path = tmp_path / "program.bg"
    path.write_text(write(program_of(seed)), encoding="utf-8")
    errors = slope_errors(bgc.compile(path, preview=True))
    assert errors and max(errors.values()) < 1e-5


def test_a_run_ends_where_a_coefficient_vanishes(tmp_path: Path) -> None:
    """The modulus of `motor2` is a cosine; at nine tenths of the time it is not zero."""
    kind, about = by_equations(draw_program(2274), tmp_path, variants=0)
    assert (kind, about) == ("ends", "BG701 at t = 1.059: a coefficient of motor2 vanishes")
    early = 0.9 * 1.05899694
    short = cut_before(with_all_observed(draw_program(2274)).with_scene(rows=ROWS), early)
    assert vanishing(raw_equations(short), run_text(write(short), tmp_path), early) == ""


def test_a_run_ends_where_charges_of_one_effort_have_a_fold(tmp_path: Path) -> None:
    """The sum of two stiffnesses falls to zero as the root of the time left: its square as that."""
    program = with_all_observed(draw_program(2232)).with_scene(rows=ROWS)
    with pytest.raises(Refused, match="BG725") as ended:
        run_text(write(program), tmp_path)
    end = ended.value.end
    assert end is not None
    short = cut_before(program, end)
    kind, about = by_equations(short, tmp_path, variants=0)
    assert (kind, about) == ("agrees", about)
    columns = run_text(write(short), tmp_path)
    names = dict(re.findall(r"(\S+) as (v\d+)", write(short)))
    q, bistable = (columns[names[f"spring{k}.q"]] for k in (2, 3))
    sums = 14e4 / 0.0012 * np.cosh(q / 0.0012) + 11e7 + 25e4 / 2 / 39e-5 * np.cos(bistable / 39e-5)
    times = np.linspace(0, float(short.scene.duration), len(q))
    slope, at_start = np.polyfit(times[-3:], sums[-3:] ** 2, 1)
    assert -at_start / slope == pytest.approx(end, rel=1e-4)


def test_a_program_in_the_loop_has_the_bits_of_a_plain_run(tmp_path: Path) -> None:
    """A trace moves the first driven input of the program."""
    assert "drive given" in write(program_of(20003))
    assert loop_differences(program_of(20003), tmp_path) == []


def test_a_slice_gives_the_numbers_of_the_whole_program(tmp_path: Path) -> None:
    program = program_of(20003)
    alone, among = slice_and_whole(program, tmp_path, 20003)
    error, where = difference(alone, among, scales_of(program))
    assert error <= CLOSE, where
    assert all(column.any() for column in alone.values())


def test_a_program_that_reads_what_has_no_bond_is_refused(tmp_path: Path) -> None:
    kind, about = by_equations(draw_program(1773), tmp_path, variants=0)
    assert (kind, about[:5]) == ("ill", "BG407")


@pytest.mark.parametrize(("seed", "singular"), [(2812, True), (4113, True), (8869, False)])
def test_singular_pencils_are_found(seed: int, singular: bool) -> None:
    """A flow that circulates, and two sources of one flow; beside a right program."""
    assert is_singular(raw_equations(draw_program(seed))) == singular


def test_an_inaccurate_solution_is_not_a_broken_power_balance(tmp_path: Path) -> None:
    """At the state of the audit a flow is of the size of sinh(70), whose error is a large power."""
    kind, _ = by_equations(draw_program(9241), tmp_path, variants=1)
    assert kind == "rest"


def test_a_wrong_column_misses_an_equation(tmp_path: Path) -> None:
    """Each column in turn is off by a part in 10,000 at one row, or a rate by a hundredth."""
    program = with_all_observed(program_of(44)).with_scene(rows=ROWS)
    raw, duration = raw_equations(program), float(program.scene.duration)
    columns = run_text(write(program), tmp_path)
    found = check_columns(raw, columns, duration)
    assert found.residual <= RESIDUAL and found.rate <= RATE and found.start <= START
    assert not found.unknown
    moving = [o.name for o in program.scene.observed if np.abs(columns[o.name]).max() > 1e-2]
    assert len(moving) >= 8
    for name in moving:
        wrong = columns[name].copy()
        wrong[int(np.abs(wrong).argmax())] *= 1 + 1e-4
        assert check_columns(raw, columns | {name: wrong}, duration).residual > RESIDUAL
    for name in ("energy.stored", "energy.supplied", "energy.dissipated"):
        wrong = columns[name] * 1.01
        assert check_columns(raw, columns | {name: wrong}, duration).rate > RATE


# The last ended with a ValueError: a vertex from which no path leads to a row of the kept flows.
@pytest.mark.parametrize("seed", [100002, 100004, 100005, 200053])
def test_a_program_with_coupled_parts_satisfies_all_equations(seed: int) -> None:
    found = check_equations(seed)
    assert (found.kind, found.about) == ("agrees", found.about)


def test_sampled_parts_and_switches_at_their_instants(tmp_path: Path) -> None:
    """By the reference, and by equations; a value held one row longer is seen."""
    program = program_of(SAMPLED)
    assert "sample " in write(program) and "if time <" in write(program)
    assert by_reference(program, tmp_path, variants=0, most=60.0)[0] == "agrees"
    program = with_all_observed(program).with_scene(rows=ROWS)
    raw, duration = raw_equations(program), float(program.scene.duration)
    columns = run_text(write(program), tmp_path)
    assert check_columns(raw, columns, duration).residual <= RESIDUAL
    missed = set()
    for name in [name for name, e, _ in raw.observed if e in raw.held]:
        late = np.concatenate([columns[name][:1], columns[name][:-1]])
        found = check_columns(raw, columns | {name: late}, duration)
        assert found.residual > RESIDUAL
        missed.add(found.row.split()[0])
    assert missed == {"held", "servo"}  # the state of the part, and its output in a source


@pytest.mark.parametrize("op", OPERATORS)
def test_curves_have_the_slopes_of_their_differences(op: str) -> None:
    xs, ys = (-2.0, -0.5, 1.0, 2.5), (3.0, -1.0, 0.5, 0.7)
    u = np.linspace(-3.02, 3.48, 40)
    value, slope = op.replace("slope", "interpolate"), op.replace("interpolate", "slope")
    expected = (curve(value, xs, ys, u + 1e-6) - curve(value, xs, ys, u - 1e-6)) / 2e-6
    np.testing.assert_allclose(curve(slope, xs, ys, u), expected, atol=1e-5)
    np.testing.assert_allclose(curve(value, xs, ys, np.array(xs)), ys, atol=1e-12)


FEATURES = {
    "a full matrix of six inertias": r"I\[6\]\(.*\[(\[.*\], ){5}\[.*\]\]",
    "a matrix of one column": r"MTF\[1, [2-6]\] \{ f2 = ",
    "a matrix of one row": r"M(TF\[[2-6], 1\] \{ f2|GY\[[2-6], 1\] \{ e2) = ",
    "a rotation by a state": r"MTF\[.* \* cos\(angle\d* / .*-\(.* \* sin\(angle|-.*sin\(angle",
    "a transformer turned by a flow": r"MTF.*(sin|cos|tanh|atan|log1p)\(\(?\w+\.f",
    "a gyrator turned by a flow": r"MGY.*(sin|cos|tanh|atan|log1p)\(\(?\w+\.f",
    "a modulus that reads a momentum": r"M(TF|GY).*\w+\.p(\[\d\])? / ",
    "a flow given to a wide body": r"I\[[2-6]\].*f0 = \[",
    "an array of models": r"row\d*\[i\] : (Strut|Line|Shaft|Link)",
}


TIMED_FEATURES = {
    "a table as a law": r"[CIR] .*\{ [ef] = interpolate\(",
    "a table as a modulus": r"M(TF|GY).*\* interpolate\(",
    "a sampled part": r"sample 0.\d s \{\n.*\n.*\n.*\n  \}",
    "a switch at an instant": r"MS[ef].*if time < \d.\d s then.*held",
}


@pytest.mark.parametrize("first", [COUPLED, TIMED])
@pytest.mark.parametrize("feature", [*FEATURES, *TIMED_FEATURES])
def test_seeds_of_coupled_parts_have_each_feature(feature: str, first: int) -> None:
    """One of forty programs or more has it; the network around it is drawn anew each time."""
    texts = [write(draw_program(seed)) for seed in range(first, first + 120)]
    found = sum(re.search((FEATURES | TIMED_FEATURES)[feature], text) is not None for text in texts)
    assert found >= 3 if feature in FEATURES or first == TIMED else found == 0


def test_models_of_coupled_parts_are_nested() -> None:
    programs = [draw_program(seed) for seed in range(100_000, 100_060)]
    assert sum(_depth(program, program.main) >= 3 for program in programs) >= 3


def _depth(program: Program, model: Model) -> int:
    """The number of models within each other, arrays counted in."""
    named = {m.name for m in program.models}
    loops = [s for f in model.statements if isinstance(f, For) for s in f.body]
    parts = [s for s in (*model.statements, *loops) if isinstance(s, Part) and s.type in named]
    return 1 + max((_depth(program, program.model(s.type)) for s in parts), default=0)


def test_a_shrunk_program_keeps_what_it_is_asked_for() -> None:
    def keeps(program: Program) -> bool:
        return "MGY" in write(program)

    found = next(p for p in map(draw_program, range(100_000, 100_100)) if keeps(p))
    small = shrunk(found, keeps)
    assert keeps(small)
    assert [s.type for m in small.models for s in m.statements if isinstance(s, Part)] == ["GY"]
    assert signature("refused", "BG512 with more") == "refused BG512"
    assert signature("differs", "start of body by 2e-3") == "differs start"


def test_a_seed_draws_the_same_program_each_time() -> None:
    assert draw_program(5) == draw_program(5)
    style = Style(units=True, shuffled=True, renamed=True, seed=5)
    assert write(draw_program(5), style) == write(draw_program(5), style)


def test_a_wrong_number_is_seen(tmp_path: Path) -> None:
    """A resistance of a program is changed by a thousandth; the comparison has to see it."""
    text = write(program_of(44))
    columns = run_text(text, tmp_path)
    changed = {name: column * 1.001 for name, column in columns.items()}
    error, _ = difference(columns, changed, scales_of(program_of(44)))
    assert error > CLOSE
    with_nan = {name: np.full_like(column, np.nan) for name, column in columns.items()}
    error, _ = difference(columns, with_nan, scales_of(program_of(44)))
    assert not error <= CLOSE
