"""Parameters at the top level of a file: one value for all models, set by name."""

import numpy as np
import pytest
from model_files import model_text

import bgc
from bgc.driver import compile_scene
from bgc.elaboration.elaborate import elaborate
from bgc.options import Options
from bgc.resolution.library import library_folder
from bgc.resolution.resolve import load_text

TEXT = model_text("world")


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    found = tmp_path_factory.mktemp("world") / "a.bg"
    found.write_text(TEXT)
    return found


def final(result):
    return [result[name][-1] for name in ("fast", "slow", "h")]


def test_models_and_functions_share_one_value(path):
    model = bgc.compile(path, scene="earth")
    assert {"g", "half", "wind[2]"} <= set(model.parameters)
    assert final(model.simulate()) == pytest.approx([9.81 + 1.5, 9.81, 9.81 / 2])


def test_a_scene_sets_it_by_its_name_and_a_run_by_parameters(path):
    model = bgc.compile(path, scene="moon")
    assert final(model.simulate()) == pytest.approx([1.62, 1.62, 0.81])
    assert final(model.simulate(parameters={"g": "3 m/s^2"})) == pytest.approx([3, 3, 1.5])
    model = bgc.compile(path, scene="earth", parameters={"g": 5})
    assert final(model.simulate()) == pytest.approx([6.5, 5, 2.5])
    with pytest.raises(bgc.BgError, match="BG061"):
        model.simulate(parameters={"g": -1})


def test_it_can_be_set_where_no_model_reads_it():
    text = (
        TEXT + "model Lone { state x = 1; der(x) = -x; } scene c of Lone { set g = 2; observe x; }"
    )
    graph = elaborate(load_text(text), "c", (("half", "7"),))
    values = {p.name: graph.dag.value(p.value) for p in graph.parameters}
    assert (values["g"], values["half"], len(values)) == (2, 7, 2)


def test_a_constant_of_the_model_hides_it(path):
    text = TEXT.replace("model Pair {", "model Pair { const g = 4;")
    graph = elaborate(load_text(text.replace("half as h", "g as h")), "moon")
    value = {p.name: graph.dag.value(p.value) for p in graph.parameters}["g"]
    assert float(value) == 9.81  # `set` reached the model's own
    (own,) = (o.node for o in graph.observations if o.name == "h")
    assert float(graph.dag.value(own)) == 1.62


def test_parts_of_an_array_may_have_several_parameters():
    text = (
        "model Leg { param a = 1; param b = 2; state x = a; der(x) = -b*x; }\n"
        "model Two { for i in 1..2 { leg[i] : Leg; } } scene s of Two { observe leg[2].x; }\n"
    )
    names = [p.name for p in elaborate(load_text(text), "s").parameters]
    assert sorted(names) == ["leg[1].a", "leg[1].b", "leg[2].a", "leg[2].b"]


def test_a_zero_of_an_imported_file_is_folded_and_one_of_the_file_is_not(tmp_path):
    (tmp_path / "air.bg").write_text(
        "param drag : N*s/m = 0;\nmodel Air { port p in; r : R(drag); p -> r; }\n"
    )
    body = (
        "model M { i : I(1, f0 = 1); a : Air; j : J1; j -> i, a; }\nscene s of M { observe i.f; }\n"
    )
    (tmp_path / "far.bg").write_text(f'import "air.bg";\n{body}')
    (tmp_path / "near.bg").write_text((tmp_path / "air.bg").read_text() + body)
    folded = [
        [
            name
            for name, _ in compile_scene(
                tmp_path / name, Options(), until="fold"
            ).folding.parameters
        ]
        for name in ("far.bg", "near.bg")
    ]
    assert folded == [["drag"], []]


def test_gravity_of_the_library_is_a_parameter_of_the_world(tmp_path):
    """A pendulum of library parts: its period follows gravity, and none has none."""
    path = tmp_path / "a.bg"
    path.write_text(
        "import mechanics.joints;\nimport mechanics.body;\n"
        "model M { ground : Ground; pin : Revolute(axis = y, angle0 = 0.01 rad, lock = Rigid[5]);\n"
        "  arm : Shift(offset = [0, 0, -2 m]);\n"
        "  bob : HeavyBody(mass = 3 kg, inertia = 1e-9*eye(3));\n"
        "  ground -> pin -> arm -> bob; }\n"
        "scene s of M { observe pin.angle as a; run 1 s; }\n"
        "scene moon is s { set gravity = 1.62 m/s^2; }\n"
    )
    for scene, gravity in (("s", 9.81), ("moon", 1.62)):
        model = bgc.compile(path, scene=scene)
        a = model.simulate(rtol=1e-10)["a"]
        assert a[-1] == pytest.approx(0.01 * np.cos(np.sqrt(gravity / 2)), abs=1e-6)
    assert model.simulate(parameters={"gravity": 0.0})["a"] == pytest.approx(np.full(1001, 0.01))


def test_the_library_has_one_gravity():
    found = [
        path.relative_to(library_folder()).as_posix()
        for path in library_folder().rglob("*.bg")
        if "9.81" in path.read_text() and "examples" not in path.parts
    ]
    assert found == ["mechanics/frame.bg"]


def test_the_unit_of_a_default_binds_every_value_that_replaces_it(tmp_path):
    path = tmp_path / "a.bg"
    path.write_text(
        "param rate = 2 s^-1; model M { param k = 3 N/mm; state x = 1; der(x) = -k*x*rate; }"
        "scene s of M { set k = 3; set rate = 4; observe x; run 1 s; }"
    )
    model = bgc.compile(path)
    k = model.parameters["k"]
    assert (k.value, k.unit, str(k.shown.unit)) == (3, "N/m", "N/mm")
    for name, wrong in (("k", "3 kg"), ("rate", "1 m")):
        with pytest.raises(bgc.BgError, match="BG063"):
            model.simulate(parameters={name: wrong})
        with pytest.raises(bgc.BgError, match="BG063"):
            bgc.compile(path, parameters={name: wrong})
        with pytest.raises(bgc.BgError, match="BG266"):
            elaborate(load_text(path.read_text()), None, ((name, wrong),))


def test_a_long_chain_of_defaults_is_read():
    links = " ".join(f"param p{k} = p{k - 1};" for k in range(1, 1500))
    text = f"model M {{ param p0 = 1 m; {links} state x = 1; der(x) = -x; }}"
    scene = "scene s of M { set p1499 = 3 kg; observe x; run 1 s; }"
    with pytest.raises(bgc.BgError, match="BG266"):
        elaborate(load_text(text + scene))
