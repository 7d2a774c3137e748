"""Analysis of texts for editors: places, names, completion, hover, rename, and broken texts."""

import random
from pathlib import Path

import pytest

from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.editing.completion import complete
from bgc.editing.documents import Documents
from bgc.editing.facts import facts_of
from bgc.editing.file_analysis import analyse
from bgc.editing.hints import hints
from bgc.editing.hover import hover
from bgc.editing.lines import Lines
from bgc.editing.moves import moving
from bgc.editing.outline import outline
from bgc.editing.rename import applied, references, rename
from bgc.options import Options
from bgc.resolution.library import library_folder

LIBRARY = sorted(library_folder().rglob("*.bg"))
TEXT = """import mechanics.lock;

interface Brake { port shaft; }
model Disc is Brake { param friction = 2 N*m*s; port shaft; r : R(friction); shaft -> r; }

/// A wheel.
model Wheel[n = 1] {
  param mass = 3 kg in 1 kg .. 9 kg;
  port rim out : Frame;
  body : I(mass);
  brake : Brake = Disc;
  for k in 1..n { spoke[k] : C(k); }
}

scene spin of Wheel {
  device hand = trace(file = "a.csv");
  use brake = Disc(friction = 3 N*m*s);
  set brake.friction = 1 N*m*s;
  observe body.p as momentum, brake.friction, hand.position, energy.stored;
  plot momentum;
  run 1 s every 10 ms;
}
"""


@pytest.fixture(scope="module")
def documents():
    return Documents()


@pytest.fixture
def wheel(documents, tmp_path):
    path = tmp_path / "wheel.bg"
    documents.open(path, TEXT)
    return analyse(path, documents)


# --- places -------------------------------------------------------------------------------


def test_columns_count_the_units_of_the_encoding():
    text = "aé𝄞b\r\nc\rd\n"
    at = text.index("b")
    assert Lines(text, "utf-16").position(at) == (0, 4)
    assert Lines(text, "utf-8").position(at) == (0, 7)
    assert Lines(text, "utf-32").position(at) == (0, 3)
    assert Lines(text).position(text.index("d")) == (2, 0)
    assert Lines(text).end() == (3, 0)
    for encoding in ("utf-8", "utf-16", "utf-32"):
        lines = Lines(text, encoding)
        for offset in range(len(text) + 1):
            if text[offset - 1 : offset + 1] != "\r\n":
                assert lines.offset(lines.position(offset)) == offset
    assert Lines(text).offset((0, 3)) == 2  # between the halves of the clef
    assert Lines(text).offset((9, 9)) == len(text) and Lines(text).offset((0, 99)) == 4


def test_places_move_with_an_edit():
    move = moving("one two three", "one twenty three")
    assert (move(4), move(8), move(13)) == (4, 11, 16)
    assert moving("abcdef", "abXef")(3) is None
    assert moving("same", "same")(2) == 2


# --- names --------------------------------------------------------------------------------


def test_every_name_of_the_library_is_resolved(documents):
    unknown = {}
    for path in LIBRARY:
        analysis = analyse(path, documents)
        assert not analysis.diagnostics, path
        text = analysis.document.source.text
        for each in analysis.occurrences:
            owner = text[: each.span.start].rpartition("\n")[2]
            is_member = owner.endswith(".")
            if each.symbol is None and not is_member:
                unknown.setdefault(path.name, []).append(each.span.text)
    assert not unknown


def test_a_definition_is_in_the_file_that_declares_it(wheel, documents):
    def defined(text: str, inside: int = 0):
        found = wheel.definition(TEXT.index(text) + inside)
        return found and (Path(found.source.name).name, found.text)

    assert defined("Disc(friction") == ("wheel.bg", "Disc")
    assert wheel.definition(TEXT.index("friction = 3")).start == TEXT.index("friction = 2")
    assert wheel.definition(TEXT.index(".friction,") + 1).start == TEXT.index("friction = 2")
    assert wheel.definition(TEXT.index("momentum;")).start == TEXT.index("momentum,")
    assert wheel.definition(TEXT.index("k);")).start == TEXT.index("k in")
    assert defined("mechanics.lock", 3) == ("lock.bg", "")
    assert defined("R(friction)") is None
    path = library_folder() / "scenes/two_beam_crane.bg"
    crane = analyse(path, documents)
    text = crane.document.source.text
    use = crane.definition(text.index("crane.reach") + 2)
    assert use.source.name.endswith("session.bg") and use.text == "crane"


