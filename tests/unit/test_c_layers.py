"""Files of the C runtime call each other without circles."""

from __future__ import annotations

import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from bgc.building.build import INTEGRATOR, runtime_directory

_DEFINITION = re.compile(r"^(?!static|typedef|extern)\w[\w *]*[ *](\w+)(?:\(|\[| = )", re.MULTILINE)
FOLDER = runtime_directory()
LANES = [*sorted(FOLDER.glob("lanes/*.c")), *(FOLDER / f"{name}.c" for name in INTEGRATOR)]


def files_of(*patterns: str) -> list[Path]:
    return [path for pattern in patterns for path in sorted(FOLDER.glob(pattern))]


UNITS = {
    "runtime": files_of("*.c", "drivers/*.c"),
    "lanes": LANES,
    "tangents": files_of("tangents/*.c"),
    "fmi": files_of("*.c", "fmi/*.c"),
    "servo": files_of("servo/*.c"),
    "host": files_of("host/*.c"),
    "web": files_of("*.c", "web/*.c"),
}


def text_of(path: Path) -> str:
    """The text of a file and of the sources that it includes once for each kind of number."""
    text = path.read_text("utf-8")
    included = re.findall(r'^#include "(\w+_kinds\.h|arrays\.h)"', text, re.MULTILINE)
    for name, kind in zip(included, ("", "_complex"), strict=False):
        source = (FOLDER / name).read_text("utf-8")
        text += re.sub(r"BGC_KIND\((\w+)\)", rf"\g<1>{kind}", source)
    return text


def calls_of(files: list[Path]) -> dict[str, set[str]]:
    """Names of files by file: those that define the functions and data that it uses."""
    texts = {path.name: re.sub(r"/\*.*?\*/", "", text_of(path), flags=re.DOTALL) for path in files}
    owner = {name: file for file, text in texts.items() for name in _DEFINITION.findall(text)}
    return {
        file: {owner[name] for name in re.findall(r"\b\w+", text) if name in owner} - {file}
        for file, text in texts.items()
    }


@pytest.mark.parametrize("unit", UNITS)
def test_files_call_each_other_without_circles(unit: str) -> None:
    calls = calls_of(UNITS[unit])
    assert all(called for file, called in calls.items() if file in {"step.c", "lockstep.c"})
    assert len(list(TopologicalSorter(calls).static_order())) == len(calls)


@pytest.mark.parametrize("files", [files_of("*.c", "drivers/*.c", "fmi/*.c", "web/*.c"), LANES])
def test_no_static_name_is_used_by_two_files(files: list[Path]) -> None:
    """These files are compiled as one unit, where their static names meet."""
    declared = re.compile(r"^static [\w \*]*?\b(\w+)(?=\(| =|\[|;)", re.MULTILINE)
    own: dict[str, str] = {}
    for path in files:
        for name in set(declared.findall(text_of(path))):
            other = own.setdefault(name, path.name)
            assert other == path.name, f"`{name}` is in {other} and {path.name}"
    assert len(own) > 10
