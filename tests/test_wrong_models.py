"""Each wrong model is refused with the code it names in a comment, on the line it names.

A line of `tests/wrong/*.bg` that is at fault ends in `// error: BG123`, one that is only odd in
`// warning: BG123`, one with a note in `// info: BG123`. Nothing else may be reported, no message
is without its place and its way out, and nothing ends in a traceback. What the user reads stands
in `NAME.txt` beside the model; `pytest -m golden --bless` rewrites it. A line `// ----` divides a
file into programs that are compiled one by one.
"""

import re
from pathlib import Path

import pytest

from bgc.diagnostics.diagnostic import BgError, Diagnostic, Severity
from bgc.diagnostics.render import render
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.resolution.resolve import load, load_text

WRONG = sorted((Path(__file__).parent / "wrong").glob("*.bg"))
DIVISION = "// ----\n"
EXPECTED = re.compile(r"// (error|warning|info): (BG\d+)")


def programs_of(path: Path) -> list[tuple]:
    """The programs of a file, each as a function and its arguments, with the lines of the file."""
    first, *others = path.read_text("utf-8").split(DIVISION)
    if not others:
        return [(load, path)]
    texts = [first]
    for other in others:
        texts.append("\n" * (texts[-1].count("\n") + 1) + other)
    return [(load_text, text, path.name) for text in texts]


def diagnostics_of(compile_all, *arguments) -> list[Diagnostic]:
    try:
        package = compile_all(*arguments)
        path = Path(package.sources[0].name)
        stages = compile_scene(path, Options(), package=package, until="equations")
    except BgError as err:
        return [d for d in err.diagnostics if d.severity is Severity.ERROR]
    return list(stages.warnings)


def diagnostics_in(path: Path) -> list[Diagnostic]:
    return [d for program in programs_of(path) for d in diagnostics_of(*program)]


def place_of(diagnostic: Diagnostic) -> tuple[int, str, str]:
    assert diagnostic.span is not None
    line, _ = diagnostic.span.source.position(diagnostic.span.start)
    return line, diagnostic.severity.value, diagnostic.code


@pytest.mark.parametrize("path", WRONG, ids=lambda p: p.stem)
def test_wrong_model_gives_its_code_at_its_line(path):
    expected = {
        (number, severity, code)
        for number, line in enumerate(path.read_text().splitlines(), 1)
        for severity, code in EXPECTED.findall(line)
    }
    by_program = [diagnostics_of(*program) for program in programs_of(path)]
    assert all(by_program), "a program is in order"
    diagnostics = [diagnostic for found in by_program for diagnostic in found]
    found = {place_of(d) for d in diagnostics}
    assert found == expected and len(diagnostics) == len(expected), "one message per cause"
    assert all(d.help for d in diagnostics)
    shown = render(diagnostics, colour=False)
    assert "^" in shown and path.name in shown


@pytest.mark.parametrize("path", WRONG, ids=lambda p: p.stem)
def test_each_edit_removes_its_diagnostic(path, monkeypatch):
    monkeypatch.chdir(path.parent)
    for program in programs_of(Path(path.name)):
        found = diagnostics_of(*program)
        for diagnostic in found:
            for edit in diagnostic.edits[:1]:
                text = edit.span.source.text
                after = text[: edit.span.start] + edit.text + text[edit.span.end :]
                left = diagnostics_of(load_text, after, path.name)
                assert alike(left, diagnostic) == alike(found, diagnostic) - 1, edit


def alike(diagnostics: list[Diagnostic], one: Diagnostic) -> int:
    return [(d.code, d.message) for d in diagnostics].count((one.code, one.message))


@pytest.mark.parametrize("path", WRONG, ids=lambda p: p.stem)
def test_messages_are_as_blessed(path, bless, monkeypatch):
    monkeypatch.chdir(path.parent)
    text = render(diagnostics_in(Path(path.name)), colour=False)
    blessed = path.with_suffix(".txt")
    if bless:
        blessed.write_text(text, "utf-8")
    shown = blessed.read_text("utf-8") if blessed.exists() else ""
    assert text == shown, f"{text}\npytest -m golden --bless rewrites {blessed.name}"


def test_no_blessed_message_is_an_orphan():
    texts = {path.stem for path in (Path(__file__).parent / "wrong").glob("*.txt")}
    assert texts == {path.stem for path in WRONG}


# Unit tests that name a code of a wrong model, by what they check and no text of a model can show.
BESIDE = {
    "a pass alone, on graphs, trees or expressions built by hand": (
        "causality determined equations expressions fold free_motions linear "
        "physics_checks transfer"
    ),
    "parsing, formatting or editing: what else is read, the end of a file, what an edit makes": (
        "edits format lark_parser lsp parse_refusals"
    ),
    "texts of absurd size or of an attacker, under limits": (
        "absurd attacks number_range security slow_texts"
    ),
    "properties over many models: no other code, or none, is given": (
        "audit bond_counts demands divisors impulses initial_defaults inherited_scenes jumps "
        "symmetry"
    ),
    "values given to a run, a command or a study, or in a file beside the model": (
        "ahead asserts cost data_files effects files fmu_parts inputs observables operability "
        "optimise realtime reduce scenes stress study world"
    ),
    "how messages are shown, looked up, counted or made errors": (
        "campaigns catalogue cli commands doc notebook render strict warnings warnings_of_values"
    ),
    "which of the files and models of a package are checked, and what is told together": (
        "driver elaborate_errors"
    ),
}


def test_a_code_has_one_home():
    """A code of a wrong model is in no unit test, but for those that check something else."""
    shown = {code for path in WRONG for _, code in EXPECTED.findall(path.read_text("utf-8"))}
    named = re.compile(r"""(?:["'\[]|error: |warning: )(BG\d{3})""")
    found = set()
    for path in Path(__file__).parent.glob("unit/test_*.py"):
        if shown & set(named.findall(path.read_text("utf-8"))):
            found.add(path.stem.removeprefix("test_"))
    beside = [name for names in BESIDE.values() for name in names.split()]
    assert len(beside) == len(set(beside))
    assert sorted(found - set(beside)) == [], "write a model in tests/wrong instead"
    assert sorted(set(beside) - found) == [], "rows without a use"
