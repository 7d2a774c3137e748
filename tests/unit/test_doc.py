"""`bgc doc`: an answer for every name, from the tables that the compiler reads."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from model_files import model_text

import bgc.grammar
from bgc.diagnostics.catalogue.pages import pages
from bgc.diagnostics.source import Source
from bgc.grammar import language_words
from bgc.grammar.parse import parse
from bgc.language.elements import ELEMENTS, Role
from bgc.language.scene_tables import ACCOUNTS, DEVICE_COMMANDS, DEVICE_INPUTS
from bgc.language.solver import SOLVER_OPTIONS
from bgc.reference import chapters
from bgc.reference.entry import Code, Entry, Text, first_sentence
from bgc.reference.index import find, names
from bgc.reference.library_entries import declarations, fitting
from bgc.reference.topics import topics
from bgc.resolution.library import library_modules
from bgc.runtime.cli.app import application
from bgc.runtime.cli.doc import all_groups
from bgc.runtime.documents.method_entries import METHODS
from bgc.values.functions import BUILTINS
from bgc.values.units import unit_table

OWN = model_text("doc_own")


def bgc_doc(*arguments: object) -> Result:
    return CliRunner().invoke(application, ["doc", *map(str, arguments)])


def described(name: str) -> tuple[Entry, ...]:
    """As the command finds it: topics and the manual last."""
    *others, guide, manual = all_groups()
    return find(name, others) or find(name, [guide, manual])


def text_of(entry: Entry) -> str:
    return " ".join(block.text for block in entry.body if isinstance(block, Text | Code))


# --- an answer for every name -------------------------------------------------------------------


@pytest.mark.parametrize("name", ELEMENTS)
def test_every_element_has_its_law_causality_and_arguments(name):
    (entry, *_) = described(name)
    assert entry.kind == "element"
    assert "Law: " in text_of(entry) and "Causality: " in text_of(entry)
    output = bgc_doc(name).stdout
    for argument in ELEMENTS[name].arguments:
        assert re.search(rf"^  {argument.name} ", output, re.MULTILINE)


@pytest.mark.parametrize("name", language_words.TABLE)
def test_every_word_says_what_it_is_for(name):
    entry = next(entry for entry in described(name) if entry.kind == "word")
    assert entry.summary and text_of(entry)


@pytest.mark.parametrize("name", BUILTINS)
def test_every_function_has_its_shapes_and_units(name):
    entry = next(entry for entry in described(name) if entry.kind == "function")
    assert text_of(entry).startswith(f"{name}(")
    output = bgc_doc("functions", name).stdout
    assert re.search(r"^  shape +\w", output, re.MULTILINE)
    assert re.search(r"^  unit +\w", output, re.MULTILINE)


@pytest.mark.parametrize("name", unit_table())
def test_every_unit_says_what_it_measures(name):
    entry = next(entry for entry in described(name) if entry.kind == "unit")
    assert re.fullmatch(r"\w[\w ]+, (SI|[\d.]+ \S+)", entry.summary)


@pytest.mark.parametrize("name", [*METHODS, "cvode", "auto"])
def test_every_method_says_what_it_is_for(name):
    (entry,) = described(name)
    assert entry.kind == "method" and entry.summary


@pytest.mark.parametrize("code", pages())
def test_every_code_has_its_page(code):
    (entry,) = described(code)
    assert entry.name == code and "Way out: " in text_of(entry)


@pytest.mark.slow
@pytest.mark.parametrize("module", library_modules())
def test_every_module_says_what_it_holds(module):
    (entry,) = described(module)
    assert entry.kind == "library module" and entry.summary


@pytest.mark.slow
@pytest.mark.parametrize("name", [d.full_name for d in declarations()])
def test_every_declaration_of_the_library_is_found_by_its_full_name_and_its_last(name):
    (entry,) = described(name)
    assert entry.summary or name.startswith("examples."), "it needs a /// comment"
    assert entry in described(name.rpartition(".")[2]) or len(described(entry.name)) == 1


@pytest.mark.parametrize("group", all_groups(), ids=lambda group: group.name)
def test_every_group_lists_its_names(group):
    output = bgc_doc(group.name).stdout
    for name in group.summaries():
        listed = {"library": library_modules(), "topics": [t.names[0] for t in topics()]}
        if name in listed.get(group.name, (name,)):
            assert f"  {name}" in output
    for alias in group.aliases:
        assert group.overview() in described(alias)


@pytest.mark.slow
def test_every_see_also_leads_somewhere():
    for group in all_groups():
        if group.name == "library":
            continue
        for name in group.summaries():
            for other in group.entry(name).see_also:
                assert described(other), (name, other)


# --- the tables -----------------------------------------------------------------------------------


def test_the_words_are_those_of_the_grammar():
    grammar = (Path(bgc.grammar.__file__).parent / "bgc.lark").read_text()
    terminals = re.findall(r"^([A-Z]+)(?:\.\d+)?: /(\w+)\(\?[!=]", grammar, re.MULTILINE)
    assert {word for _, word in terminals} == set(language_words.TABLE)
    (reserved,) = re.findall(r"^NAME: /\(\?!\(\?:([\w|]+)\)", grammar, re.MULTILINE)
    assert set(reserved.split("|")) == language_words.RESERVED


def test_every_form_and_example_of_a_word_is_of_the_language():
    """Examples are parsed where the word may stand; `..` stands for what is left out."""
    frames = {
        "file": "{}",
        "model": "model M {{ {} }}",
        "scene": "scene s of M {{ {} }}",
        "domain": "domain D {{ {} }}",
    }
    for word in language_words.TABLE.values():
        if not word.example or ".. }" in word.example:
            continue
        wrong = []
        for frame in frames.values():
            _, diagnostics = parse(Source("example.bg", frame.format(word.example)))
            wrong.append([d.message for d in diagnostics])
        assert [] in wrong, (word.word, wrong)


@pytest.mark.parametrize("name", ELEMENTS)
def test_every_way_to_write_an_element_is_of_the_language(name):
    for written in ELEMENTS[name].written:
        statement = written if written.endswith(";") else f"part : {written};"
        if "= .." in written:
            continue
        if statement.endswith("};"):
            statement = statement[:-1]
        _, diagnostics = parse(Source("m.bg", f"model M {{ {statement} }}"))
        assert [d.message for d in diagnostics] == []


def test_an_element_takes_each_of_its_arguments(tmp_path):
    """And no other one: BG230 lists those of the table."""
    for kind in ELEMENTS.values():
        for argument in kind.arguments:
            if argument.role is Role.INITIAL and not any(
                a.role is Role.LAW for a in kind.arguments
            ):
                continue
            path = tmp_path / "m.bg"
            law = "" if argument.role is not Role.INITIAL else f", {kind.arguments[0].name} = 1"
            ends = "a -> x -> b;" if kind.sides == ("in", "out") else "a -> x; a -> b;"
            path.write_text(
                f"model M {{ a : J1; b : R(1); s : Se(e = 1); s -> a; "
                f"x : {kind.name}({argument.name} = 1{law}); {ends} }}\n"
                "scene s of M { observe a.f; run 1 s; }\n"
            )
            result = CliRunner().invoke(application, ["check", str(path)])
            assert "BG230" not in result.stderr and "BG446" not in result.stderr, result.stderr


@pytest.mark.parametrize(
    ("topic", "table"),
    [
        ("solver", SOLVER_OPTIONS),
        ("energy", ACCOUNTS),
        ("devices", {**DEVICE_INPUTS, **DEVICE_COMMANDS}),
    ],
)
def test_what_scenes_name_is_listed(topic, table):
    output = bgc_doc(topic).stdout
    for name in table:
        assert re.search(rf"^  {name} ", output, re.MULTILINE)


# --- looking up -----------------------------------------------------------------------------------


def test_a_name_of_several_things_shows_all_of_them():
    assert [entry.kind for entry in described("min")] == ["function", "unit"]
    assert [entry.kind for entry in described("C")] == ["element", "unit"]
    assert bgc_doc("units", "C").stdout.count("(element)") == 0


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("tf", "TF"),
        ("bg301", "BG301"),
        ("301", "BG301"),
        ("beam", "crane.beam.Beam"),
        ("kN*m", "kN*m"),
        ("mbar", "mbar"),
    ],
)
def test_names_are_found_in_other_case_and_form(name, found):
    assert found in [entry.name for entry in described(name)]


@pytest.mark.parametrize(
    ("name", "suggested"),
    [
        ("Baem", "did you mean `beam`"),
        ("rodas5", "did you mean `rodas5p`"),
        ("obsrve", "did you mean `observe`"),
        ("atan3", "`atan2`"),
        ("BG5O1", "BG501"),
        ("qqqqq", "`bgc doc` lists what there is"),
    ],
)
def test_a_slip_gets_a_suggestion(name, suggested):
    result = bgc_doc(name)
    assert result.exit_code == 1
    assert "error[BG040]" in result.stderr and suggested in result.stderr


def test_a_word_lists_what_mentions_it():
    result = bgc_doc("valve")
    assert result.exit_code == 0 and re.search(r"^  R ", result.stdout, re.MULTILINE)


def test_without_a_name_all_groups_are_listed():
    output = bgc_doc().stdout
    for group in all_groups():
        if group.summaries():
            assert f"\n{group.name}: {group.title}" in output


def test_all_names_of_the_language_can_be_looked_up():
    for name in names([g for g in all_groups() if g.name not in {"library", "diagnostics"}]):
        assert described(name), name


def test_a_file_of_ones_own(tmp_path):
    path = tmp_path / "own.bg"
    path.write_text(OWN)
    output = bgc_doc(path).stdout
    assert "What this file is for." in output and re.search(r"^  Motor +A motor$", output, re.M)
    output = bgc_doc(path, "Motor", "double").stdout
    assert re.search(r"^  k +N\*m/A +0.1 N\*m/A +0 N\*m/A .. 1 N\*m/A", output, re.MULTILINE)
    assert re.search(r"^  brake +Lock\[1\] +Rigid\[1\] +What holds it\.$", output, re.MULTILINE)
    assert "let twice = 2*k;\n" in output and "function double(x) = 2*x;\n" in output
    assert "What this file is for" not in output
    result = bgc_doc(path, "Motr")
    assert result.exit_code == 1 and "error[BG041]" in result.stderr
    assert "did you mean `Motor`" in result.stderr


def test_a_file_with_a_mistake_or_that_is_not_there(tmp_path):
    path = tmp_path / "wrong.bg"
    path.write_text("model M { x : Nothing; }")
    assert "error[BG201]" in bgc_doc(path).stderr
    assert "error[BG001]" in bgc_doc(tmp_path / "none.bg").stderr


def clear_chapters() -> None:
    chapters._chapters.cache_clear()
    chapters._sections.cache_clear()


def test_chapters_of_the_manual(monkeypatch, tmp_path):
    (tmp_path / "manual").mkdir()
    (tmp_path / "LANGUAGE.md").write_text(
        "# The language\n\n1. [Wide bonds](manual/wide.md)\n2. [Units](manual/units.md)\n"
    )
    (tmp_path / "manual/wide.md").write_text(
        "# Wide bonds\n\nA *wide* bond ([units](units.md)) of `n`.\n\n"
        "| a | b |\n|---|---|\n| `1` | 2\\|3 |\nAfter.\n\n"
        "## Slices\n\n- one\n  more\n- two\n\n```bg model\nx : J1;\n\ny : J1;\n```\n"
    )
    (tmp_path / "manual/units.md").write_text("# Units\n\nU.\n")
    monkeypatch.setattr(chapters.resources, "files", lambda package: tmp_path)
    clear_chapters()
    try:
        assert list(chapters.GROUP.summaries()) == ["wide-bonds", "units"]
        output = bgc_doc("wide", "bonds").stdout
        assert output == (
            "wide-bonds  (chapter)\nWide bonds.\n\nA wide bond (units) of `n`.\n\n"
            "  a    b\n  `1`  2|3\n\nAfter.\n\nSlices\n\n- one more\n\n- two\n\n"
            "  x : J1;\n\n  y : J1;\n"
        )
        section = bgc_doc("slices").stdout
        assert section.startswith("slices  (section)\nSlices.\n\n- one more\n")
        assert section.endswith("See also: manual wide-bonds\n")
        assert "See also: manual units" in bgc_doc("units").stdout
        assert bgc_doc("manual", "units").stdout.startswith("units  (chapter)")
    finally:
        clear_chapters()


@pytest.mark.parametrize("arguments", [["--out", "x"], ["--library", "TF"], ["--nothing"]])
def test_wrong_usage_is_status_2(arguments):
    assert bgc_doc(*arguments).exit_code == 2


# --- printing -------------------------------------------------------------------------------------


@pytest.mark.parametrize("columns", [80, 200])
@pytest.mark.parametrize("name", ["TF", "Vessel", "methods", "HydraulicDrive", "units", "BG301"])
def test_it_fits_the_terminal_and_is_plain_in_a_pipe(name, columns, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    output = bgc_doc(name).stdout
    assert max(map(len, output.splitlines())) <= columns
    assert "\x1b" not in output and output.isascii()
    assert all(line == line.rstrip() for line in output.splitlines())


def test_looking_up_an_element_imports_nothing_heavy():
    heavy = {"scipy", "sympy", "numpy", "matplotlib", "lark", "jinja2"}
    script = (
        "import sys\nfrom bgc.runtime.cli.app import application\n"
        "try:\n    application.main(['doc', 'TF'])\nexcept SystemExit:\n    pass\n"
        f"print(sorted(set(sys.modules) & {heavy!r}))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("A beam (Fig. 4): x. More.", "A beam (Fig. 4): x"),
        ("Eq. 3 of a\nbody. B", "Eq. 3 of a body"),
        ("No stop", "No stop"),
        ("At 0.5 s. Then", "At 0.5 s"),
    ],
)
def test_the_first_sentence(text, first):
    assert first_sentence(text) == first


def test_an_example_is_not_what_parts_of_its_names_are():
    """The library has an interface `Drive` and an example a model of that name."""
    assert fitting("examples.backlash.Drive") == ()
    assert "RateDrive" in fitting("mechanics.actuators.Drive")
