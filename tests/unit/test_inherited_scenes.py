"""A scene from a scene: what is taken over, replaced, added and dropped."""

from pathlib import Path

import pytest
from model_files import model_text
from refusals import codes_of, refusals

import bgc
from bgc.diagnostics.diagnostic import BgError, Severity
from bgc.driver import check_source
from bgc.elaboration.elaborate import elaborate
from bgc.resolution.resolve import load, load_text

MODEL = model_text("inherited_scenes")
BASE = """
scene base of Circuit {
  set voltage = 2;
  set M[1, 2] = 7;
  drive gain = 3;
  observe inner.f as current;
  solver rodas5p(rtol = 1e-8);
  step 2 ms;
  deadline 1 ms;
  run 4 s every 1 s;
}
"""


def derived(items: str, base: str = BASE):
    text = f"{MODEL}{base}scene s is base {{ {items} }}"
    return elaborate(load_text(text), "s")


def defaults(graph):
    values = {p.name: graph.dag.value(p.value) for p in graph.parameters}
    return {name: None if value is None else float(value) for name, value in values.items()}


def test_all_statements_are_taken_over():
    own, base = derived(""), elaborate(load_text(MODEL + BASE), "base")
    assert own.scene.name == "s"
    facts = ("model", "solver", "step", "duration", "every", "deadline", "columns")
    assert [getattr(own.scene, f) for f in facts] == [getattr(base.scene, f) for f in facts]
    assert defaults(own) == defaults(base)


def test_a_statement_of_the_same_key_replaces():
    graph = derived("set voltage = 5; drive gain = time; step 1 ms; solver ros34prw; run 9 s;")
    facts = graph.scene
    assert defaults(graph)["voltage"] == 5
    assert (facts.solver.name, facts.step, facts.duration, facts.every) == (
        "ros34prw",
        1e-3,
        9,
        None,
    )
    assert facts.deadline == 1e-3


def test_a_whole_value_replaces_its_components_and_a_component_only_itself():
    assert defaults(derived("set M = [[0, 0], [0, 9]];"))["M[1,2]"] == 0
    graph = derived("set M[2, 1] = 6; set M[1, 2] = 8;")
    assert [defaults(graph)[f"M[{k}]"] for k in ("1,2", "2,1")] == [8, 6]


def test_other_statements_add_in_order():
    graph = derived("observe cell.e as source; plot current, source;")
    assert graph.scene.columns == ("current", "source")


def test_a_column_of_an_inherited_name_is_refused():
    assert codes_of(derived, "observe cell.e as current;") == ["BG621"]


def test_a_device_is_replaced_by_its_name():
    base = BASE.replace(
        "drive gain = 3;", 'device d = trace(file = "a.csv"); drive gain = d.gripper;'
    )
    (device,) = derived('device d = trace(file = "b.csv");', base).devices
    assert device.options == (("file", "b.csv"),)


def test_statements_about_a_removed_part_are_dropped_with_a_note():
    base = BASE.replace(
        "set voltage = 2;", "set load.L = 3; use load = Coil(); observe load.coil.p;"
    )
    graph = derived("use load = Resistor; set load.R = 4;", base)
    assert graph.scene.columns == ("current",)
    assert defaults(graph)["load.R"] == 4
    assert [(d.code, d.severity) for d in graph.warnings] == [("BG247", Severity.INFO)] * 2


def test_a_slot_filled_from_outside_drops_statements_as_an_extending_scene_does():
    text = f"{MODEL}{BASE.replace('observe', 'observe load.coil.p as flux; observe')}"
    graph = elaborate(load_text(text), "base", uses=[("load", "Resistor")])
    assert [o.name for o in graph.observations] == ["current"]
    (note,) = graph.warnings
    assert note.code == "BG247" and "`load.coil.p` does not exist" in note.message
    with pytest.raises(BgError, match="BG21"):  # what the command asks for itself is no statement
        elaborate(load_text(text), "base", uses=[("load", "Resistor")], observe=["load.coil.p"])


def test_a_choice_that_does_not_fit_is_the_error():
    """The scene names a part below the slot, which is looked for before errors are reported."""
    text = f"{MODEL}{BASE.replace('observe', 'observe load.coil.p as flux; observe')}"
    wide = "model Wide[n] is Load { port p in; r : R(n); p -> r; }"
    text += f"{wide} scene s is base {{ use load = Wide; }}"
    for scene, uses in (("base", [("load", "Wide")]), ("s", [])):
        with pytest.raises(BgError) as raised:
            elaborate(load_text(text), scene, uses=uses)
        assert raised.value.diagnostics


