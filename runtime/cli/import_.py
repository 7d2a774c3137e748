"""Write and check 3: write a robot, a hull or another tool's model as a .bg file."""

from pathlib import Path

import click

from bgc.diagnostics.catalogue.reference import file_exists
from bgc.runtime.cli.command import Target, command, option, require
from bgc.runtime.cli.options import File
from bgc.runtime.cli.printing import (
    print_diagnostics,
    print_text,
    print_written,
    write_file,
)
from bgc.runtime.importing.fmu_import import PowerPort
from bgc.runtime.importing.hydrodynamics.account import Given
from bgc.runtime.importing.importing import Choices, import_text

POSITIVE = click.FloatRange(0, min_open=True)


@command(name="import")
def import_(
    file: File,
    out: str | None = option(
        "File to write; - for standard output.", "-o", "--out", type=Target(".bg", "-")
    ),
    force: bool = option("Replace a file that exists."),
    packages: tuple[str, ...] = option(
        "Folder of package://NAME/. May be repeated.", "--package", metavar="NAME=FOLDER"
    ),
    no_limits: bool = option("Leave out the end stops of joints."),
    floating: bool = option("In the example scene, let the robot's base float."),
    density: float | None = option(
        "Density of the water, kg/m^3, where files of a hull lack it.", type=POSITIVE
    ),
    length_scale: float | None = option(
        "Length that files of WAMIT are scaled by, m, where they lack it.", type=POSITIVE
    ),
    power: tuple[str, ...] = option(
        "Power port of an FMU: two of its variables whose product is the power into it. May be "
        "repeated.",
        metavar="PORT=EFFORT,FLOW",
    ),
    order: str = option(
        "Order of the coupling of an FMU in its step: 1 holds its outputs, 2 continues them by "
        "straight lines, and gives it the mean of its inputs over a step.",
        choices=("1", "2"),
        default="1",
        show_default=True,
    ),
) -> None:
    """Write FILE, a model of another tool, as a .bg file.

    FILE is a robot in URDF (.urdf) or MJCF (.xml, with the package mujoco), a bond graph that
    BondGraphTools saved (.yaml, .bg), or hydrodynamic data of a hull, which become a ship with a
    data file (.json) beside it: Capytaine (.nc), WAMIT (.1 .2 .3 .4 .hst), Nemoh (Nemoh.cal) or
    BEMIO (.h5). An FMU (.fmu) becomes a sampled part, and runs on this machine may then execute
    the program in it.

    \b
    bgc import ur5.urdf                    writes ur5.bg
    bgc import panda.urdf -o arm/panda.bg
    bgc import arm.urdf --package arm_description=../arm
    bgc import ant.xml -o - | less
    bgc import hull.nc                     writes hull.bg and hull.json
    bgc import winch.fmu --power shaft=torque,speed
    """
    goal = Path(out or f"{file.stem}.bg")
    is_free = out == "-" or force or not goal.exists()
    require(is_free, file_exists(str(goal), "--force"))
    data = goal.with_suffix(".json")
    given = Given(density, length_scale)
    folders, ports = dict(map(_folder, packages)), tuple(map(_port, power))
    choices = Choices(folders, not no_limits, floating, data.name, given, ports, int(order))
    imported = import_text(file, Path() if out == "-" else goal.parent, choices)
    if imported.data:
        require(out != "-", "a ship needs its data file beside it: name the `.bg` file with -o")
        require(force or not data.exists(), file_exists(str(data), "--force"))
    print_diagnostics(imported.warnings)
    if imported.report:
        print_text("\n".join(imported.report))
    if out == "-":
        print_text(imported.text)
        return
    write_file(goal, imported.text)
    if imported.data:
        write_file(data, imported.data)
    print_written(str(goal), str(data) if imported.data else None)


def _folder(text: str) -> tuple[str, Path]:
    """Read NAME=FOLDER."""
    name, _, folder = text.partition("=")
    require(name and folder, f"--package {text}: write --package NAME=FOLDER")
    return name, Path(folder)


def _port(text: str) -> PowerPort:
    """Read PORT=EFFORT,FLOW."""
    name, _, pair = text.partition("=")
    effort, _, flow = pair.partition(",")
    require(name and effort and flow, f"--power {text}: write --power PORT=EFFORT,FLOW")
    return PowerPort(name, effort, flow)
