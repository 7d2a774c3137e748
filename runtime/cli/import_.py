"""`bgc import`."""

from __future__ import annotations

from pathlib import Path

import click

from bgc.diagnostics.catalogue.reference import file_exists
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import print_diagnostics, printable
from bgc.runtime.cli.options import check_target
from bgc.runtime.importing.importing import Choices, import_text
from bgc.runtime.results.files import written_whole


@click.command("import")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-o", "--out", metavar="FILE", help="File to write; - for standard output.")
@click.option("--force", is_flag=True, help="Replace a file that exists.")
@click.option(
    "--package",
    "packages",
    metavar="NAME=FOLDER",
    multiple=True,
    help="Folder of package://NAME/. May be repeated.",
)
@click.option("--no-limits", is_flag=True, help="Leave out the end stops of joints.")
@click.option("--floating", is_flag=True, help="In the example scene, let the robot's base float.")
def import_(
    file: Path,
    out: str | None,
    force: bool,
    packages: tuple[str, ...],
    no_limits: bool,
    floating: bool,
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
    target = out if out is not None else f"{file.stem}.bg"
    check_target(target, (".bg", "-"))
    goal = Path(target)
    if target != "-" and goal.exists() and not force:
        raise BgError([file_exists(target, "--force")])
    folder = Path() if target == "-" else goal.parent
    choices = Choices(_folders(packages), not no_limits, floating)
    imported = import_text(file, folder, choices)
    print_diagnostics(imported.warnings)
    if target == "-":
        click.echo(imported.text, nl=False)
        return
    with written_whole(goal) as aside:
        aside.write_text(imported.text, encoding="utf-8", newline="\n")
    click.echo(printable(f"wrote {goal}"))


def _folders(texts: tuple[str, ...]) -> dict[str, Path]:
    found = {}
    for text in texts:
        name, equals, folder = text.partition("=")
        if not (name and equals and folder):
            raise click.UsageError(f"--package {text}: write --package NAME=FOLDER")
        found[name] = Path(folder)
    return found
