"""Texts that were answered slowly: the work that they cause grows with their size, not faster.

Work is counted in calls of Python functions and bounded in memory, since times say nothing here.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from bgc.diagnostics.collection import Report
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.census import Census
from bgc.resolution.resolve import load, load_text
from bgc.values.units import parse_unit

TAIL = "model M { state x = 1; der(x) = -x; } scene s of M { observe x; run 1 s; }"

_LIMITED = """
import resource, sys
from pathlib import Path
import bgc.resolution.resolve, bgc.driver, bgc.diagnostics.render
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
resource.setrlimit(resource.RLIMIT_AS, (2_000_000_000, -1))
try:
    bgc.driver.compile_scene(Path(sys.argv[1]), Options(), until="elaborate")
    print("compiled")
except BgError as error:
    print(" ".join(sorted({d.code for d in error.diagnostics})))
    bgc.diagnostics.render.render(error.diagnostics, colour=False)
"""


def answer(folder: Path, text: str) -> str:
    """`compiled`, or the codes of the errors; a text that takes a minute or 2 GB fails."""
    path = folder / "slow.bg"
    path.write_text(text)
    command = [sys.executable, "-c", _LIMITED, path]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.strip()


DOUBLING = "model A0 { state x = 1; der(x) = -x; }" + "".join(
    f"model A{k} {{ a : A{k - 1}; b : A{k - 1}; }}" for k in range(1, 31)
)

SLOW = {
    "a path with dots": ('import "a..' + "a" * 90_000 + '";' + TAIL, "BG020"),
    "a module": ("import " + "a" * 90_000 + ";" + TAIL, "BG021"),
    "a type": ("model M { x : " + "a" * 90_000 + "; }", "BG201"),
    "a path": ("model M { a" + ".b" * 40_000 + "; }", "BG101"),
    "a unit": ("model M { let x = 1 " + "m*" * 45_000 + "m; }", "BG301"),
    "a comment": ("/*" + ("x" * 79 + "\n") * 187_500 + "*/" + TAIL, "compiled"),
    "a comment of stars": ("/*" + "* * * \n" * 900_000 + "*/" + TAIL, "compiled"),
    "an open comment": ("/*" + ("x" * 79 + "\n") * 187_500 + TAIL, "BG110"),
    "lines of comment": ("//\n" * 900_000 + TAIL, "compiled"),
    "lines of documentation": ("/// x\n" * 900_000 + TAIL, "compiled"),
    "empty lines": ("\n" * 15_000_000 + TAIL, "BG005"),
    "ancestors": (
        "model A0 { }" + "".join(f"model A{k} is A{k - 1} {{}}" for k in range(1, 3_000)),
        "BG215",
    ),
    "doubling": (DOUBLING + "scene s of A30 { observe a.x; run 1 s; }", "BG418"),
}


@pytest.mark.skipif(sys.platform != "linux", reason="limits the resources of a process")
@pytest.mark.parametrize("name", SLOW)
@pytest.mark.slow
def test_large_texts_are_answered(tmp_path, name):
    text, expected = SLOW[name]
    assert expected in answer(tmp_path, text)


def calls_of(action) -> int:
    """The number of Python functions that an action enters."""
    count = 0

    def note(frame, event, argument):
        nonlocal count
        count += event == "call"

    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(None)
    return count


def refused(text: str) -> None:
    with pytest.raises(BgError):
        load_text(text)


@pytest.mark.parametrize(
    "text_of",
    [
        lambda n: "model A0 { }" + "".join(f"model A{k} is A{k - 1} {{}}" for k in range(1, n)),
        lambda n: "model M {" + "".join(f"p{k} : T{k};" for k in range(n)) + "}",
        lambda n: (
            "".join(f"model Long{k} {{}}" for k in range(n))
            + "model M {"
            + "".join(f"p{k} : Lone{k};" for k in range(n))
            + "}"
        ),
    ],
    ids=["ancestors", "unknown types", "unknown types beside many"],
)
def test_the_work_grows_with_the_size_only(text_of):
    refused(text_of(150))  # what is made once, such as the index of the library
    small, large = (calls_of(lambda n=n: refused(text_of(n))) for n in (500, 2_000))
    assert large < 4.5 * small


def test_a_long_name_in_a_message_takes_no_longer_than_its_length():
    from bgc.diagnostics.catalogue.files import file_missing

    report = Report()
    report.add(file_missing("a" * 1_000_000))  # took hours, by a regular expression
    assert report.errors


def test_a_unit_has_a_limited_length():
    assert parse_unit("*".join(["m"] * 24)) is not None
    assert parse_unit("*".join(["m/m"] * 1000)) is None


def least(text: str, name: str) -> int:
    return Census().least_parts(load_text(text).root.models[name])


def test_parts_are_counted_before_they_are_made():
    assert least(DOUBLING, "A30") == 2**31 - 2
    text = (
        "interface Any {} model E is Any { a : C(1); b : R(1); }"
        "model M { for i in 1..3 { e[i] : E; } if 1 > 2 { x : R(1); } else { y : E; z : R(1); }"
        "slot : Any = E(); open : Any; one : E; }"
    )
    assert least(text, "M") == 3 * 3 + 1 + 3


def test_a_model_within_the_limit_is_not_refused(tmp_path):
    path = tmp_path / "m.bg"
    path.write_text(DOUBLING + "scene s of A3 { observe a.a.a.x; run 1 s; }")
    assert load(path).scene_names == ("s",)
