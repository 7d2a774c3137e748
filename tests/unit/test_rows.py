import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from refusals import refusals

from bgc.runtime.running.rows import row_times


def test_rows_at_multiples_of_the_interval():
    assert row_times(1.0, 0.25, None, 1).tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]


def test_the_last_row_is_at_the_end_time_however_the_interval_divides_it():
    assert row_times(1.0, 0.4, None, 1).tolist() == [0.0, 0.4, 0.8, 1.0]
    assert row_times(0.3, 0.1, None, 1).tolist() == [0.0, 0.1, 0.2, 0.3]
    assert row_times(0.1, 1.0, None, 1).tolist() == [0.0, 0.1]


def test_a_fixed_step_without_an_interval_gives_a_row_each_step():
    assert len(row_times(60.0, None, 1e-3, 1)) == 60_001


def test_otherwise_a_thousand_equal_intervals():
    times = row_times(10e-3, None, None, 1)
    assert len(times) == 1001
    assert np.ptp(np.diff(times)) < 1e-17


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_times_rise_from_zero_to_the_end(duration, every):
    times = row_times(duration, every, None, 1)
    assert (times[0], times[-1]) == (0.0, duration)
    assert np.all(np.diff(times) > 0)
    assert np.all(np.diff(times) <= every * (1 + 1e-8))


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf")])
def test_times_that_make_no_sense(bad):
    for arguments in ((bad, None, None), (1.0, bad, None), (1.0, None, bad)):
        assert refusals(row_times, *arguments, columns=1)[0].code == "BG066"


def test_more_rows_than_memory_holds():
    assert refusals(row_times, 1e9, 1e-9, None, 10)[0].code == "BG068"
