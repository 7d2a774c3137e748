"""Whole programs drawn at random, against the dense reference and written in other ways.

README.md has the classes of programs and the counts of longer campaigns.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from program_check import CLOSE, checked, difference, program_of, run_text, scales_of
from program_draw import draw_program
from program_text import Style, write

pytestmark = pytest.mark.slow
SEEDS = (2, 4, 5, 6, 7, 10, 17, 20, 22, 29, 32, 33, 34, 41, 43, 46, 48, 51, 52, 53, 54, 55, 62)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_program_agrees_with_the_reference_and_with_its_variants(
    seed: int, tmp_path: Path
) -> None:
    kind, about = checked(program_of(seed), tmp_path, variants=2, most=60.0)
    assert (kind, about) == ("agrees", about)


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
