"""Write and check 3: write a robot (URDF, MJCF) or another tool's model as a .bg file."""

from pathlib import Path

from bgc.diagnostics.catalogue.reference import file_exists
from bgc.runtime.cli.command import Target, command, option, require
from bgc.runtime.cli.options import File
from bgc.runtime.cli.printing import (
    print_diagnostics,
    print_text,
    print_written,
    write_file,
)
from bgc.runtime.importing.importing import Choices, import_text


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
) -> None:
    """Write FILE, a model of another tool, as a .bg file.

    FILE is a robot in URDF (.urdf) or MJCF (.xml, with the package mujoco), or a bond graph that
    BondGraphTools saved (.yaml, .bg).

    \b
    bgc import ur5.urdf                    writes ur5.bg
    bgc import panda.urdf -o arm/panda.bg
    bgc import arm.urdf --package arm_description=../arm
    bgc import ant.xml -o - | less
    """
    goal = Path(out or f"{file.stem}.bg")
    is_free = out == "-" or force or not goal.exists()
    require(is_free, file_exists(str(goal), "--force"))
    choices = Choices(dict(map(_folder, packages)), not no_limits, floating)
    imported = import_text(file, Path() if out == "-" else goal.parent, choices)
    print_diagnostics(imported.warnings)
    if out == "-":
        print_text(imported.text)
    else:
        write_file(goal, imported.text)
        print_written(str(goal))


def _folder(text: str) -> tuple[str, Path]:
    """Read NAME=FOLDER."""
    name, _, folder = text.partition("=")
    require(name and folder, f"--package {text}: write --package NAME=FOLDER")
    return name, Path(folder)
