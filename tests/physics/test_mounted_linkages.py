"""Planar linkages on mounts in general directions, closed by the rigid joints of a `Weld`."""

import numpy as np
import pytest
from model_files import model_text
from mounted_linkages import BASE_MASS, MASSES, mounted_linkage
from refusals import refusal

import bgc
from bgc.driver import compile_scene
from bgc.options import Options

GRAVITY = 9.81
# A quarter turn and back at the second pin.
ON_A_MOUNT = model_text("mounted_linkages_on_a_mount")


@pytest.mark.parametrize(("seed", "places"), [(3, 4), (102, 3)])
def test_a_slider_crank_on_a_free_body_keeps_its_loop_and_falls(seed, places, tmp_path):
    """No equation around the loop has a constant coefficient but those at its last joint.

    That joint moves nothing by itself, so that its rate has to follow from the others (BG502
    before). With mounts at three joints, rows in the axes of the world became dependent in some
    position of the body (BG735 before, at 0.38 s).
    """
    linkage = mounted_linkage(seed, "slider_crank", "general", "body", places)
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


def equations_of(source, tmp_path, scene="linkage"):
    path = tmp_path / "linkage.bg"
    path.write_text(source)
    return compile_scene(path, Options(scene), until="equations").equations


def test_mounts_in_seven_digits_leave_no_row_and_no_mass_over(tmp_path):
    """Refused before: at the start, where redundant conditions are off by 1e-7 (BG526)."""
    program = equations_of(mounted_linkage(3, "slider_crank", "general", digits=7).source, tmp_path)
    momenta = len(program.closures.impulses)
    assert momenta - program.closures.kept == 1, "one motion is left"
    assert program.closures.held == 3, "of four coordinates"
    assert [w.code for w in program.warnings] == ["BG529"]


def test_what_rounding_leaves_of_a_coefficient_is_no_divisor(tmp_path):
    """1e-16 divided by gave entries of N of 4e16, and ended with an AssertionError."""
    program = equations_of(
        mounted_linkage(100, "triangle", "rational", "driven", 1).source, tmp_path
    )
    assert len(program.closures.impulses) == program.closures.kept, "the crank moves all"
    (chain,) = program.closures.chains
    assert chain.names == ("weld", "pin1", "pin2"), "the parts that close it and that it moves"


@pytest.mark.parametrize(
    ("before", "after", "body"),
    [("1.571", "-90 deg", "`rod.body`"), ("90 deg", "-1.5706", "`piston.body`")],
)
def test_mounts_that_contradict_each_other_are_named(before, after, body, tmp_path):
    """The axes are 2e-4 rad from parallel, which a Weld cannot close."""
    source = ON_A_MOUNT.replace("TURN", before).replace("-90 deg", after)
    diagnostic = refusal(equations_of, source, tmp_path, None)
    assert diagnostic.code == "BG550"
    assert body in diagnostic.note
    misfit = float(diagnostic.message.rpartition(" ")[2])
    assert 5e-5 < abs(misfit) < 3e-4
