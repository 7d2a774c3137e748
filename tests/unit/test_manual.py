"""The manual of the language: every block in it compiles, and every command prints what it shows.

Conventions of the fenced blocks, by the words of their info string (a viewer reads the first only):

- `bg`: a complete file in the form that `bgc fmt` gives it. It is checked, and each of its scenes
  is run; a warning is a failure.
- `bg NAME.bg`: the same, and saved under that name for commands and imports.
- `bg model`: statements of a model, checked within `model Fragment { .. }`.
- `bg .. error BG123`, `bg .. warning BG123`: gives that diagnostic, and no other.
- `csv NAME.csv`, `text NAME.1`: a data file, saved under that name.
- `console`: lines `$ bgc ..`, each followed by what it prints. Numbers are compared to the digits
  shown; a line `...` stands for any lines, a run of blanks for any other.
- `python`: runs.
- `text`: is not read.

README.md is held to the same for its `bg` blocks.
"""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from manual import FOLDER, INDEX, ROOT, chapter_files, whole_manual
from own_caches import with_runtime

import bgc
from bgc.building.backends import BACKENDS
from bgc.diagnostics.catalogue.pages import pages
from bgc.diagnostics.diagnostic import BgError, Severity
from bgc.grammar.language_words import RESERVED, SCENE_WORDS, WORDS
from bgc.grammar.syntax import Part, Port, Value
from bgc.language.elements import ELEMENTS
from bgc.language.methods import METHODS
from bgc.resolution.modules import ancestors
from bgc.resolution.resolve import library_folder, library_modules, load_text
from bgc.runtime.cli.app import application
from bgc.values import units
from bgc.values.functions import BUILTINS

FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SCENE = re.compile(r"^scene (\w+)", re.MULTILINE)
NUMBER = re.compile(r"[-+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")


@dataclass(frozen=True)
class Block:
    """A fenced block: where it stands, its info string, its text."""

    place: str
    language: str
    words: tuple[str, ...]
    text: str

    @property
    def name(self) -> str:
        """The name under which it is saved, or an empty text."""
        saved = (".bg", ".csv", ".1", ".3", ".hst", ".gdf")
        return next((w for w in self.words if w.endswith(saved)), "")

    @property
    def code(self) -> str:
        """The code of the diagnostic that it must give, or an empty text."""
        return self.words[-1] if {"error", "warning"} & {*self.words} else ""


def blocks(path: Path) -> Iterator[Block]:
    text = path.read_text("utf-8")
    for found in FENCE.finditer(text):
        language, *words = found[1].split() or [""]
        line = text.count("\n", 0, found.start()) + 1
        place = f"{path.parent.name}/{path.name}:{line}"
        yield Block(place, language, tuple(words), found[2])


IN_MANUAL = [block for path in chapter_files() for block in blocks(path)]
ALL = [*IN_MANUAL, *blocks(ROOT / "README.md")]


