"""The compliant lock: its stiffness and damping on a body of the reference mass."""

import numpy as np
import pytest


@pytest.mark.parametrize("zeta", [0.3, 0.8])
def test_a_body_of_the_reference_mass_is_damped_by_the_ratio(load, zeta):
    model = load("lock_damping", "rest")
    model.parameters["zeta"] = zeta
    modes = model.eigenvalues()
    modes = modes[modes.imag > 0]
    shift, turn = np.sqrt(8e6 / 200), np.sqrt(5e5 / 50)
    np.testing.assert_allclose(np.sort(np.abs(modes)), np.sort([shift] * 3 + [turn] * 3), rtol=1e-6)
    np.testing.assert_allclose(-modes.real / np.abs(modes), zeta, rtol=1e-6)
