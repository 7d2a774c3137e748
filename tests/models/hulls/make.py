"""Make the hydrodynamic data of this folder with Capytaine 3 (`pip install capytaine netcdf4`).

    python make.py [FOLDER]

Three hulls in deep water of 1025 kg/m^3: a barge whose degrees of freedom are about a point that is
neither its centre nor in the surface, a hemisphere, and a vertical cylinder. Of each there is a
dataset in netCDF (NAME.nc; classic but for the cylinder, which is netCDF-4), and Capytaine's own
motions about the same point (NAME_rao.json), for the symmetric parts of added mass and damping, as
the meshes are coarse. The barge is written for WAMIT and for Nemoh as well,
by Capytaine's writers and with the control files that these programs would read. Capytaine's writer
of .hst is right for a length scale of 1 alone, and so that is taken.
"""

import json
import sys
from pathlib import Path

import capytaine as cpt
import numpy as np
from capytaine.io.legacy import write_dataset_as_tecplot_files
from capytaine.post_pro import rao

RHO = 1025.0
FOLDER = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent)
POT = """barge
-1.0                 HBOT
1 1                  IRAD, IDIFF
0                    NPER
0                    NBETA
1                    NBODY
barge.gdf
{} {} {} 0.0         XBODY
1 1 1 1 1 1          MODE
"""
CAL = """--- Environment ---
{rho}    ! RHO   ! KG/M**3 ! Fluid specific volume
9.81     ! G     ! M/S**2  ! Gravity
0.       ! DEPTH ! M       ! Water depth
0. 0.    ! XEFF YEFF ! M   ! Wave measurement point
--- Description of floating bodies ---
1        ! Number of bodies
--- Body 1 ---
barge.dat ! Name of mesh file
4 1      ! Number of points and number of panels
6        ! Number of degrees of freedom
1 1. 0. 0. 0. 0. 0.    ! Surge
1 0. 1. 0. 0. 0. 0.    ! Sway
1 0. 0. 1. 0. 0. 0.    ! Heave
2 1. 0. 0. {point}     ! Roll about a point
2 0. 1. 0. {point}     ! Pitch about a point
2 0. 0. 1. {point}     ! Yaw about a point
6        ! Number of resulting generalised forces
1 1. 0. 0. 0. 0. 0.    ! Force in x direction
1 0. 1. 0. 0. 0. 0.    ! Force in y direction
1 0. 0. 1. 0. 0. 0.    ! Force in z direction
2 1. 0. 0. {point}     ! Moment force in x direction about a point
2 0. 1. 0. {point}     ! Moment force in y direction about a point
2 0. 0. 1. {point}     ! Moment force in z direction about a point
0        ! Number of lines of additional information
--- Load cases to be solved ---
1 {count} {low} {high} ! Freq type 1,2,3=[rad/s,Hz,s],Number of wave frequencies, Min, and Max
6 0. 300.              ! Number of wave directions, Min and Max (degrees)
"""


def solve(name, mesh, centre, point, frequencies, degrees):
    """Solve a hull about a point; write its dataset and Capytaine's motions."""
    body = cpt.FloatingBody(
        mesh=mesh,
        name=name,
        center_of_mass=centre,
        dofs=cpt.rigid_body_dofs(rotation_center=point),
    ).immersed_part()
    given = {"body": body, "rho": RHO}
    problems = [
        cpt.RadiationProblem(omega=w, radiating_dof=dof, **given)
        for w in (*frequencies, np.inf)
        for dof in body.dofs
    ]
    problems += [
        cpt.DiffractionProblem(omega=w, wave_direction=np.radians(b), **given)
        for w in frequencies
        for b in degrees
    ]
    data = cpt.assemble_dataset(
        cpt.BEMSolver().solve_all(problems, progress_bar=False), hydrostatics=True
    )
    finite = data.sel(omega=list(frequencies))
    for matrix in ("added_mass", "radiation_damping"):
        values = finite[matrix].values
        finite[matrix] = finite[matrix].dims, (values + values.swapaxes(1, 2)) / 2
    motions = (
        rao(finite)
        .sel(omega=list(frequencies))
        .transpose("omega", "wave_direction", "radiating_dof")
    )
    (FOLDER / f"{name}_rao.json").write_text(
        json.dumps(
            {
                "frequency": list(frequencies),
                "heading_deg": list(degrees),
                "point": list(point),
                "re": np.round(motions.values.real, 9).tolist(),
                "im": np.round(motions.values.imag, 9).tolist(),
            }
        )
        + "\n"
    )
    return data


def save(name, data, classic=True):
    """Write a dataset: classic netCDF, which Capytaine writes without the package netCDF4."""
    data = cpt.io.xarray.separate_complex_values(data)
    for axis in ("radiating_dof", "influenced_dof"):
        data[axis] = data[axis].astype("str")
    data.attrs.pop("creation_of_dataset", None)
    data.to_netcdf(FOLDER / f"{name}.nc", engine="scipy" if classic else "netcdf4")


def main():
    """Make all files."""
    point = (0.5, 0.0, -1.0)
    frequencies = np.linspace(0.3, 1.8, 6).round(9)
    barge = solve(
        "barge",
        cpt.mesh_parallelepiped(size=(40, 12, 6), resolution=(14, 6, 3), center=(2, -1, -1)),
        (2.0, -1.0, 0.5),
        point,
        frequencies,
        (0, 60, 120, 180, 240, 300),
    )
    save("barge", barge)
    cpt.export_dataset(str(FOLDER / "barge"), barge, format="wamit")
    (FOLDER / "barge.pot").write_text(POT.format(*point))
    nemoh = FOLDER / "nemoh"
    nemoh.mkdir(exist_ok=True)
    write_dataset_as_tecplot_files(str(nemoh), barge.sel(omega=list(frequencies)))
    np.savetxt(nemoh / "KH.dat", barge.hydrostatic_stiffness.values, fmt="%1.6E")
    text = CAL.format(rho=RHO, point="{} {} {}".format(*point), count=6, low=0.3, high=1.8)
    (nemoh / "Nemoh.cal").write_text(text)
    for name in ("8", "3sc", "3fk"):
        (FOLDER / f"barge.{name}").unlink(missing_ok=True)

    frequencies = (0.4, 0.8, 1.2, 1.6, 2.0, 2.4)
    degrees = (0, 45, 90, 135, 180)
    ball = cpt.mesh_sphere(radius=5, resolution=(14, 14))
    hemisphere = solve("hemisphere", ball, (0, 0, -1.5), (0, 0, -1.5), frequencies, degrees)
    save("hemisphere", hemisphere)
    tube = cpt.mesh_vertical_cylinder(length=8, radius=4, center=(0, 0, -2), resolution=(4, 18, 6))
    cylinder = solve("cylinder", tube, (0, 0, -3), (0, 0, 0), frequencies, degrees)
    save("cylinder", cylinder, classic=False)


main()