def test_a_misspelt_part_is_still_an_error():
    base = BASE.replace("set voltage = 2;", "set laod.L = 3;")
    with pytest.raises(BgError):
        derived("use load = Resistor;", base)
    with pytest.raises(BgError):  # not removed by `use`: its own statement
        derived("use load = Resistor; set load.L = 4;")


def test_notes_are_no_errors_in_strict_mode(tmp_path):
    base = BASE.replace("set voltage = 2;", "observe load.coil.p;")
    path = tmp_path / "a.bg"
    path.write_text(f"{MODEL}{base}scene s is base {{ use load = Resistor; }}")
    model = bgc.compile(path, scene="s", strict=True)
    assert [d.code for d in model.warnings] == ["BG247"]
    assert [d.code for d in check_source(path)] == ["BG247"]


def test_a_chain_of_scenes_drops_what_any_of_them_removed():
    base = BASE.replace("set voltage = 2;", "observe load.coil.p;")
    text = f"{MODEL}scene c is b {{ run 1 s; }} scene b is base {{ use load = Resistor; }} {base}"
    graph = elaborate(load_text(text), "c")
    assert (graph.scene.duration, graph.scene.columns) == (1, ("current",))
    back = text.replace("scene c is b {", "scene c is b { use load = Coil; ")
    assert elaborate(load_text(back), "c").scene.columns == ("load.coil.p", "current")


def test_runs_as_the_scene_written_out(tmp_path):
    path = tmp_path / "a.bg"
    path.write_text(f"{MODEL}{BASE}scene s is base {{ use load = Resistor; }}")
    result = bgc.compile(path, scene="s").simulate()
    assert result["current"] == pytest.approx([1.0] * 5)  # 3*2 V over 1 + 5 ohm


def test_a_scene_of_an_imported_file_is_extended(tmp_path):
    (tmp_path / "sub").mkdir()
    base = BASE.replace(
        "drive gain = 3;", 'device d = trace(file = "a.csv"); drive gain = d.gripper;'
    )
    (tmp_path / "sub" / "base.bg").write_text(MODEL + base)
    rows = "time,x,y,z,gripper\n0,0,0,0,3\n9,0,0,0,3\n"
    (tmp_path / "sub" / "a.csv").write_text(rows)
    root = tmp_path / "root.bg"
    root.write_text('import "sub/base.bg";\nscene s is base { use load = Resistor; }\n')
    package = load(root)
    assert package.scene_names == ("s",)
    (device,) = elaborate(package).devices
    assert Path(dict(device.options)["file"]).as_posix() == "sub/a.csv"
    assert check_source(root, None) == []
    through = tmp_path / "through.bg"
    through.write_text('import "root.bg";\nscene base is base { }\n')
    assert [d.code for d in refused(through)] == ["BG245"]


def refused(path: Path):
    return refusals(load, path)


def test_an_imported_scene_of_two_files_is_ambiguous(tmp_path):
    (tmp_path / "m.bg").write_text(MODEL)
    for name in ("a", "b"):
        (tmp_path / f"{name}.bg").write_text(f'import "m.bg";\n{BASE}')
    root = tmp_path / "root.bg"
    root.write_text('import "a.bg";\nimport "b.bg";\nscene s of Circuit { }\n')
    load(root)  # two scenes of one name harm nobody who extends neither
    root.write_text('import "a.bg";\nimport "b.bg";\nscene s is base { }\n')
    assert [d.code for d in refused(root)] == ["BG246"]
    root.write_text('import "a.bg";\nimport "a.bg";\nscene s is base { }\n')
    load(root)


def test_too_long_a_line_is_refused():
    text = MODEL + BASE + "scene s0 is base { }\n"
    text += "".join(f"scene s{k} is s{k - 1} {{ }}\n" for k in range(1, 101))
    assert codes_of(load_text, text) == ["BG248"]


def test_options_change_a_derived_scene(tmp_path):
    path = tmp_path / "a.bg"
    path.write_text(f"{MODEL}{BASE}scene s is base {{ }}")
    model = bgc.compile(path, scene="s", uses={"load": "Resistor(R = 2)"})
    assert model.observe()["current"] == pytest.approx(2)
