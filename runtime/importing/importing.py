"""`import_text`: a file of another tool as a `.bg` text, with what was left out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from bgc.diagnostics.catalogue.files import file_missing, is_directory
from bgc.diagnostics.catalogue.imported import not_importable
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.grammar.source_files import read_source
from bgc.record_class import dataclass, field
from bgc.runtime.importing.bond_graph_tools import read_bond_graph_tools
from bgc.runtime.importing.fmu_import import PowerPort, import_fmu
from bgc.runtime.importing.hydrodynamics.account import Given
from bgc.runtime.importing.hydrodynamics.hulls import READERS, import_hull
from bgc.runtime.importing.mjcf import read_mjcf
from bgc.runtime.importing.notes import Notes
from bgc.runtime.importing.urdf import read_urdf
from bgc.runtime.importing.write import write_robot

ROBOTS = (".urdf", ".xml", ".mjcf")
GRAPHS = (".bg", ".yaml", ".yml")
FMUS = (".fmu",)


@dataclass(frozen=True, slots=True)
class Imported:
    """A text in canonical form, and the warnings.

    `data` is the text of the data file that the model reads, `report` the account of an import of
    data; both are empty for other files.
    """

    text: str
    warnings: tuple[Diagnostic, ...]
    data: str = ""
    report: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Choices:
    """Options of an import.

    Of robots: folders of packages, end stops, and a base that floats. Of hulls: the name of the
    data file, and values that the data lack. Of FMUs: power ports, and the order of
    their coupling.
    """

    packages: Mapping[str, Path] = field(default_factory=dict)
    limits: bool = True
    floating: bool = False
    data_file: str = "hull.json"
    given: Given = field(default_factory=Given)
    ports: tuple[PowerPort, ...] = ()
    order: int = 1


def import_text(path: Path, folder: Path, choices: Choices) -> Imported:
    """Convert a file to the text of a `.bg` file that is to lie in `folder`.

    Raises
    ------
    BgError
        BG137 for a file of an unknown kind; BG138 and BG270 for faults of its contents; BG058 where
        the package that reads it is missing.
    """
    kind = path.suffix.lower()
    if kind == ".xacro":
        what = f"{path} is written in xacro, a language of macros"
        help = f"run `xacro {path} > robot.urdf`, and import robot.urdf"
        raise BgError([not_importable(what, help=help)])
    if kind == ".ssp":
        what = f"{path} is a system of FMUs"
        help = "unpack it, and import its FMUs one by one"
        raise BgError([not_importable(what, help=help)])
    known = ", ".join((*ROBOTS, *GRAPHS, *READERS, *FMUS))
    if kind not in (*ROBOTS, *GRAPHS, *READERS, *FMUS):
        what = f"{path} is of an unknown kind"
        raise BgError([not_importable(what, help=f"name a file in {known}")])
    if path.is_dir():
        raise BgError([is_directory(str(path), f"a file in {known}")])
    if kind in READERS:
        if not path.exists():
            raise BgError([file_missing(str(path))])
        hull = import_hull(path, choices.given, choices.data_file)
        return Imported(hull.text, hull.warnings, hull.data, hull.report)
    notes = Notes()
    if kind in FMUS:
        if not path.exists():
            raise BgError([file_missing(str(path))])
        text = import_fmu(path, folder, choices.ports, choices.order, notes)
        return Imported(text, notes.diagnostics())
    source = read_source(path)
    if kind in GRAPHS:
        return Imported(read_bond_graph_tools(source), ())
    if kind == ".urdf":
        robot = read_urdf(source, choices.packages, notes)
    else:
        robot = read_mjcf(source, notes)
    text = write_robot(robot, folder, limits=choices.limits, floating=choices.floating)
    return Imported(text, notes.diagnostics())
