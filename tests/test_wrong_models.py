"""Each wrong model is refused with the code it names in a comment, on the line it names.

A line of `tests/wrong/*.bg` that is at fault ends in `// error: BG123`. Nothing else may be
reported, no message is without its place and its way out, and nothing ends in a traceback.
"""

import random
import re
from pathlib import Path

import pytest

from bgc.causality.assign import assign_causality
from bgc.elaboration.elaborate import elaborate
from bgc.elaboration.resolve import load, load_text
from bgc.equations.derive import derive_equations
from bgc.grammar.diagnostics import BgError, Diagnostic, Severity
from bgc.grammar.render import render

WRONG = sorted((Path(__file__).parent / "wrong").glob("*.bg"))
GOOD = sorted((Path(__file__).parent / "models").glob("*.bg"))
EXPECTED = re.compile(r"// error: (BG\d+)")


def errors_of(compile_all, *arguments) -> list[Diagnostic]:
    try:
        package = compile_all(*arguments)
        derive_equations(assign_causality(elaborate(package)))
    except BgError as err:
        return [d for d in err.diagnostics if d.severity is Severity.ERROR]
    return []


@pytest.mark.parametrize("path", WRONG, ids=lambda p: p.stem)
def test_wrong_model_gives_its_code_at_its_line(path):
    expected = {
        (number, code)
        for number, line in enumerate(path.read_text().splitlines(), 1)
        for code in EXPECTED.findall(line)
    }
    errors = errors_of(load, path)
    found = {(d.span.source.position(d.span.start)[0], d.code) for d in errors if d.span}
    assert found == expected
    assert all(d.help or d.note or d.labels for d in errors)
    shown = render(errors, colour=False)
    assert "^" in shown and path.name in shown


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


@pytest.mark.parametrize("seed", range(20))
def test_mutated_models_never_give_a_traceback(seed):
    rng = random.Random(seed)
    for _ in range(50):
        text = mutated(rng.choice(GOOD).read_text(), rng)
        for diagnostic in errors_of(load_text, text, "mutated.bg"):
            assert re.fullmatch(r"BG\d{3}", diagnostic.code)
