"""Zeros and ones that a scene fixes are compiled in, and leave nothing behind."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from graphs import causal_of
from model_files import model_text

import bgc
from bgc.algebra.dag import Op
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import check_source, compile_scene
from bgc.elaboration.elaborate import elaborate
from bgc.emission.lower import lower
from bgc.emission.simplification import optimise
from bgc.equations.derive import derive_equations
from bgc.ir.lowered import Lowered
from bgc.options import Options
from bgc.resolution.resolve import load_text
from bgc.slicing.fold import Folding, fold_parameters
from bgc.slicing.slice import slice_program

ROTOR = model_text("fold_rotor")


def folded(text: str, overrides: tuple[tuple[str, str], ...] = ()) -> Folding:
    return fold_parameters(elaborate(load_text(ROTOR + text, "rotor.bg"), None, overrides))


def left(text: str, overrides: tuple[tuple[str, str], ...] = ()) -> set[str]:
    return {p.name for p in folded(text, overrides).graph.parameters}


def lowered(text: str) -> Lowered:
    program = derive_equations(causal_of(folded(text).graph))
    return lower(optimise(slice_program(program)))


SCENE = "scene s of Drive { observe rotor.body.p; run 1 s; %s }"


def test_zeros_of_parts_are_folded_and_what_follows_from_them() -> None:
    assert folded(SCENE % "").parameters == (("rotor.friction", 0.0), ("rotor.drag", 0.0))


def test_parameters_of_the_scenes_own_model_and_ones_of_parts_stay() -> None:
    assert left(SCENE % "") == {"torque", "slip", "rotor.inertia", "rotor.start"}


def test_zeros_and_ones_that_the_scene_sets_are_folded_wherever_they_are() -> None:
    settings = "set slip = 0; set torque = 1; set rotor.start = 0; set rotor.inertia = 3;"
    assert left(SCENE % settings) == {"rotor.inertia"}


def test_the_command_line_sets_too() -> None:
    assert "torque" not in left(SCENE % "", (("torque", "1"),))
    assert {"rotor.friction", "rotor.drag"} <= left(SCENE % "", (("rotor.friction", "3"),))


def test_keep_leaves_a_parameter_to_be_set() -> None:
    assert "rotor.friction" in left(SCENE % "keep rotor.friction;")
    assert "rotor.friction" in left(SCENE % "keep rotor;")


def test_a_model_without_a_scene_is_not_folded() -> None:
    assert "rotor.friction" in left("")


def test_components_are_folded_one_by_one() -> None:
    text = """
    model Field {
      port p[2] in;
      param M[2, 2] = [[1, 0], [0, 2]];
      body : I[2](M); p -> body;
    }
    model Whole { force : Se[2](e = [1, 1]); field : Field; force -> field; }
    scene s of Whole { observe field.body.p; run 1 s; }
    """
    assert left(text) == {"field.M[1,1]", "field.M[2,2]"}


def test_a_zero_friction_leaves_no_trace() -> None:
    """The same equations, entries and factors as without the resistors."""
    bare = ROTOR.replace("R(friction)", "R(0)").replace("R(drag)", "R(0)")
    without = lowered(SCENE % "")
    graph = elaborate(load_text(bare + SCENE % "", "bare.bg"))
    other = lower(optimise(slice_program(derive_equations(causal_of(graph)))))

    def size(made: Lowered) -> tuple[int, int, int]:
        dag = made.program.dag
        f = dag.reachable(state.derivative for state in made.program.states)
        return sum(dag.op[n] > Op.SYMBOL for n in f), len(made.jacobian.entries), made.plan.entries

    assert size(without) == size(other)
    kept = lowered(SCENE % "keep rotor.friction, rotor.drag;")
    assert size(kept)[0] > size(without)[0]


def test_an_error_of_the_folded_model_is_found_by_check(tmp_path: Path) -> None:
    """A compliance of zero in a part can never work."""
    file = tmp_path / "stiff.bg"
    file.write_text(
        "model Part { port p in; param k = 0; spring : C(k); p -> spring; }\n"
        "model Whole { push : Se(e = 1); r : R(1); j : J1; part : Part; push -> j -> r, part; }\n"
        "scene s of Whole { observe part.spring.q; run 1 s; }\n"
    )
    assert [d.code for d in check_source(file)] == ["BG511"]


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fold") / "rotor.bg"
    path.write_text(ROTOR + SCENE % "")
    return path


def test_a_folded_parameter_is_compiled_again_when_it_is_given(file: Path) -> None:
    """With b on m = 2, p(1) = F m/b + (1 - F m/b) exp(-b/m)."""
    model = bgc.compile(file, parameters={"rotor.friction": 0.5})
    end = model.simulate(rtol=1e-10)["rotor.body.p"][-1]
    b = 0.5 + 2 * 0.5
    assert end == pytest.approx(2 / b + (1 - 2 / b) * math.exp(-b / 2), rel=1e-8)


def test_a_folded_parameter_is_refused_afterwards(file: Path) -> None:
    model = bgc.compile(file)
    assert model.parameters.folded == {"rotor.friction": 0.0, "rotor.drag": 0.0}
    assert repr(model.parameters).endswith("compiled in, see `folded`: 2")
    with pytest.raises(BgError, match="BG078"):
        model.parameters["rotor.friction"] = 3
    with pytest.raises(BgError, match="BG078"):
        model.simulate(parameters={"rotor.drag": 3})
    assert model.simulate()["rotor.body.p"][-1] == pytest.approx(2)


def test_a_vector_may_be_set_where_its_folded_components_stay(tmp_path: Path) -> None:
    file = tmp_path / "field.bg"
    file.write_text(
        "model Field { port p[2] in; param M[2, 2] = [[1, 0], [0, 2]]; body : I[2](M); p -> body; }"
        "model Whole { force : Se[2](e = [1, 1]); field : Field; force -> field; }"
        "scene s of Whole { observe field.body.f as v; run 1 s; }"
    )
    model = bgc.compile(file)
    model.parameters["field.M"] = [[2, 0], [0, 4]]
    assert model.simulate()["v"][-1] == pytest.approx([1 / 2, 1 / 4])
    with pytest.raises(BgError, match="BG078"):
        model.parameters["field.M"] = [[2, 1], [1, 4]]
    with pytest.raises(BgError, match="BG077"):
        model.parameters["field.M"] = [2, 4]
    coupled = bgc.compile(file, parameters={"field.M": [[2, 1], [1, 3]]})
    assert coupled.simulate()["v"][-1] == pytest.approx([2 / 5, 1 / 5])


def test_the_whole_model_has_all_parameters(file: Path) -> None:
    assert not compile_scene(file, Options(whole=True), until="fold").folding.parameters
    assert "rotor.friction" in bgc.compile(file, whole=True).parameters
