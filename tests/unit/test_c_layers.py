"""Files of the C runtime call each other without circles."""

from __future__ import annotations

import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from bgc.building.build import runtime_directory

_DEFINITION = re.compile(
    r"^(?!static|typedef|extern)\w[\w *]*[ *](bgc_\w+)(?:\(|\[| = )", re.MULTILINE
)


def calls_of(files: list[Path]) -> dict[str, set[str]]:
    """Names of files by file: those that define the functions and data that it uses."""
    texts = {
        path.name: re.sub(r"/\*.*?\*/", "", path.read_text("utf-8"), flags=re.DOTALL)
        for path in files
    }
    owner = {name: file for file, text in texts.items() for name in _DEFINITION.findall(text)}
    return {
        file: {owner[name] for name in re.findall(r"\bbgc_\w+", text) if name in owner} - {file}
        for file, text in texts.items()
    }


@pytest.mark.parametrize("lanes", [False, True], ids=["runtime", "lanes"])
def test_files_call_each_other_without_circles(lanes: bool) -> None:
    folder = runtime_directory()
    patterns = ("*.c", "drivers/*.c", *(("lanes/*.c",) if lanes else ()))
    files = [path for pattern in patterns for path in sorted(folder.glob(pattern))]
    calls = calls_of(files)
    assert "evaluate.c" in calls["step.c"] and "tableaus.c" in calls["options.c"]
    assert len(list(TopologicalSorter(calls).static_order())) == len(files)


@pytest.mark.parametrize("patterns", [("*.c", "drivers/*.c", "fmi/*.c", "web/*.c"), ("lanes/*.c",)])
def test_no_static_name_is_used_by_two_files(patterns: tuple[str, ...]) -> None:
    """These files are compiled as one unit, where their static names meet."""
    declared = re.compile(r"^static [\w \*]*?\b(\w+)(?=\(| =|\[|;)", re.MULTILINE)
    own: dict[str, str] = {}
    for pattern in patterns:
        for path in sorted(runtime_directory().glob(pattern)):
            for name in set(declared.findall(path.read_text("utf-8"))):
                other = own.setdefault(name, path.name)
                assert other == path.name, f"`{name}` is in {other} and {path.name}"
    assert len(own) > 10
