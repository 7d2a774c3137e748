"""The targets of `bgc build`, a row for each; what every target is given, and what it makes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from itertools import groupby
from pathlib import Path

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.language.records import Where, option
from bgc.options import Options
from bgc.record_class import dataclass, field


@dataclass(frozen=True, slots=True)
class Order:
    """A scene to export. The fields after `options` are options of the command, for some targets.

    `Target.options` names the flags that a target takes.
    """

    file: Path
    options: Options
    prefix: str | None = option(
        "names begin with NAME_ instead of bgc_",
        of=None,
        kind=str,
        metavar="NAME",
        where=Where.COMMAND,
    )
    platforms: str | None = option(
        "platforms to build binaries for, separated by commas: linux64, linux-aarch64, win64, "
        "darwin64, darwin-aarch64. Default: this machine's. Others need ziglang",
        of=None,
        kind=str,
        metavar="NAMES",
        where=Where.COMMAND,
    )
    inputs: tuple[str, ...] = option(
        "an input of a model, a source (`supply.e`) or a parameter that becomes an input of the "
        "FMU. It is added to what the scene gives. In a system of several parts PART.NAME. May be "
        "repeated",
        of=(),
        kind=tuple,
        flag="--input",
        metavar="NAME",
        where=Where.COMMAND,
    )
    parts: tuple[str, ...] = option(
        "one more part of the system. Without FILE a scene of the same file, without SCENE the "
        "first one. The part of FILE itself has the file's name. May be repeated",
        of=(),
        kind=tuple,
        flag="--part",
        metavar="NAME=FILE:SCENE",
        where=Where.COMMAND,
    )
    wires: tuple[str, ...] = option(
        'a connection, "plant.angle -> loop.measured"; its end becomes an input. May be repeated',
        of=(),
        kind=tuple,
        flag="--connect",
        metavar="WIRE",
        where=Where.COMMAND,
    )
    reference: bool = option(
        "write the files of a cross-check too, NAME_ref.csv, NAME_in.csv and NAME_ref.opt",
        of=False,
        kind=bool,
        where=Where.COMMAND,
    )

    @property
    def name(self) -> str:
        """The file's name, with that of the scene where one is chosen."""
        scene = self.options.scene
        return self.file.stem if scene is None else f"{self.file.stem}.{scene}"


@dataclass(frozen=True, slots=True)
class Product:
    """What a target made: contents of files by name, the first of them the result itself.

    `companions` are files whose paths are not printed. `seconds` are those of the stages.
    """

    files: Mapping[str, bytes]
    warnings: Sequence[Diagnostic]
    seconds: Mapping[str, float] = field(default_factory=dict)
    companions: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Target:
    """A target: its name, its documentation, and the options of `bgc build` that only some take.

    `module` is a module of this package with a function `make(order, target)`. `printable` targets
    can be written to standard output.
    """

    name: str
    doc: str
    module: str
    options: tuple[str, ...] = ()
    printable: bool = False

    def make(self, order: Order) -> Product:
        """Export a scene. Raises BgError for the faults of the model, and those of the target."""
        # Most import the compiler, and a shared object from the cache does without it.
        found = import_module(f"bgc.runtime.targets.{self.module}")
        made: Product = found.make(order, self.name)
        return made


_FMU = (
    "a Functional Mock-up Unit (FMI 2.0 or 3.0), for Model Exchange and Co-Simulation",
    "fmu",
    ("--platforms", "--input", "--reference"),
)
TARGETS: Mapping[str, Target] = {
    target.name: target
    for target in (
        Target("so", "a shared object", "shared_object"),
        Target("c", "one self-contained C11 file", "c_file", ("--prefix",), printable=True),
        Target("fmu2", *_FMU),
        Target("fmu3", *_FMU),
        Target(
            "ssp",
            "a system of FMUs (SSP 1.0), see --part",
            "fmu_system",
            ("--platforms", "--input", "--part", "--connect"),
        ),
        Target(
            "html",
            "a page that runs the model in any browser, one file without a server (needs ziglang)",
            "live_page",
        ),
    )
}
"""All targets by name."""


def targets_taking(option: str) -> tuple[str, ...]:
    """The names of the targets that take an option; none for an option of every target."""
    return tuple(target.name for target in TARGETS.values() if option in target.options)


def documentation() -> str:
    """One line for all targets: `so: a shared object; c: ..`."""
    groups = groupby(TARGETS.values(), key=lambda target: target.doc)
    return "; ".join(f"{', '.join(each.name for each in found)}: {doc}" for doc, found in groups)
