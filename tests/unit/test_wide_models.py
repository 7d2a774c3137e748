"""Memory of models with very many states: nothing dense is reserved."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable
from ctypes import CDLL

import numpy as np
import pytest

_RUN = """
import ctypes, resource, sys
resource.setrlimit(resource.RLIMIT_AS, (10**9, 10**9))
library = ctypes.CDLL(sys.argv[1])
library.bgc_get_model.restype = library.bgc_new.restype = ctypes.c_void_p
model = ctypes.c_void_p(library.bgc_get_model())
instance = ctypes.c_void_p(library.bgc_new(model))
assert instance, "no memory"
assert library.bgc_reset(model, instance, ctypes.c_double(0)) == 0
times, rows, done = (ctypes.c_double * 2)(0, 1), (ctypes.c_double * 8)(), ctypes.c_size_t()
assert library.bgc_run(model, instance, times, ctypes.c_size_t(2), rows, ctypes.byref(done)) == 0
print(*rows)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits the memory of a process")
def test_fifty_thousand_states_run_in_a_gigabyte(c_library: Callable[[str], CDLL]) -> None:
    """A dense matrix of them would take 20 GB. The error is of the root mean square of all states,
    of which few are above zero, so theirs may be 200 times the tolerance of 1e-6."""
    command = [sys.executable, "-c", _RUN, c_library("wide")._name]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = np.reshape([float(each) for each in done.stdout.split()], (2, 4))
    expected = [math.exp(-1) / math.factorial(k) for k in range(4)]
    np.testing.assert_allclose(rows, [[1, 0, 0, 0], expected], atol=1e-3)
