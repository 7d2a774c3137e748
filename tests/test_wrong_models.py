"""Each wrong model is refused with the code it names in a comment, on the line it names.

A line of `tests/wrong/*.bg` that is at fault ends in `// error: BG123`, one that is only odd in
`// warning: BG123`, one with a note in `// info: BG123`. Nothing else may be reported, no message
is without its place and its way out, and nothing ends in a traceback. What the user reads stands
in `NAME.txt` beside the model; `pytest -m golden --bless` rewrites it.
"""

import random
import re
from pathlib import Path

import pytest

from bgc.diagnostics.diagnostic import BgError, Diagnostic, Severity
from bgc.diagnostics.render import render
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.resolution.resolve import load, load_text

WRONG = sorted((Path(__file__).parent / "wrong").glob("*.bg"))
GOOD = sorted((Path(__file__).parent / "models").glob("*.bg"))
LIBRARY = sorted((Path(__file__).parents[1] / "library").rglob("*.bg"))
EXPECTED = re.compile(r"// (error|warning|info): (BG\d+)")


def diagnostics_of(compile_all, *arguments) -> list[Diagnostic]:
    try:
        package = compile_all(*arguments)
        path = Path(package.sources[0].name)
        stages = compile_scene(path, Options(), package=package, until="equations")
    except BgError as err:
        return [d for d in err.diagnostics if d.severity is Severity.ERROR]
    return list(stages.warnings)


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
    diagnostics = diagnostics_of(load, path)
    found = {place_of(d) for d in diagnostics}
    assert found == expected and len(diagnostics) == len(expected), "one message per cause"
    assert all(d.help for d in diagnostics)
    shown = render(diagnostics, colour=False)
    assert "^" in shown and path.name in shown


@pytest.mark.parametrize("path", WRONG, ids=lambda p: p.stem)
def test_messages_are_as_blessed(path, bless, monkeypatch):
    monkeypatch.chdir(path.parent)
    text = render(diagnostics_of(load, Path(path.name)), colour=False)
    blessed = path.with_suffix(".txt")
    if bless:
        blessed.write_text(text, "utf-8")
    shown = blessed.read_text("utf-8") if blessed.exists() else ""
    assert text == shown, f"{text}\npytest -m golden --bless rewrites {blessed.name}"


def test_no_blessed_message_is_an_orphan():
    texts = {path.stem for path in (Path(__file__).parent / "wrong").glob("*.txt")}
    assert texts == {path.stem for path in WRONG}


def mutated(text: str, rng: random.Random) -> str:
    """The text with a few characters or lines taken out, doubled, swapped or replaced."""
    for _ in range(rng.randint(1, 4)):
        at, length = rng.randrange(len(text) + 1), rng.choice((1, 1, 2, 7, 40))
        piece = text[at : at + length]
        other = rng.randrange(len(text) + 1)
        text = rng.choice(
            (
                text[:at] + text[at + length :],
                text[:at] + piece + text[at:],
                text[:at] + text[other : other + length] + text[at + length :],
                text[:at] + rng.choice("{}()[];->,.=*^1e9\"'\0\u00e9 \n") + text[at:],
            )
        )
    return text


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.slow
def test_mutated_models_never_give_a_traceback(seed):
    rng = random.Random(seed)
    for _ in range(40):
        text = mutated(rng.choice(GOOD).read_text(), rng)
        for diagnostic in diagnostics_of(load_text, text, "mutated.bg"):
            assert re.fullmatch(r"BG\d{3}", diagnostic.code)


def reworded(text: str, rng: random.Random) -> str:
    """The text with words, numbers or operators exchanged, or lines: most of it still parses."""
    pieces = re.split(r"(\w+|->|[-+*/])", text)
    kinds = (r"[A-Za-z]\w*", r"\d+", r"[-+*/]")
    for _ in range(rng.randint(1, 3)):
        kind = rng.choice(kinds)
        places = [k for k, piece in enumerate(pieces) if re.fullmatch(kind, piece)]
        if places:
            pieces[rng.choice(places)] = pieces[rng.choice(places)]
    lines = "".join(pieces).splitlines(keepends=True)
    if rng.random() < 0.3:
        lines.insert(rng.randrange(len(lines)), lines.pop(rng.randrange(len(lines))))
    return "".join(lines)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.slow
def test_reworded_models_never_give_a_traceback(tmp_path, seed):
    rng = random.Random(seed)
    for _ in range(10):
        path = rng.choice((*GOOD, *WRONG, *LIBRARY))
        made = tmp_path / path.name
        made.write_text(reworded(path.read_text(), rng))
        for diagnostic in diagnostics_of(load, made):
            assert diagnostic.help and re.fullmatch(r"BG\d{3}", diagnostic.code)
