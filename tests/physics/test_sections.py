"""Beams by section, and solids: figures by quadrature, motion by Euler's equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from bgc.diagnostics.diagnostic import BgError

STEEL, ALLOY = 7850.0, 2700.0


def raster(inside, width, height, cells=2000):
    """Area and second moments of `inside(y, z)` by the midpoint rule: area, Iy, Iz."""
    y = (np.arange(cells) + 0.5) / cells - 0.5
    y, z = np.meshgrid(y * width, y * height)
    da = inside(y, z) * (width / cells) * (height / cells)
    return da.sum(), (z * z * da).sum(), (y * y * da).sum()


def torsion(b, h, cells=160):
    """Torsion constant of a rectangle: Prandtl's stress function by finite differences."""
    x, y = np.arange(1, cells), np.arange(1, cells)
    eigen_x = 4 / (b / cells) ** 2 * np.sin(np.pi * x / 2 / cells) ** 2
    eigen_y = 4 / (h / cells) ** 2 * np.sin(np.pi * y / 2 / cells) ** 2
    modes = np.sqrt(2 / cells) * np.sin(np.pi * np.outer(x, y) / cells)
    load = modes @ np.full((cells - 1, cells - 1), 2.0) @ modes
    stress = modes @ (load / (eigen_x[:, None] + eigen_y)) @ modes
    return 2 * stress.sum() * (b / cells) * (h / cells)


SECTIONS = {
    "rectangle": lambda y, z: np.abs(y) < 0.05,
    "box": lambda y, z: (np.abs(y) > 0.188) | (np.abs(z) > 0.288),
    "tube": lambda y, z: (np.hypot(y, z) < 0.15) & (np.hypot(y, z) > 0.142),
    "upright_web": lambda y, z: (np.abs(z) > 0.235) | (np.abs(y) < 0.005),
}
SIZES = {"rectangle": (0.1, 0.3), "box": (0.4, 0.6), "tube": (0.3, 0.3), "upright_web": (0.3, 0.5)}
#: x along the beam, y its width, z its height, in the axes of the base.
AXES = {
    "rectangle": np.eye(3),
    "upright_web": np.eye(3),
    "box": np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]]),
    "tube": np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0.0]]),
}


def matrix(result, name, rows):
    """The first row of a result as a matrix of three columns."""
    return [[result[f"{name}[{i},{k}]"][0] for k in (1, 2, 3)] for i in range(1, rows + 1)]


def top(inertia, mass, com, time):
    """Angular velocity in body axes of a heavy body about a fixed point."""
    start = Rotation.from_euler("ZYX", [0.5, -0.2, 0.3])
    about = inertia + mass * (com @ com * np.eye(3) - np.outer(com, com))

    def rates(_, y):
        turn, w = Rotation.from_quat(y[:4]), y[4:]
        weight = turn.inv().apply([0, 0, -9.81 * mass])
        moment = np.cross(com, weight) - np.cross(w, about @ w)
        moment[0] += 40
        scalar, vector = y[3], y[:3]
        quat = np.append(scalar * w + np.cross(vector, w), -vector @ w) / 2
        return np.concatenate([quat, np.linalg.solve(about, moment)])

    y0 = np.concatenate([start.as_quat(), [0.4, -0.7, 0.9]])
    return solve_ivp(rates, (0, time[-1]), y0, t_eval=time, rtol=1e-10, atol=1e-12).y[4:].T


@pytest.mark.parametrize("name", list(SECTIONS))
def test_a_beam_has_the_moments_of_its_section_and_moves_with_them(load, name):
    result = load("sections", name).simulate(rtol=1e-9)
    mass, area, iy, iz, j, _ = result["figures"][0]
    expected = raster(SECTIONS[name], *SIZES[name])
    np.testing.assert_allclose([area, iy, iz], expected, rtol=4e-3)
    assert mass == pytest.approx(ALLOY * area * 4, rel=1e-12)
    own = mass * np.diag([(iy + iz) / area, 16 / 12 + iy / area, 16 / 12 + iz / area])
    axes = AXES[name]
    inertia = axes @ own @ axes.T
    np.testing.assert_allclose(matrix(result, "inertia", 3), inertia, rtol=1e-9, atol=1e-9)
    w = top(inertia, mass, 2 * axes[:, 0], result.time)
    np.testing.assert_allclose(result["w"], w, atol=1e-6)
    assert np.abs(result["energy.residual"]).max() < 1e-7 * result.counts["exchanged"]
    torsions = {
        "rectangle": torsion(0.1, 0.3),
        "box": 4 * (0.388 * 0.588) ** 2 * 0.012 / (2 * (0.388 + 0.588)),
        "tube": 2 * iy,
        "upright_web": (2 * 0.3 * 0.015**3 + 0.485 * 0.01**3) / 3,
    }
    assert j == pytest.approx(torsions[name], rel=3e-4 if name == "rectangle" else 1e-9)


def test_a_beam_takes_a_full_inertia(load):
    result = load("sections", "tensor").simulate(rtol=1e-9)
    inertia = np.array([[20, 1, 2], [1, 400, -3], [2, -3, 410.0]])
    w = top(inertia, 300.0, np.array([2.1, 0.1, -0.2]), result.time)
    np.testing.assert_allclose(result["w"], w, atol=1e-6)


def test_solids_have_the_mass_and_inertia_of_their_shape(load):
    result = load("sections", "solids").simulate()
    volumes = np.array(
        [
            500 / STEEL * 6,
            np.pi * 0.16 * 2,
            np.pi * (0.16 - 0.39**2) * 2,
            4 / 3 * np.pi * 0.027,
            4 / 3 * np.pi * (0.027 - 0.299**3),
        ]
    )
    masses = STEEL * volumes
    np.testing.assert_allclose(result["masses"][0], masses, rtol=1e-12)
    box, cylinder, tube, sphere, shell = masses
    thin = 0.395**2  # mean radius of the tube's wall
    expected = [
        [box / 12 * 13, box / 12 * 10, box / 12 * 5],
        [cylinder * 0.08, *[cylinder * (0.04 + 4 / 12)] * 2],
        [*[tube * (thin / 2 + 4 / 12)] * 2, tube * thin],
        [0.4 * sphere * 0.09] * 3,
        [2 / 3 * shell * 0.2995**2] * 3,
    ]
    np.testing.assert_allclose(matrix(result, "inertias", 5), expected, rtol=4e-4)


@pytest.mark.parametrize(
    ("scene", "changes", "message"),
    [
        ("box", {"wall": 0.2}, "must leave a cavity"),
        ("upright_web", {"height": 0.02}, "must leave a web"),
        ("tube", {"wall": 0.2}, "at most half its diameter"),
    ],
)
def test_impossible_sections_are_refused(load, scene, changes, message):
    changes = {f"beam.section.{name}": value for name, value in changes.items()}
    with pytest.raises(BgError, match=message):
        load("sections", scene).simulate(parameters=changes)
