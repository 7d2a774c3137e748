"""Types of arrays that the whole runtime shares."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
"""Real numbers in double precision."""

Complex: TypeAlias = NDArray[np.complex128]
"""Complex numbers in double precision."""

Mask: TypeAlias = NDArray[np.bool_]
"""Truth values, as an index of other arrays."""
