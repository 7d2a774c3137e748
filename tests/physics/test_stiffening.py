"""Joints on springs tend to rigid ones in proportion to their compliance."""

import numpy as np

STIFFNESSES = np.logspace(6, 10, 5)


def lengths(columns):
    """The largest length of a vector in the rows."""
    return np.linalg.norm(columns, axis=1).max()


def test_the_deviation_of_the_tip_falls_as_one_over_the_stiffness(load):
    """From rest, each spring loaded with what the rigid joint has to bear: nothing rings.

    Where the tip is, and how far it has moved since the start, which leaves out the sag.
    """
    rigid = load("stiffening", "rigid")
    forces = {k: -v for k, v in rigid.observe().items() if k.startswith("at_")}
    exact = rigid.simulate()["tip"]
    assert lengths(exact - exact[0]) > 4, "it has to move"

    compliant = load("stiffening", "compliant")
    place, path = [], []
    for stiffness in STIFFNESSES:
        tip = compliant.simulate(parameters={"stiffness": stiffness} | forces)["tip"]
        place.append(lengths(tip - exact))
        path.append(lengths((tip - tip[0]) - (exact - exact[0])))
    for deviations in (place, path):
        slopes = np.diff(np.log10(deviations))
        np.testing.assert_allclose(slopes, -1, atol=0.002)
    assert place[-1] < 1e-4
