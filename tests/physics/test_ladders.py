"""Coarser levels of library parts agree with the fine ones in what they are calibrated by."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bgc

FLEXIBLE = Path(__file__).parents[1] / "models" / "flexible.bg"
CLAMPED = 1.87510406871196**2


def at_end(text: str, folder: Path, **options: object) -> dict[str, float]:
    path = folder / "levels.bg"
    path.write_text(text)
    result = bgc.compile(path, **options).simulate(error=False, rtol=1e-8)
    return {name: float(np.ravel(result[name][-1])[-1]) for name in result}


@pytest.mark.parametrize(("elements", "bound"), [(4, 3e-3), (2, 1.1e-2), (1, 6e-2)])
def test_beams_of_fewer_elements_keep_deflection_and_first_frequency(elements, bound):
    """Under a force at the tip all bend alike; one element is 5 % off in its frequency."""
    model = bgc.compile(FLEXIBLE, "clamped", parameters={"beam.n": elements})
    fine = bgc.compile(FLEXIBLE, "clamped")
    sag, exact = (m.simulate(error=False)["beam.deflection"][0] for m in (model, fine))
    np.testing.assert_allclose(sag[1:], exact[1:], rtol=1e-4)
    values = model.eigenvalues()
    first = np.sort(np.abs(values[values.imag > 1e-3]))[0]
    euler = CLAMPED * np.sqrt(210e9 * 0.12**2 / 12 / 7850.0) / 10.0**2
    assert first == pytest.approx(euler, rel=bound)


def test_a_beam_without_elements_is_rigid():
    rigid = bgc.compile(FLEXIBLE, "clamped", parameters={"beam.n": 0})
    assert len(rigid.states) == 0
    assert np.all(rigid.simulate(error=False)["beam.deflection"] == 0)


DRIVE = """
import hydraulics.drive;
model Turntable {
  drive : Drive(command = 0.3) = HydraulicDrive(displacement = 0.1, valve_drop = 8 bar);
  shaft : J1; wheel : I(1e5); shaft -> wheel; shaft -> drive;
}
scene turning of Turntable { observe wheel.f as rate; run 30 s; }
"""


def test_a_stiff_drive_has_the_steady_rate_of_a_hydraulic_one(tmp_path):
    fine = at_end(DRIVE, tmp_path)["rate"]
    stiff = at_end(DRIVE, tmp_path, uses={"drive": "StiffHydraulicDrive(..)"})["rate"]
    assert fine == pytest.approx(0.3 * 4e-3 * np.sqrt(300 / 2 / 8) / 0.1, rel=1e-4)
    assert stiff == pytest.approx(fine, rel=1e-4)


LINE = """
import hydraulics.lines;
import hydraulics.restrictions;
import hydraulics.volumes;
model Flow {
  supply : Reservoir(pressure = 20 bar); sump : Tank; inlet : Throttle; outlet : Throttle;
  line : HydraulicLine = LumpedLine[4](length = 30 m, diameter = 12 mm, pressure0 = 10 bar);
  meter : J1;
  supply -> inlet -> line -> meter -> outlet -> sump;
}
scene flowing of Flow { observe meter.f as flow; run 5 s; }
"""


def test_lines_of_oil_have_one_steady_flow(tmp_path):
    fine = at_end(LINE, tmp_path)["flow"]
    for line in ("LumpedLine[1](..)", "InertLine(..)", "ShortLine(..)"):
        assert at_end(LINE, tmp_path, uses={"line": line})["flow"] == pytest.approx(fine, rel=1e-4)


HUNG = """
import rope.rope;
import mechanics.body;
import mechanics.joints;
model Hung {
  /// Rope is wound in.
  ground : Ground; block : J1; hook : J1;
  swing : Free(position0 = [0.5 m, 0 m, -sqrt(99.75) * (1 m)]);
  load : HeavyBody(mass = 2 t, inertia = eye(3)*(100 kg*m^2));
  rope : Rope(paid0 = 10 m, stiffness = 1e9 N, loss = 0.1 s);
  winch : VelocitySource(velocity = -0.04 m/s^2 * time);
  ground -> block -> swing -> hook -> load;
  block -> rope.a; hook -> rope.b; winch -> rope.pay;
}
scene hung of Hung { observe hook.r as place, rope.tension, rope.distance; run 5 s; }
"""


def test_a_rope_that_does_not_stretch_swings_like_a_stiff_one(tmp_path):
    """A load of 20 kN stretches the stiff rope by 0.2 mm."""
    fine = at_end(HUNG, tmp_path)
    rigid = at_end(HUNG, tmp_path, parameters={"rope.stretches": 0})
    assert rigid["rope.distance"] == pytest.approx(9.5, abs=1e-7)
    assert rigid["place[3]"] == pytest.approx(fine["place[3]"], abs=1e-3)
    assert rigid["place[1]"] == pytest.approx(fine["place[1]"], abs=1e-3)
    assert rigid["rope.tension"] == pytest.approx(fine["rope.tension"], rel=2e-2)


SEA = """
import marine.waves;
model Buoy[n = 40] {
  sea : Sea[n] = Jonswap[n, 40](seed = 3);
  output a[n] = sea.amplitude; output w[n] = sea.frequency; output p[n] = sea.phase;
}
scene whole of Buoy { observe a, w, p; run 1 s; }
scene few of Buoy[10] { observe a, w, p; run 1 s; }
"""


def test_a_sea_of_fewer_bands_has_the_long_waves_of_the_whole_one(tmp_path):
    path = tmp_path / "sea.bg"
    path.write_text(SEA)
    whole, few = (bgc.compile(path, scene).simulate(error=False) for scene in ("whole", "few"))
    for name in "awp":
        np.testing.assert_array_equal(few[name][0], whole[name][0, :10])
