"""The driver: passes in order, and what is checked of files that do not run alone."""

from dataclasses import FrozenInstanceError, replace
from pathlib import Path
from typing import get_args

import pytest

import bgc
from bgc.driver import Stage, check_source, compile_scene
from bgc.options import Options
from bgc.resolution.resolve import library_folder

RLC = Path(__file__).parents[1] / "models" / "series_rlc.bg"
LIBRARY = sorted(library_folder().rglob("*.bg"))


def codes(path: Path) -> list[str]:
    return [diagnostic.code for diagnostic in check_source(path)]


def test_stages_run_in_order_up_to_the_one_asked_for():
    order = list(get_args(Stage))
    for stage in order:
        stages = compile_scene(RLC, Options(), until=stage)
        assert list(stages.seconds) == order[: order.index(stage) + 1]
    assert stages.built.library.exists()


def test_the_result_of_a_stage_that_did_not_run_is_an_error():
    stages = compile_scene(RLC, Options(), until="causality")
    assert stages.causal.strokes
    with pytest.raises(AttributeError, match="before the stage that makes `equations`"):
        _ = stages.equations


def test_stages_are_frozen():
    stages = compile_scene(RLC, Options(), until="parse")
    with pytest.raises(FrozenInstanceError):
        stages.package = stages.package


def test_a_prepared_graph_is_compiled_and_not_remembered():
    def observing_nothing(graph):
        return replace(graph, observations=(), scene=replace(graph.scene, columns=(), accounts=()))

    prepared = compile_scene(RLC, Options(), prepare=observing_nothing)
    assert not prepared.optimised.observations
    assert bgc.compile(RLC).outputs


@pytest.mark.slow
@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: path.stem)
def test_every_file_of_the_library_checks_without_diagnostics(path):
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


def test_a_model_that_no_scene_reaches_is_checked_too(tmp_path) -> None:
    """Only the scenes' models, or the last one of a file, used to be elaborated."""
    wrong = "model {} {{ s : Se(5 N); c : C(3 kg); s -> c; }}\n"
    right = "model Right { s : Se(5 N); r : R(3 N*s/m); s -> r; }\n"
    scene = "scene s of Right { observe r.f; run 1 s; }\n"
    part = "model Part { port p; param k; c : C(k); p -> c; }\n"
    file = tmp_path / "m.bg"
    for text in (
        wrong.format("A") + right,
        wrong.format("A") + right + scene,
        part + wrong.format("A") + wrong.format("B") + right + scene,
    ):
        file.write_text(text)
        assert [d.code for d in check_source(file)] == ["BG423"] * text.count("3 kg")
    file.write_text(part + right + scene)
    assert check_source(file) == []


def test_check_evaluates_values_of_the_file_that_no_scene_uses(tmp_path):
    path = tmp_path / "a.bg"
    wrong = {
        'const table = data("none.csv");': "BG250",
        "param gravity : m/s^2 = 9.81 kg;": "BG306",
        "param ranged = 3 in 4 .. 5;": "BG239",
        "const one = two; const two = one;": "BG214",
        "const mixed = 3 m + 2 kg;": "BG303",
        "const h = 3 W/(m^2*K);": "BG268",
    }
    scene = "model M { state x = 1; der(x) = -x%s; } scene s of M { observe x; run 1 s; }"
    path.write_text("\n".join((*wrong, scene % "")))
    found = check_source(path)
    assert [d.code for d in found] == list(wrong.values())
    assert [d.span.source.position(d.span.start)[0] for d in found if d.span] == [1, 2, 3, 4, 5, 6]
    assert check_source(path, "s") == [], "of one scene, what it uses"
    path.write_text("\n".join((*wrong, scene % "*two*mixed")))
    assert sorted(d.code for d in check_source(path)) == sorted(wrong.values()), "each once"
    path.write_text("\n".join(wrong))
    assert [d.code for d in check_source(path)] == list(wrong.values()), "without a model too"
