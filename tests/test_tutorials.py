"""The tutorials: commands print what the pages show, and excerpts are of the files.

A page of `library/examples` has blocks of two kinds that are tested:

- `console`: each line after `$ ` is run by the shell in a copy of the folder, and has to print the
  lines that follow it. Measured times and rounding errors may differ, numbers by 1 in 10,000,
  counts of steps by 1 in 10, estimated errors (`2e-06`) by a factor of 4. A block after the comment
  `<!-- measured -->` prints little but measurements; it only has to succeed.
- `bg`: lines of the page's `.bg` file, verbatim but for their indentation.

`pytest tests/test_tutorials.py --bless` writes the outputs into the pages.
"""

from __future__ import annotations

import difflib
import math
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import dedent

import pytest

from bgc.grammar.parse import parse, read_source
from bgc.grammar.syntax import Scene

EXAMPLES = Path(__file__).parents[1] / "library" / "examples"
TUTORIALS = ("motor_gearbox", "two_tanks", "quarter_car", "hydraulic_cylinder", "hanging_load")
EXAMPLES_OF_PARTS = (
    "rlc_filter",
    "rectifier",
    "dc_servo",
    "heated_wall",
    "two_mass",
    "clutch",
    "backlash",
    "stick_slip",
    "pendulum_swing",
    "bouncing_ball",
    "beam_modes",
    "wave_buoy",
    "water_hammer",
    "gyroscope",
    "pumped_swing",
    "roll_tank",
)
MODELS = (*TUTORIALS, *EXAMPLES_OF_PARTS)
PAGES = ("README", *MODELS)

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MEASURED = "<!-- measured -->\n"
ERROR = re.compile(r"\de[+-]\d+")  # to one digit
NUMBER = re.compile(r"(?<![\w.])-?\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?")
VARYING = (
    re.compile(r"simulated in .*x real time"),
    re.compile(r"worst step .*"),
    re.compile(r"measured: .*"),
    re.compile(r"energy residual .* J"),
    re.compile(r" \(\d+ rejected\)"),
)


@dataclass(frozen=True, slots=True)
class Command:
    """One line after `$ `, and what the page prints below it."""

    line: str
    output: str
    measured: bool


def page_text(name: str) -> str:
    return (EXAMPLES / f"{name}.md").read_text("utf-8")


def commands_of(block: str, measured: bool) -> list[Command]:
    pieces = re.split(r"^\$ (.*)\n", block, flags=re.MULTILINE)
    assert pieces[0] == "", "a console block begins with a command"
    return [Command(a, b, measured) for a, b in zip(pieces[1::2], pieces[2::2], strict=True)]


def is_measured(text: str, match: re.Match[str]) -> bool:
    return text[: match.start()].endswith(MEASURED)


def commands(text: str) -> Iterator[Command]:
    for match in BLOCK.finditer(text):
        if match[1] == "console":
            yield from commands_of(match[2], is_measured(text, match))


def is_alike(shown: str, printed: str) -> bool:
    """Return whether two outputs agree but for measured times, rounding, and a few steps."""
    lines = [text.splitlines() for text in (shown, printed)]
    return len(lines[0]) == len(lines[1]) and all(map(_is_line_alike, *lines))


def _is_line_alike(shown: str, printed: str) -> bool:
    for pattern in VARYING:
        shown, printed = pattern.sub("", shown), pattern.sub("", printed)
    tolerance = 0.1 if " steps" in shown else 1e-4
    found = [[float(n.replace(",", "")) for n in _numbers(text)] for text in (shown, printed)]
    words = [NUMBER.sub("#", text).split() for text in (shown, printed)]
    limits = [0.75 if ERROR.fullmatch(n) else tolerance for n in _numbers(shown)]
    return (
        words[0] == words[1]
        and len(found[0]) == len(found[1])
        and all(
            math.isclose(a, b, rel_tol=limit, abs_tol=1e-9)
            for a, b, limit in zip(*found, limits, strict=True)
        )
    )


def _numbers(line: str) -> list[str]:
    """Its numbers; commas separate the columns of a row of CSV, and thousands elsewhere."""
    rows = line.split(",") if line.count(",") > 1 and " " not in line else [line]
    return [number for row in rows for number in NUMBER.findall(row)]