def of(*languages: str) -> list[Block]:
    return [block for block in ALL if block.language in languages]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with the files that the manual names."""
    made = tmp_path_factory.mktemp("manual")
    with_runtime(made / "cache")
    for block in ALL:
        if block.name:
            (made / block.name).write_text(block.text)
    return made


@pytest.fixture(autouse=True)
def inside(folder, monkeypatch) -> None:
    monkeypatch.setenv("BGC_CACHE_DIR", str(folder / "cache"))
    monkeypatch.chdir(folder)


def codes_of(path: str) -> list[str]:
    """The codes of the errors and warnings that `bgc check` reports for a file."""
    done = CliRunner().invoke(application, ["check", path])
    assert done.exit_code in (0, 1), done.output
    return re.findall(r"^(?:error|warning)\[(BG\d+)\]", done.output, re.MULTILINE)


@pytest.mark.slow
@pytest.mark.parametrize("block", of("bg"), ids=lambda block: block.place)
def test_block_of_the_language_compiles_and_runs(block):
    name = block.name or "block.bg"
    text = f"model Fragment {{\n{block.text}}}\n" if "model" in block.words else block.text
    Path(name).write_text(text)
    assert CliRunner().invoke(application, ["fmt", "--check", name]).exit_code == 0
    if block.code:
        assert codes_of(name) == [block.code]
        if "error" in block.words:
            return
    else:
        assert codes_of(name) == []
    for scene in SCENE.findall(text):
        try:
            model = bgc.compile(name, scene=scene, preview=True)
            result = model.simulate()
        except BgError as err:
            pytest.fail(f"{block.place}, scene {scene}: {err.diagnostics}")
        assert len(result.time) > 1 and not result.warnings
        warned = [d.code for d in model.warnings if d.severity is Severity.WARNING]
        assert warned == ([block.code] if block.code else [])


def commands(block: Block) -> Iterator[tuple[str, list[str]]]:
    """The commands of a console block, each with the lines that it prints."""
    command, printed = "", []
    for line in block.text.splitlines():
        if line.startswith("$ "):
            if command:
                yield command, printed
            command, printed = line.removeprefix("$ "), []
        else:
            printed.append(line)
    yield command, printed


def agrees(shown: str, found: str) -> bool:
    """Return whether a line is as shown: the words alike, numbers to the digits shown."""
    if NUMBER.sub("#", " ".join(shown.split())) != NUMBER.sub("#", " ".join(found.split())):
        return False
    return all(
        abs(float(a.replace(",", "")) - float(b.replace(",", ""))) <= _last_digit(a)
        for a, b in zip(NUMBER.findall(shown), NUMBER.findall(found), strict=True)
    )


def _last_digit(number: str) -> float:
    """One in the last digit of a number as written; nothing for a whole one."""
    mantissa, _, exponent = number.partition("e")
    digits = len(mantissa.partition(".")[2])
    return 1.01 * 10.0 ** (int(exponent or 0) - digits) if digits or exponent else 0.0


def matches(shown: list[str], found: list[str]) -> bool:
    """Return whether lines are as shown, `...` standing for any number of them."""
    if not shown:
        return not found
    first, *rest = shown
    if first == "...":
        return any(matches(rest, found[k:]) for k in range(len(found) + 1))
    return bool(found) and agrees(first, found[0]) and matches(rest, found[1:])


@pytest.mark.slow
@pytest.mark.parametrize("block", of("console"), ids=lambda block: block.place)
def test_command_prints_what_is_shown(block):
    for command, shown in commands(block):
        program, *arguments = shlex.split(command)
        assert program == "bgc"
        done = CliRunner().invoke(application, arguments)
        found = [line.rstrip() for line in done.output.splitlines()]
        assert matches(shown, found), f"{command}\n{done.output}"


@pytest.mark.parametrize("path", chapter_files(), ids=lambda path: path.stem)
def test_python_runs(path):
    """The blocks of a chapter, one after the other; a block may name packages that it needs."""
    names: dict[str, object] = {}
    for block in blocks(path):
        if block.language == "python":
            for package in block.words:
                pytest.importorskip(package)
            exec(compile(block.text, block.place, "exec"), names)


# --- everything is there, and can be found ------------------------------------------------


def headings(text: str) -> list[tuple[int, str]]:
    found = re.findall(r"^(#{1,3}) (.+)$", FENCE.sub("", text), re.MULTILINE)
    return [(len(marks), title) for marks, title in found]


def anchor(title: str) -> str:
    """The anchor that GitHub gives a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def anchors(path: Path) -> list[str]:
    return [anchor(title) for _, title in headings(path.read_text("utf-8"))]


@pytest.mark.parametrize("path", [INDEX, *chapter_files()], ids=lambda path: path.stem)
def test_every_link_leads_to_a_file_or_a_heading(path):
    text = re.sub("`[^`]*`", "", FENCE.sub("", path.read_text("utf-8")))
    links = re.findall(r"\]\((?!https?:)([^()#\s]*)(?:#([^()\s]+))?\)", text)
    for name, at in links:
        target = (path.parent / name).resolve() if name else path
        assert target.is_file(), name
        assert not at or anchors(target).count(at) == 1, f"{name}#{at}"


