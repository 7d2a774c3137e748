"""`bgc import` of hydrodynamic data: conventions, sets of files, checks, and refusals."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.grammar.format import format_source
from bgc.grammar.source_files import read_source
from bgc.record_class import replace
from bgc.runtime.cli.app import application
from bgc.runtime.importing.hydrodynamics.account import Account, Given
from bgc.runtime.importing.hydrodynamics.checks import check
from bgc.runtime.importing.hydrodynamics.headings import around, covered
from bgc.runtime.importing.hydrodynamics.hulls import READERS, import_hull
from bgc.runtime.importing.hydrodynamics.record import (
    Hull,
    motions,
    moved,
    symmetrised,
    wave_numbers,
)

HULLS = Path(__file__).parents[1] / "models" / "hulls"
SEA = Given(density=1025.0)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(application, [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    shutil.copytree(HULLS, tmp_path / "hulls")
    monkeypatch.chdir(tmp_path / "hulls")
    return tmp_path / "hulls"


def read(name: str) -> Hull:
    path = HULLS / name
    return READERS[path.suffix](path, SEA, Account())


def codes(account: Account) -> list[str]:
    return [warning.code for warning in account.warnings]


def table(data: dict, part: str) -> np.ndarray:
    rows = data["response"][part].values()
    return np.array([np.array(row["re"]) + 1j * np.array(row["im"]) for row in rows])


@pytest.mark.parametrize("other", ["barge.3", "nemoh/ExcitationForce.tec"])
def test_three_formats_of_one_hull_give_the_same_ship(other):
    """Capytaine in complex numbers of exp(-i w t), WAMIT by periods, Nemoh by phases in radians."""
    one, two = (
        json.loads(import_hull(HULLS / name, SEA, "x.json").data) for name in ("barge.nc", other)
    )
    for key in ("mass", "damping", "frequency"):
        a, b = (np.array(data["radiation"][key]) for data in (one, two))
        np.testing.assert_allclose(a, b, atol=1e-5 * np.abs(a).max())
    a, b = (np.array(data["G"]) for data in (one, two))
    np.testing.assert_allclose(a, b, atol=1e-5 * np.abs(a).max())
    for a, b in zip(table(one, "force"), table(two, "force"), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-5 * np.abs(a).max())


def test_a_hull_is_written_checked_and_run(folder):
    """The user names one file; text and data are written beside each other, and never replaced."""
    done = run("import", "barge.nc")
    assert done.exit_code == 0, done.stderr
    assert "read: `inertia_matrix`" in done.stdout and "check: mass" in done.stdout
    assert "wrote barge.bg and barge.json" in done.stdout
    assert run("check", "--strict", "barge.bg").exit_code == 0
    source = read_source(Path("barge.bg"))
    assert format_source(source) == source.text
    assert run("import", "barge.nc").exit_code == 1
    Path("barge.bg").unlink()
    refused = run("import", "barge.nc")
    assert refused.exit_code == 1 and "barge.json" in refused.stderr
    assert run("import", "barge.nc", "--force").exit_code == 0
    assert run("import", "barge.nc", "-o", "-").exit_code == 2
    result = bgc.compile("barge.bg").simulate(error=False)
    assert 0.01 < np.ptp(result["deck"][:, 2]) < 3


def test_estimates_are_parameters_and_stated(folder):
    done = run("import", "barge.hst", "--density", 1025, "--length-scale", 1)
    assert done.exit_code == 0, done.stderr
    assert "radii of gyration" in done.stderr and "BG139" in done.stderr
    text = Path("barge.bg").read_text()
    assert "param mass : kg" in text and "param radii[3] : m" in text
    wide = bgc.compile("barge.bg", parameters={"vessel.radii[1]": 9.0}).simulate(error=False)
    usual = bgc.compile("barge.bg").simulate(error=False)
    assert np.ptp(wide["roll"]) != pytest.approx(np.ptp(usual["roll"]), rel=1e-2)
    mass = json.loads(Path("barge.json").read_text())["M_RB"][0][0]
    assert mass == pytest.approx(1.968e6, rel=0.06), "the displaced mass, from long waves"


def test_a_wave_from_a_side_without_data_is_refused(folder):
    hull = around(moved(read("barge.nc"), np.array([0.5, 0, 0])), Account())
    assert covered(hull) == ()
    some = replace(hull, heading=hull.heading[1:3], force=hull.force[:, 1:3])
    (arc,) = covered(some)
    assert np.degrees([arc.first, arc.width]) == pytest.approx([60, 60])
    apart = replace(hull, heading=hull.heading[[0, 3]], force=hull.force[:, [0, 3]])
    assert [arc.text for arc in covered(apart)] == ["0", "180"]
    lines = [line for line in Path("barge.3").read_text().splitlines() if "\t    0.000" in line]
    Path("barge.3").write_text("\n".join(lines) + "\n")
    assert run("import", "barge.3").exit_code == 0
    assert bgc.compile("barge.bg").simulate(error=False).time[-1] > 10
    other = Path("barge.bg").read_text().replace("heading = 0 deg", "heading = 90 deg")
    Path("barge.bg").write_text(other)
    refused = run("run", "barge.bg")
    assert refused.exit_code == 1 and "no waves of this direction" in refused.stderr


def test_symmetric_hulls_get_the_headings_of_their_image():
    """A hull that is symmetric to port has the same forces, mirrored: as it was solved for both."""
    whole = read("hemisphere.nc")
    whole = around(moved(whole, np.zeros(3)), Account())
    assert np.degrees(whole.heading) == pytest.approx([0, 45, 90, 135, 180, 225, 270, 315])
    assert covered(whole) == ()
    for k in range(8):  # a round hull: turned forces
        ahead = whole.force[:, 0]
        b = whole.heading[k]
        np.testing.assert_allclose(whole.force[:, k, 0], ahead[:, 0] * np.cos(b), rtol=1e-2, atol=1)
        np.testing.assert_allclose(whole.force[:, k, 1], ahead[:, 0] * np.sin(b), rtol=1e-2, atol=1)
    barge = around(moved(read("barge.nc"), np.array([0.5, 0, 0])), Account())
    assert len(barge.heading) == 6, "a barge about a point off its planes is not symmetric"


def test_moving_the_origin_keeps_the_motion():
    """The motion of one point of the hull on one wave, from data about two points."""
    hull = read("barge.nc")
    other = moved(hull, np.array([7.0, -2.0, 1.5]))
    here, there = (motions(h, h.mass, h.stiffness) for h in (hull, other))
    along = 6.5 * np.cos(hull.heading) - 2.0 * np.sin(hull.heading)
    along = along + 0.5 * np.cos(hull.heading)
    wave = np.exp(-1j * np.outer(hull.wave_number, along))
    heave = here[..., 2] - here[..., 4] * 6.5 + here[..., 3] * -2.0
    np.testing.assert_allclose(there[..., 2] * wave, heave, rtol=1e-9, atol=1e-12)
    back = moved(other, hull.origin)
    rate = np.exp(1j * np.outer(hull.wave_number, 0.5 * np.cos(hull.heading)))[..., None]
    np.testing.assert_allclose(back.force, hull.force * rate, rtol=1e-9, atol=1e-3)


def test_wave_numbers_satisfy_the_dispersion_relation():
    w = np.geomspace(1e-3, 20, 40)
    k = wave_numbers(w, 12.0, 9.81)
    np.testing.assert_allclose(9.81 * k * np.tanh(k * 12.0), w**2, rtol=1e-12)
    np.testing.assert_array_equal(wave_numbers(w, np.inf, 9.81), w**2 / 9.81)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda h: {"force": np.conj(h.force)}, "horizontal forces on long waves"),
        (lambda h: {"force": -h.force}, "heave force on long waves"),
        (lambda h: {"heading": -h.heading[::-1]}, "horizontal forces on long waves"),
        (lambda h: {"force": 1.3 * h.force}, "damping and exciting forces"),
        (lambda h: {"damping": 1.4 * h.damping}, "damping and exciting forces"),
        (lambda h: {"haskind": 1.2 * h.force}, "by Haskind and by diffraction"),
        (lambda h: {"motion": 1.2 * motions(h, h.mass, h.stiffness)}, "motions and those"),
        (lambda h: {"added_mass": np.triu(h.added_mass)}, "added mass and its transpose"),
    ],
)
def test_wrong_conventions_do_not_pass_the_checks(change, said):
    hull = around(moved(read("hemisphere.nc"), np.zeros(3)), Account())
    account = Account()
    check(hull, account)
    assert codes(account) == []
    check(replace(hull, **change(hull)), account)
    assert set(codes(account)) == {"BG552"}
    assert any(said in warning.message for warning in account.warnings)


def test_a_damping_that_supplies_energy_is_refused():
    hull = read("hemisphere.nc")
    with pytest.raises(BgError, match="wrong sign"):
        check(replace(hull, damping=-hull.damping), Account())
    with pytest.raises(BgError, match="kinetic energy"):
        check(replace(hull, mass=-2 * hull.mass), Account())


@pytest.mark.parametrize(
    ("names", "file", "code", "said"),
    [
        (["barge.1"], "barge.1", "BG137", "barge.hst is missing"),
        (["barge.1", "barge.hst"], "barge.1", "BG137", "exciting forces"),
        (["barge.3", "barge.hst"], "barge.3", "BG137", "barge.1 is missing"),
        (["nemoh/KH.dat"], "KH.dat", "BG137", "no Nemoh.cal"),
        (["nemoh/Nemoh.cal"], "Nemoh.cal", "BG137", "RadiationCoefficients.tec is missing"),
        (["make.py"], "make.py", "BG137", "unknown kind"),
        ([], "hull.nc", "BG001", "hull.nc"),
    ],
)
def test_what_is_missing_is_named(tmp_path, monkeypatch, names, file, code, said):
    for name in names:
        shutil.copy(HULLS / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    refused = run("import", file)
    assert refused.exit_code == 1 and code in refused.stderr and said in refused.stderr


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("barge.1", "    6\t    6\t", "    7\t    6\t", "no mode of a single rigid body"),
        ("barge.1", "1.506327e+02", "*********", "no row of 4 or 5 numbers"),
        ("barge.3", "3.490659e+00\t    0.000", "3.490659e+00\t    9.000", "has no row for"),
        ("barge.hst", "3     3 4.8", "3     3 -4.8", "no stiffness in heave"),
        ("barge.pot", "barge.gdf", "barge", "no XBODY"),
        ("nemoh/Nemoh.cal", "1        ! Number of bodies", "2 ! bodies", "2 bodies"),
        ("nemoh/Nemoh.cal", "1 0. 0. 1.", "1 0. 1. 1.", "are not surge, sway, heave"),
        ("nemoh/ExcitationForce.tec", "angle=0.0", "beta", "no heading"),
        ("nemoh/KH.dat", "0.000000E+00 ", "", "6 x 6"),
        ("nemoh/KH.dat", "0.000000E+00 ", "1e400 ", "6 x 6"),
        ("barge.hst", "3     3 4.8", "3     3 0.0 # 4.8", "no row of 3 numbers"),
    ],
)
def test_wrong_contents_are_refused_with_their_place(folder, file, old, new, said):
    text = Path(file).read_text()
    assert old in text
    Path(file).write_text(text.replace(old, new))
    refused = run("import", file, "-o", "x.bg")
    assert refused.exit_code == 1 and "BG138" in refused.stderr and said in refused.stderr


def test_damaged_and_incomplete_datasets_are_refused(folder):
    data = Path("barge.nc").read_bytes()
    for wrong in (data[: len(data) // 3], b"CDF\x02", b"text"):
        Path("wrong.nc").write_bytes(wrong)
        refused = run("import", "wrong.nc")
        assert refused.exit_code == 1 and "BG137" in refused.stderr, refused.output
    Path("wrong.nc").write_bytes(data.replace(b"added_mass", b"other_mass"))
    refused = run("import", "wrong.nc")
    assert refused.exit_code == 1 and "no `added_mass`" in refused.stderr
    Path("wrong.nc").write_bytes(data.replace(b"Heave", b"Heavy"))
    assert "import one rigid body" in run("import", "wrong.nc").stderr
    Path("wrong.nc").write_bytes(data.replace(b"hydrostatic_stiffness", b"hydrostatic_weakness_"))
    assert "hydrostatic stiffness in heave" in run("import", "wrong.nc").stderr
    assert data.count(b"reim") == 1
    Path("wrong.nc").write_bytes(data.replace(b"reim", b"reil"))
    assert "the axis `complex`" in run("import", "wrong.nc").stderr


def test_the_first_column_of_wamit_may_be_a_frequency(folder):
    """IPEROUT = 2: told by .cfg, or by the heave force; the ship is the same."""
    expected = json.loads(import_hull(HULLS / "barge.1", SEA, "x.json").data)
    for name in ("barge.1", "barge.3"):
        rows = [line.split(maxsplit=1) for line in Path(name).read_text().splitlines()]
        turned = [(float(p), rest) for p, rest in rows]
        text = [f"{2 * np.pi / p if p > 0 else p:.9e} {rest}\n" for p, rest in turned]
        Path(name).write_text("".join(text))
    for cfg in (None, " IPEROUT = 2  (rad/s)\n"):
        if cfg:
            Path("barge.cfg").write_text(cfg)
        found = json.loads(import_hull(Path("barge.3"), SEA, "x.json").data)
        np.testing.assert_allclose(
            found["radiation"]["damping"], expected["radiation"]["damping"], rtol=1e-5, atol=0.1
        )


def test_scales_and_mass_of_wamit_come_from_their_files(folder):
    """L = 4 m: coefficients by powers of L, the mass of .mmx by density, motions of .4 checked."""
    length, rho, g = 4.0, 1025.0, 9.81
    hull = symmetrised(read("barge.nc"))
    powers = np.add.outer([0, 0, 0, 1, 1, 1], [0, 0, 0, 1, 1, 1])
    arms = np.array([0, 0, 0, 1, 1, 1])
    found = motions(hull, hull.mass, hull.stiffness) * length**arms
    force = hull.force / (rho * g * length ** (2.0 + arms))
    rows1, rows3, rows4 = [], [], []
    for n, w in enumerate(hull.frequency):
        a = hull.added_mass[n] / (rho * length ** (3.0 + powers))
        b = hull.damping[n] / (rho * w * length ** (3.0 + powers))
        for i in range(6):
            for j in range(6):
                rows1.append(f"{2 * np.pi / w:.8e} {i + 1} {j + 1} {a[i, j]:.8e} {b[i, j]:.8e}")
        for h, heading in enumerate(np.degrees(hull.heading)):
            for i in range(6):
                for rows, z in ((rows3, force[n, h, i]), (rows4, found[n, h, i])):
                    start = f"{2 * np.pi / w:.8e} {heading:.6f} {i + 1} {abs(z):.8e}"
                    rows.append(f"{start} {np.degrees(np.angle(z)):.4f} {z.real:.8e} {z.imag:.8e}")
    stiffness = hull.stiffness / (rho * g * length ** (2.0 + powers))
    each = [(i, j) for i in range(6) for j in range(6)]
    hst = [f"{i + 1} {j + 1} {stiffness[i, j]:.8e}" for i, j in each]
    mmx = [
        f" Gravity:     {g}                Length scale:        {length}",
        " Volumes (VOLX,VOLY,VOLZ):  1920.0 1920.0 1920.0",
        " Center of Buoyancy (Xb,Yb,Zb):  1.5 -1.0 -1.0",
        " Center of Gravity:  (Xg,Yg,Zg)  1.5 -1.0 1.5",
        " Normalized mass matrix: ",
        "     I     J     MASS(I,J)/RHO",
        *(f"{i + 1} {j + 1} {hull.mass[i, j] / rho:.8e}" for i, j in each),
    ]
    for end, rows in (("1", rows1), ("3", rows3), ("4", rows4), ("hst", hst), ("mmx", mmx)):
        Path(f"scaled.{end}").write_text(" header\n" + "\n".join(rows) + "\n")
    shutil.copy("barge.pot", "scaled.pot")
    scaled = import_hull(Path("scaled.4"), SEA, "x.json")
    assert not any("mass" in w.message for w in scaled.warnings)
    assert any(line.startswith("check: motions and those") for line in scaled.report)
    one, two = (json.loads(x.data) for x in (import_hull(HULLS / "barge.nc", SEA, "x"), scaled))
    for key in ("M_RB", "G"):
        np.testing.assert_allclose(one[key], two[key], atol=1e-6 * np.abs(one[key]).max())
    for part in ("force", "motion"):
        for a, b in zip(table(one, part), table(two, part), strict=True):
            np.testing.assert_allclose(a, b, atol=1e-6 * np.abs(a).max())
