"""BEMIO's `.h5`: a barge in its layout against the dataset of Capytaine, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.importing.hydrodynamics.account import Account, Given
from bgc.runtime.importing.hydrodynamics.bemio import read_bemio
from bgc.runtime.importing.hydrodynamics.capytaine import read_capytaine

HULLS = Path(__file__).parents[1] / "models" / "hulls"
h5py = pytest.importorskip("h5py")


def write(path: Path, scaled: bool, **changed: object) -> None:
    """Write the barge as `writeBEMIOH5.m` does: axes are mode, mode or heading, frequency."""
    hull = read_capytaine(HULLS / "barge.nc", Given(), Account())
    rho, g, w = hull.density, hull.gravity, hull.frequency
    one = (1, 1, 1, 1) if scaled else (rho, rho * w, rho * g, rho * g)
    force = hull.force.transpose(2, 1, 0) / one[2]
    values = {
        "simulation_parameters/scaled": [[float(scaled)]],
        "simulation_parameters/rho": [[rho]],
        "simulation_parameters/g": [[g]],
        "simulation_parameters/w": w[:, None],
        "simulation_parameters/wave_dir": np.degrees(hull.heading)[:, None],
        "simulation_parameters/water_depth": "infinite",
        "body1/properties/cg": hull.origin[:, None],
        "body1/properties/cb": hull.centre_of_buoyancy[:, None],
        "body1/properties/disp_vol": [[hull.volume]],
        "body1/hydro_coeffs/added_mass/all": np.moveaxis(hull.added_mass, 0, 2) / one[0],
        "body1/hydro_coeffs/added_mass/inf_freq": hull.added_mass_infinite / one[0],
        "body1/hydro_coeffs/radiation_damping/all": np.moveaxis(hull.damping, 0, 2) / one[1],
        "body1/hydro_coeffs/excitation/re": force.real,
        "body1/hydro_coeffs/excitation/im": force.imag,
        "body1/hydro_coeffs/linear_restoring_stiffness": hull.stiffness / one[3],
        **changed,
    }
    with h5py.File(path, "w") as file:
        for name, value in values.items():
            if value is not None:
                file[name] = value


@pytest.mark.parametrize("scaled", [False, True])
def test_a_file_of_bemio_is_the_hull(tmp_path, scaled):
    write(tmp_path / "barge.h5", scaled)
    found = read_bemio(tmp_path / "barge.h5", Given(), Account())
    hull = read_capytaine(HULLS / "barge.nc", Given(), Account())
    for key in ("added_mass", "damping", "force", "stiffness", "added_mass_infinite", "origin"):
        expected = getattr(hull, key)
        near = 1e-12 * np.abs(expected).max()
        np.testing.assert_allclose(getattr(found, key), expected, atol=near)
    assert found.volume == pytest.approx(hull.volume) and np.isinf(found.depth)


@pytest.mark.parametrize(
    ("changed", "code", "said"),
    [
        ({"body1/hydro_coeffs/excitation/re": None}, "BG137", "excitation/re"),
        ({"body2/properties/cg": [0.0, 0.0, 0.0]}, "BG138", "several bodies"),
        ({"body1/hydro_coeffs/added_mass/all": np.zeros((6, 12, 6))}, "BG138", "(6, 12, 6)"),
        ({"simulation_parameters/rho": [[0.0]]}, "BG138", "simulation_parameters/rho"),
    ],
)
def test_other_files_are_refused(tmp_path, changed, code, said):
    write(tmp_path / "barge.h5", False, **changed)
    with pytest.raises(BgError) as refused:
        read_bemio(tmp_path / "barge.h5", Given(), Account())
    (found,) = refused.value.diagnostics
    assert found.code == code and said in found.message


def test_damaged_files_are_refused(tmp_path):
    write(tmp_path / "barge.h5", False)
    whole = (tmp_path / "barge.h5").read_bytes()
    for wrong in (b"text", whole[:700]):
        (tmp_path / "wrong.h5").write_bytes(wrong)
        with pytest.raises(BgError, match="HDF5"):
            read_bemio(tmp_path / "wrong.h5", Given(), Account())