def test_the_index_lists_every_chapter():
    assert {*chapter_files()} == {*FOLDER.glob("*/*.md")}
    listed = re.findall(r"^\d+\. \[(.+)\]\(", INDEX.read_text("utf-8"), re.MULTILINE)
    titles = [headings(path.read_text("utf-8"))[0] for path in chapter_files()]
    assert titles == [(1, title) for title in listed]


def test_chapters_and_their_sections_have_different_titles():
    """So that `bgc doc TITLE` finds one."""
    found = [t for path in chapter_files() for n, t in headings(path.read_text("utf-8")) if n < 3]
    assert sorted(t for t in {*found} if found.count(t) > 1) == []


def test_chapters_and_the_reference_are_short():
    words = {path: len(path.read_text("utf-8").split()) for path in chapter_files()}
    assert max(words.values()) <= 6_000
    assert sum(n for path, n in words.items() if path.parent.name == "reference") <= 20_000


def test_each_row_of_a_table_has_as_many_cells_as_its_head():
    text = FENCE.sub("", whole_manual())
    for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        assert len({row.count("|") for row in table.splitlines()}) == 1, table


def findable() -> set[str]:
    """The words in code marks of headings and of first columns of tables."""
    text = FENCE.sub("", whole_manual())
    rows = re.findall(r"^\| ([^|]*) \|", text, re.MULTILINE)
    cells = [*rows, *(title for _, title in headings(text))]
    code = [part for cell in cells for part in re.findall(r"`([^`]+)`", cell)]
    return {word for part in code for word in [part, *part.split()[:1]]}


def methods() -> set[str]:
    """The names of the integration methods, those of backends among them."""
    return {*(method.name for method in METHODS.values()), *BACKENDS}


@pytest.mark.parametrize(
    "names",
    [
        ELEMENTS,
        {*BUILTINS, "block", "der"},
        {*WORDS["scene"], *WORDS["model"], *WORDS["file"]} - {"pseudo", "scene", "model"},
        {*units._WITH_PREFIX, *units._WITHOUT_PREFIX},
        {*units.PREFIXES},
        methods() | {"auto"},
    ],
    ids=["elements", "functions", "statements", "units", "prefixes", "methods"],
)
def test_everything_has_a_heading_or_a_row(names):
    assert sorted({*names} - findable()) == []


def table_after(heading: str) -> list[list[str]]:
    """The cells of the first table after a heading or a line, its head left out."""
    after = whole_manual().partition(f"\n{heading}")[2]
    rows = re.search(r"(?:^\|.*\n)+", after, re.MULTILINE)
    assert rows is not None
    cut = [re.split(r" ?\| ?", line.strip("|").strip()) for line in rows[0].splitlines()]
    return [row for row in cut if not row[0].startswith("---")][1:]


def test_methods_are_listed_with_their_steps_and_orders():
    listed = {row[0].strip("`"): (row[1], row[2]) for row in table_after("# Solvers")}
    for method in METHODS.values():
        steps = "fixed" if method.fixed else "adaptive"
        assert listed[method.name] == (steps, str(method.order))


def modules_listed() -> list[str]:
    """The modules of the library that the manual lists."""
    return [
        name
        for row in table_after("# Modules of the library")
        for name in re.findall("`(.*?)`", row[0])
    ]


def test_every_module_of_the_library_is_listed():
    parts = [
        module
        for module in library_modules()
        if not SCENE.search((library_folder() / f"{module.replace('.', '/')}.bg").read_text())
    ]
    assert sorted(modules_listed()) == parts


@cache
def library_models():
    imports = "".join(f"import {module};\n" for module in modules_listed())
    return load_text(imports).root.models