def printed_by(line: str, folder: Path) -> str:
    """The standard output and the messages of a command, in their order."""
    environment = os.environ | {
        "PATH": os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"])),
        "PYTHONUNBUFFERED": "1",
        "MPLBACKEND": "Agg",
        "COLUMNS": "120",
    }
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", line],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, f"$ {line}\n{done.stdout}"
    ended = done.stdout if done.stdout.endswith("\n") or not done.stdout else f"{done.stdout}\n"
    return "".join(f"{kept.rstrip()}\n" for kept in ended.splitlines())


def difference(command: Command, output: str) -> str:
    lines = (command.output.splitlines(), output.splitlines())
    changes = difflib.unified_diff(*lines, "the page", "now", lineterm="")
    return "\n".join((f"$ {command.line}", *changes, "", "--bless rewrites the page"))


def rewritten(text: str, outputs: Iterator[str]) -> str:
    """The page with these outputs, where they differ in more than measured times."""

    def block(match: re.Match[str]) -> str:
        if match[1] != "console":
            return match[0]
        measured = is_measured(text, match)
        lines = []
        for command in commands_of(match[2], measured):
            now = next(outputs)
            kept = (measured and command.output) or is_alike(command.output, now)
            lines.append(f"$ {command.line}\n{command.output if kept else now}")
        return f"```console\n{''.join(lines)}```"

    return BLOCK.sub(block, text)


@pytest.mark.parametrize("name", PAGES)
@pytest.mark.slow
def test_every_command_prints_what_the_page_shows(name, tmp_path, bless):
    for needed, program in (("$ ", "bash"), ("$ bgc graph", "dot")):
        if needed in page_text(name) and shutil.which(program) is None:
            pytest.skip(f"`{program}` is not installed")
    folder = tmp_path / "examples"
    shutil.copytree(EXAMPLES, folder)
    text = page_text(name)
    outputs = [printed_by(command.line, folder) for command in commands(text)]
    if bless:
        (EXAMPLES / f"{name}.md").write_text(rewritten(text, iter(outputs)), "utf-8")
        text = page_text(name)
    for command, output in zip(commands(text), outputs, strict=True):
        if not command.measured:
            assert is_alike(command.output, output), difference(command, output)


@pytest.mark.parametrize("name", MODELS)
def test_every_excerpt_is_of_the_file(name):
    source = (EXAMPLES / f"{name}.bg").read_text("utf-8")
    blocks = [match[2] for match in BLOCK.finditer(page_text(name)) if match[1] == "bg"]
    assert blocks
    for block in blocks:
        width = len(block) - len(block.lstrip(" "))
        assert block in source, f"not in {name}.bg:\n{dedent(block)} (indented by {width})"


@pytest.mark.parametrize("name", MODELS)
def test_every_scene_of_the_file_is_run_on_its_page(name):
    file, diagnostics = parse(read_source(EXAMPLES / f"{name}.bg"))
    assert not diagnostics
    first, *others = [d.name for d in file.declarations if isinstance(d, Scene)]
    lines = [c.line for c in commands(page_text(name)) if f"bgc run {name}.bg" in c.line]
    named = {line: re.search(r"--scene (\w+)", line) for line in lines}
    run = {found[1] if found else first for found in named.values()}
    assert run >= {first, *others}


@pytest.mark.parametrize("name", PAGES)
def test_every_picture_and_file_that_a_page_links_to_is_there(name):
    prose = re.sub(r"`[^`]*`", "", BLOCK.sub("", page_text(name)))
    links = re.findall(r"\]\(([^)#]+)\)", prose)
    files = [link for link in links if not link.startswith("http")]
    assert [link for link in files if not (EXAMPLES / link).is_file()] == []


def test_every_example_has_its_page_and_is_listed():
    assert {path.stem for path in EXAMPLES.glob("*.bg")} == set(MODELS)
    assert {path.stem for path in EXAMPLES.glob("*.md")} == set(PAGES)
    assert re.findall(r"\((\w+)\.md\)", page_text("README")) == list(MODELS)
