"""Pointers near what a part of a function uses."""

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from bgc.emission.windows import best_offset, pointer_argument, shift_indices

REACH = range(-16, 16)


def test_near_accesses_keep_their_indices():
    lines = ["w[3] = x[15] * h[0];"]
    assert shift_indices(lines, ("w", "x", "h"), 16) == (lines, {})


def test_far_accesses_count_from_the_place():
    lines, offsets = shift_indices(
        ["jac[400] = x[2] * w[17];", "jac[431] = -jac[400];"], ("jac", "x"), 16
    )
    assert offsets == {"jac": 416}
    assert lines == ["jac[-16] = x[2] * w[17];", "jac[15] = -jac[-16];"]
    assert pointer_argument("jac", offsets) == "jac + 416" and pointer_argument("x", offsets) == "x"


def test_arrays_that_loops_run_over_stay_as_they_are():
    lines = ["w[90] = x[80];", "for (int k = 60; k < 70; k++) w[k] = h[k + 3];"]
    moved, offsets = shift_indices(lines, ("w", "x", "h"), 16)
    assert offsets == {"x": 80}
    assert moved == ["w[90] = x[0];", lines[1]]


@given(st.lists(st.integers(0, 200), max_size=40))
def test_no_place_has_more_accesses_near(indices):
    def near(offset):
        return sum(index - offset in REACH for index in indices)

    offset = best_offset(Counter(indices), 16)
    assert 0 <= offset <= max(indices, default=0)
    assert near(offset) == max(near(other) for other in range(201))