def test_references_are_found_in_files_that_import(documents, tmp_path):
    part, whole = tmp_path / "part.bg", tmp_path / "whole.bg"
    documents.open(part, "model Spring { param k = 1; port a; s : C(k); a -> s; }")
    documents.open(
        whole, 'import "part.bg";\nmodel A { s : Spring(k = 2); j : Se(1); j -> s; let q = s.k; }'
    )
    here = analyse(part, documents)
    symbol = here.at(here.document.source.text.index("k = 1")).symbol
    found = references(symbol, here, [whole], documents)
    assert [Path(span.source.name).name for span in found] == ["part.bg"] * 2 + ["whole.bg"] * 2


# --- rename -------------------------------------------------------------------------------


def renamed(analysis, text: str, name: str, inside: int = 0) -> str:
    source = analysis.document.source
    offset = source.text.index(text) + inside
    edits = rename(
        analysis, offset, name, [], analysis.documents,
        lambda path: not path.is_relative_to(library_folder()),
    )  # fmt: skip
    return applied(source.text, edits)


def test_a_rename_changes_every_use_and_nothing_else(wheel):
    assert renamed(wheel, "friction = 2", "drag") == TEXT.replace("friction", "drag")
    expected = TEXT.replace("Disc", "Plate")
    assert renamed(wheel, "Disc is", "Plate") == expected
    # A port of an interface is one symbol with those that implement it.
    assert renamed(wheel, "shaft -> r", "axle") == TEXT.replace("shaft", "axle")
    assert renamed(wheel, "momentum;", "spin_") == TEXT.replace("momentum", "spin_")
    assert renamed(wheel, "hand.position", "grip") == TEXT.replace("hand", "grip")


@pytest.mark.parametrize(
    ("text", "name", "code"),
    [
        ("friction = 2", "shaft", "BG135"),  # the name of a port of the same model
        ("friction = 2", "r", "BG135"),
        ("mass = 3", "n", "BG135"),
        ("mass = 3", "port", "BG133"),
        ("mass = 3", "7a", "BG133"),
        ("mass = 3", "a b", "BG133"),
        ("mechanics.lock", "x", "BG134"),
        ("R(friction)", "x", "BG134"),
        ("Wheel[", "Disc", "BG135"),
        ("Wheel[", "J0", "BG135"),
        ("Frame", "Other", "BG134"),
        ("momentum;", "run", "BG133"),
    ],
)
def test_a_rename_that_changes_the_meaning_is_refused(wheel, text, name, code):
    with pytest.raises(BgError) as refused:
        renamed(wheel, text, name)
    assert refused.value.diagnostics[0].code == code
    assert refused.value.diagnostics[0].help


# --- completion ---------------------------------------------------------------------------

