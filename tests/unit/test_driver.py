"""The driver: passes in order, and what is checked of files that do not run alone."""

from pathlib import Path

import pytest

from bgc.driver import Compilation, check_source
from bgc.options import Options
from bgc.resolution.resolve import library_folder

RLC = Path(__file__).parents[1] / "models" / "series_rlc.bg"
LIBRARY = sorted(library_folder().rglob("*.bg"))


def codes(path: Path) -> list[str]:
    return [diagnostic.code for diagnostic in check_source(path)]


def test_each_pass_runs_once_and_in_order():
    compilation = Compilation(RLC, Options())
    first, again = compilation.emitted, compilation.emitted
    assert first is again
    passes = ["parse", "elaborate", "fold", "causality", "equations", "slice", "optimise", "emit"]
    assert list(compilation.seconds) == passes


def test_nothing_beyond_the_pass_that_is_asked_for_runs():
    compilation = Compilation(RLC, Options())
    assert compilation.causal.strokes
    assert list(compilation.seconds) == ["parse", "elaborate", "fold", "causality"]


@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: path.stem)
def test_every_file_of_the_library_checks_without_a_word(path):
    assert codes(path) == []


PART = "model Part {\n  port p;\n  param k;\n  spring : C(k);\n  p -> spring;\n}\n"
ALONE = "model Alone {\n  s : Se(e = 1);\n  r : R(1);\n  s -> r;\n}\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (PART, []),
        (PART.replace("C(k)", "C(stiff)"), ["BG211"]),
        (PART + "model Given is Part(k = 2) {\n}\n", []),
        (ALONE, []),
        (ALONE.replace("  s -> r;\n", ""), ["BG407", "BG407"]),
        (PART + ALONE.replace("  s -> r;\n", ""), ["BG407", "BG407"]),
        ("", ["BG601"]),
        ("const a = 1;\nfunction f(x) = a*x;\n", []),
    ],
)
def test_a_file_of_parts_is_checked_for_its_names_one_that_runs_for_everything(
    tmp_path, text, expected
):
    path = tmp_path / "file.bg"
    path.write_text(text)
    assert codes(path) == expected


def test_every_scene_of_a_file_is_checked(tmp_path):
    path = tmp_path / "file.bg"
    scene = "scene {0} of Alone {{\n  observe {1};\n  run 1 s;\n}}\n"
    path.write_text(ALONE + scene.format("good", "r.f") + scene.format("bad", "q.f"))
    assert codes(path) == ["BG211"]
    assert check_source(path, "good") == []