@pytest.mark.parametrize(
    "row", table_after("## Bodies and joints of the library"), ids=lambda row: row[0]
)
def test_parts_of_the_library_have_what_is_listed(row):
    models = library_models()
    parts, *listed = (re.findall(r"`(.*?)`", cell) for cell in row)
    for part in parts:
        items = [item for model in ancestors(models[part]) for item in model.syntax.items]
        have = {item.name for item in items if isinstance(item, Value | Port | Part)}
        assert {name for names in listed for name in names} <= have


@pytest.mark.parametrize("row", table_after("## How a unit is written"), ids=lambda row: row[0])
def test_units_shown_as_wrong_are_refused(row):
    wrong = row[0].strip("`")
    Path("block.bg").write_text(f"model M {{ const x = 1; state y = {wrong}; der(y) = 0; }}")
    assert codes_of("block.bg")


@pytest.mark.parametrize(
    "row", table_after("## Laws of transformers and gyrators"), ids=lambda row: row[0]
)
def test_laws_of_two_ports_have_the_ratio_shown(row):
    law, ratio = row[0].strip("`"), row[2].replace("'", "")
    values = {"m": 3.0, "w": 4.0, "r": 5.0, "g": 6.0}
    given = " ".join(f"const {name} = {value};" for name, value in values.items())
    Path("block.bg").write_text(
        f"model M {{ {given} s : Sf(1); t : {law} l : R(2); s -> t -> l; }}"
        "scene s of M { observe t.e1, t.f1, t.e2, t.f2; run 1; }"
    )
    last = bgc.compile("block.bg", preview=True).simulate()
    e1, f1, e2, f2 = (last[f"t.{name}"][-1] for name in ("e1", "f1", "e2", "f2"))
    found = (f2 / f1, e1 / e2) if law.startswith("TF") else (e2 / f1, e1 / f2)
    assert found == pytest.approx([eval(ratio, values)] * 2)


def test_every_code_that_is_named_has_a_page():
    text = whole_manual()
    ranges = re.findall(r"BG(\d{3}) - BG(\d{3})", text)
    named = {*re.findall(r"BG\d{3}", text)} - {f"BG{end}" for pair in ranges for end in pair}
    assert sorted(named - pages().keys()) == []
    outside = [c for c in pages() if not any(low <= c[2:] <= high for low, high in ranges)]
    assert outside == []


def test_the_reserved_words_are_those_of_the_grammar():
    chapter = whole_manual().partition("## Reserved words")[2].partition("\n#")[0]
    everywhere, in_scenes, _ = re.split(r"\n(?=[A-Z])", chapter.strip())
    assert set(re.findall(r"`(\w+)`", everywhere)) == RESERVED
    assert set(re.findall(r"`(\w+)`", in_scenes.partition(":")[2])) == SCENE_WORDS


def test_the_manual_is_in_the_package():
    packaged = resources.files("bgc.grammar")
    for path in (INDEX, *chapter_files()):
        name = path.relative_to(INDEX.parent).as_posix()
        assert packaged.joinpath(name).read_text("utf-8") == path.read_text("utf-8")


def test_examples_of_the_studies_are_of_files_and_names_of_the_manual(folder) -> None:
    names = ("sweep", "fit", "optimise", "operability")
    found = [application.get_command(click.Context(application), name) for name in names]
    epilogs = [command.epilog.replace("\\\n", "") for command in found]
    examples = [shlex.split(line) for text in epilogs for line in text.splitlines()]
    examples = [words for words in examples if words[:1] == ["bgc"]]
    assert len(examples) >= 9
    known = {}
    for _, _, file, *options in examples:
        if file not in known:
            known[file] = {*bgc.compile(folder / file, preview=True).parameters}
        given = dict(zip(options[::2], options[1::2], strict=False))
        assert (folder / given.get("--data", file)).exists()
        for option in ("--vary", "--over", "--height", "--period", "--seed"):
            name = given.get(option, "").partition("=")[0]
            assert not name or name in known[file]