COMPLETED = {
    "|": ({"model", "import", "scene"}, {"run", "R"}),
    "import mechanics.|": ({"joints", "lock"}, {"crane.beam"}),
    "model A { | }": ({"param", "port", "for"}, {"observe", "model"}),
    "model A { a : | }": ({"R", "MTF", "Beam"}, {"param"}),
    "model A { a : I(| }": ({"inertia", "p0", "sin"}, {"R"}),
    "model A { a : I; b : J1; let x = 1; a -> | }": ({"a", "b"}, {"x", "sin"}),
    "model A { port p : | }": ({"Frame"}, {"R", "Beam"}),
    "model A { a : C(1); let x = a.| }": ({"q", "e", "power"}, {"p", "a"}),
    "model A { param m = 3 | }": ({"kg", "kN", "in"}, {"m.", "a"}),
    "model A { param m : | }": ({"kg", "m"}, {"param"}),
    "model A { param | }": (set(), {"R", "sin", "A"}),
    "scene s of A { | }": ({"run", "observe", "set"}, {"param", "model"}),
    "model A { } scene s of | ": ({"A"}, {"R"}),
    "model A { } scene s of A { solver | }": ({"rodas5p"}, {"R"}),
    "model A { } scene s of A { solver rodas5p(| }": ({"rtol", "step"}, {"inertia"}),
    "model A { } scene s of A { device d = | }": ({"trace"}, {"R"}),
    "model A { } scene s of A { run 3 s | }": ({"every"}, {"observe"}),
    "model A { } scene s of A { observe energy.| }": ({"stored"}, {"A"}),
    "model A { shape | }": ({"box", "rope"}, {"param"}),
    'model A { shape box colour "| }': ({"red"}, {"box"}),
    "// a comm|": (set(), {"model"}),
    "model A { } /* | */": (set(), {"model"}),
    "interface B { } model D is B { } model A { b : B; } scene s of A { use b = | }": (
        {"D"}, {"A", "B", "R"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("text", COMPLETED)
def test_completion_offers_what_fits_the_position(documents, tmp_path, text):
    wanted, unwanted = COMPLETED[text]
    path = tmp_path / "a.bg"
    offset = text.index("|")
    documents.open(path, text.replace("|", ""))
    found = complete(analyse(path, documents), offset, {"rodas5p": "stiff"})
    offered = {each.text for each in found}
    assert wanted <= offered and not unwanted & offered


def test_a_library_part_brings_its_import(documents, tmp_path):
    path, text = tmp_path / "a.bg", "// mine\n\nmodel A { a : "
    documents.open(path, text)
    found = {each.text: each for each in complete(analyse(path, documents), len(text))}
    edit = found["Beam"].also
    assert edit.text == "import crane.beam;\n" and edit.span.start == len("// mine\n\n")


# --- hover and hints ----------------------------------------------------------------------


def test_hover_shows_what_the_compiler_found(documents, tmp_path):
    text = (Path(__file__).parents[2] / "README.md").read_text("utf-8")
    text = text.split("```bg\n")[1].split("```")[0]
    path = tmp_path / "rlc.bg"
    documents.open(path, text)
    analysis = analyse(path, documents)
    facts = facts_of(
        compile_scene(path, Options("step"), package=analysis.package, until="equations")
    )

    def shown(part: str) -> str:
        return hover(analysis, text.index(part), facts)[1]

    assert "`L` = 1 mH" in shown("L = 1") and "param L = 1 mH" in shown("L = 1")
    assert "coil.p' = 5 - 1 / C * capacitor.q - R * 1 / L * coil.p" in shown("coil ")
    assert "`loop ->| coil`: preferred, `coil` integrates the effort" in shown("coil ")
    assert "effort in V; flow in A" in shown("-> coil")
    assert "Series RLC circuit." in shown("RLC {")
    assert "inertia: mass" in shown("I(L)") and "resistance" in shown("2 ohm")
    assert "Makes a value a column" in shown("observe")
    assert [h.text for h in hints(analysis.document.file, facts)] == ["->|", "->|", "|->", "|->"]
    assert hover(analysis, text.index("\n\n"), facts) is None


def test_hints_show_widths_and_units_that_are_not_written(documents, tmp_path):
    text = (
        "model A { const m = 2 kg; param k = m + 3 kg; s : Se[3]([1 N, 2 N, 3 N]); j : J1[3];"
        " i : I[3](k); s -> j -> i; } scene a of A { observe i.f; run 1 s; }"
    )
    path = tmp_path / "a.bg"
    documents.open(path, text)
    analysis = analyse(path, documents)
    stages = compile_scene(path, Options("a"), package=analysis.package, until="equations")
    found = {
        text[: h.offset].split()[-1]: h.text
        for h in hints(analysis.document.file, facts_of(stages))
    }
    assert found["k"] == ": kg"
    assert found["->"] == "->| 3"


def test_the_outline_lists_declarations_with_their_members(wheel):
    found = outline(wheel.document.file)
    assert [(h.name, h.kind.value) for h in found] == [
        ("Brake", "interface"), ("Disc", "model"), ("Wheel", "model"), ("spin", "scene"),
    ]  # fmt: skip
    assert [h.name for h in found[2].inner] == ["mass", "rim", "body", "brake", "spoke"]


# --- broken texts -------------------------------------------------------------------------


def broken(text: str, chance: random.Random) -> str:
    """A beginning of the text, or the text without one of its pieces, or with one put elsewhere."""
    start, end = sorted(chance.randrange(len(text) + 1) for _ in range(2))
    end = min(end, start + chance.choice([1, 5, 40, 400]))
    match chance.randrange(4):
        case 0:
            return text[:start]
        case 1:
            return text[:start] + text[end:]
        case 2:
            return text[:start] + text[start:end] * 2 + text[end:]
        case _:
            return text[:start] + chance.choice('{}()[];:.,=->"/*\x00𝄞\\') + text[start:]


def examine_all(path: Path, text: str, documents: Documents, chance: random.Random) -> None:
    documents.open(path, text)
    analysis = analyse(path, documents)
    outline(analysis.document.file)
    lines = Lines(text)
    for offset in [len(text), *(chance.randrange(len(text) + 1) for _ in range(2))]:
        assert lines.offset(lines.position(offset)) <= len(text)
        complete(analysis, offset, {})
        hover(analysis, offset, facts_of_nothing())
        analysis.definition(offset)


def facts_of_nothing():
    from bgc.editing.facts import Facts

    return Facts()


@pytest.mark.parametrize("part", range(4))
def test_no_broken_text_of_the_library_raises(documents, part):
    for number, path in enumerate(LIBRARY[part::4]):
        chance = random.Random(1000 * part + number)
        text = path.read_text("utf-8")[:4000]
        examine_all(path.with_name("broken.bg"), broken(text, chance), documents, chance)
