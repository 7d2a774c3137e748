"""Planar linkages on mounts in general directions, closed by the rigid joints of a `Weld`."""

import numpy as np
from mounted_linkages import BASE_MASS, MASSES, mounted_linkage

import bgc

GRAVITY = 9.81


def test_a_slider_crank_on_a_free_body_keeps_its_loop_and_falls(tmp_path):
    """No equation around the loop has a constant coefficient but those at its last joint.

    That joint moves nothing by itself, so that its rate has to follow from the others (BG502
    before).
    """
    linkage = mounted_linkage(3, "slider_crank", "general", "body")
    path = tmp_path / "linkage.bg"
    path.write_text(linkage.source)
    result = bgc.compile(path, scene="linkage", preview=True).simulate()
    q, v = (np.column_stack([result[f"{name}{k}"] for k in range(4)]) for name in "qv")
    assert linkage.misfit(q, v) < 1e-9
    assert np.abs(result["gap"]).max() < 1e-12
    assert np.ptp(q[:, 0]) > 0.3, "it has to move"
    supplied = np.ptp(result["energy.stored"])
    assert supplied > 1 and np.abs(result["energy.residual"]).max() < 1e-8 * supplied

    # The weight of the bars alone moves the centre of mass.
    mass = BASE_MASS + sum(MASSES)
    bars = sum(m * result[f"c{k}"] for k, m in enumerate(MASSES))
    centre = (bars + BASE_MASS * result["r"]) / mass
    fall = np.outer(result.time**2 / 2, [0, 0, -GRAVITY * sum(MASSES) / mass])
    np.testing.assert_allclose(centre - centre[0], fall, atol=1e-9)
