"""Files, their imports, and the names that each of them sees."""

from pathlib import Path

import pytest
from refusals import refusal

from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.elaborate import elaborate
from bgc.resolution.resolve import library_modules, load, load_text


def write(folder, **files: str) -> None:
    for name, text in files.items():
        (folder / f"{name}.bg").write_text(text)


def test_imported_names_are_seen_through_imports(tmp_path):
    write(
        tmp_path,
        top='import "middle.bg";\nmodel M { output y = twice(base) + mid; }',
        middle='import "deep.bg"; const mid = 1;',
        deep="const base = 3; function twice(a) = 2*a;",
    )
    package = load(tmp_path / "top.bg")
    assert [file.path.name for file in package.files] == ["deep.bg", "middle.bg", "top.bg"]
    assert package.sources[-1].text.startswith("import")
    graph = elaborate(package)
    assert graph.dag.value(graph.observations[0].node) == 7


def test_one_file_reached_twice_is_one_file(tmp_path):
    write(
        tmp_path,
        top='import "a.bg"; import "b.bg"; model M { output y = c; }',
        a='import "c.bg";',
        b='import "c.bg";',
        c="const c = 1;",
    )
    assert len(load(tmp_path / "top.bg").modules) == 4


def test_a_file_that_changed_is_read_again(tmp_path):
    write(tmp_path, top='import "part.bg"; model M { output y = k; }', part="const k = 1;")
    values = []
    for text in ("const k = 1;", "const k = 2;", "const k = 1;"):
        write(tmp_path, part=text)
        graph = elaborate(load(tmp_path / "top.bg"))
        values.append(graph.dag.value(graph.observations[0].node))
    assert values == [1, 2, 1]


def test_names_mean_what_they_mean_in_their_own_file(tmp_path):
    write(
        tmp_path,
        top='import "part.bg"; model M { p : Part; output y = p.y; const k = 5; }',
        part="const hidden = 2; model Part { output y = hidden; }",
    )
    graph = elaborate(load(tmp_path / "top.bg"))
    assert graph.dag.value(graph.observations[0].node) == 2


def test_folders_and_paths(tmp_path):
    (tmp_path / "parts").mkdir()
    write(tmp_path, top='import "parts/a.bg"; model M { output y = a; }')
    write(tmp_path / "parts", a='import "b.bg"; const a = b;', b="const b = 4;")
    graph = elaborate(load(tmp_path / "top.bg"))
    assert graph.dag.value(graph.observations[0].node) == 4


def test_library_modules_are_imported_by_name():
    assert "crane.beam" in library_modules()
    package = load_text("import crane.beam; model M { output y = gravity; }")
    assert {source.name for source in package.sources} >= {"library/crane/beam.bg", "<text>"}


def test_a_missing_file_that_the_library_has_is_named():
    with pytest.raises(BgError, match=r"the library has a scene of this name: `.*scenes.ur5.bg`"):
        load(Path("no", "folder", "ur5.bg"))
    with pytest.raises(BgError, match="check the path"):
        load(Path("no", "folder", "ur55.bg"))


def test_domains_of_the_library_are_named():
    text = "model M { port a : Frame; port b : Rod; }"
    with pytest.raises(BgError) as caught:
        load_text(text)
    frame, rod = caught.value.diagnostics
    assert frame.help.endswith("`import mechanics.frame;`")
    assert frame.edits[0].text == "import mechanics.frame;\n"
    assert "`Rotational`, `Thermal`, `Translational`" in rod.help and "Water" not in rod.help


def test_near_names_are_suggested():
    with pytest.raises(BgError) as caught:
        load_text("import crane.baem;")
    assert "`crane.beam`" in caught.value.diagnostics[0].help
    with pytest.raises(BgError) as caught:
        load_text("interface Beam {} model M { boom : Beem; }")
    assert "`Beam`" in caught.value.diagnostics[0].help


def test_mistakes_of_all_files_come_together(tmp_path):
    write(
        tmp_path,
        top='import "a.bg"; import "b.bg"; model M { x : Nothing; }',
        a="model A { x : Missing; }",
        b="model B {",
    )
    with pytest.raises(BgError) as caught:
        load(tmp_path / "top.bg")
    named = {d.span.source.name.rpartition("/")[2] for d in caught.value.diagnostics if d.span}
    assert named == {"top.bg", "a.bg", "b.bg"}


def test_three_files_that_import_each_other(tmp_path):
    write(tmp_path, a='import "b.bg";', b='import "c.bg";', c='import "a.bg";')
    problem = refusal(load, tmp_path / "a.bg")
    assert problem.message.count(".bg") == 4


def test_types_and_values_are_two_namespaces():
    graph = elaborate(load_text("model M { param R = 2; s : Se(e = 1); r : R(R); s -> r; }"))
    assert len(graph.elements) == 2
