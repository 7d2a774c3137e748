"""Colours for editors: generated files, and a comparison with the grammar's own tokens."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from pygments.lexers import get_lexer_by_name
from pygments.token import Comment, Generic, Keyword, Name, Number, Operator, String

from bgc.diagnostics.source import Source
from bgc.grammar.language_words import TABLE
from bgc.grammar.parse import parse_with_tokens
from bgc.grammar.tokens import start_of
from bgc.resolution.library import library_folder
from bgc.runtime.editor import colours
from bgc.runtime.editor.pygments_lexer import BgLexer

LIBRARY = sorted(library_folder().rglob("*.bg"))
EXTENSION = Path(colours.__file__).parent / "vscode"


@pytest.mark.parametrize("path", colours.files(), ids=lambda path: path.name)
def test_generated_files_are_up_to_date(path):
    text = colours.files()[path]
    assert path.read_text("utf-8") == text, "run python -m bgc.runtime.editor.colours"


def test_every_word_of_the_language_has_a_colour():
    lists = colours.word_lists()
    coloured = {word for words in lists.values() for word in words}
    assert set(TABLE) <= coloured
    for path in (colours.TEXTMATE, colours.VIM):
        written = set(re.findall(r"\w+", path.read_text("utf-8").replace("\\\\b", " ")))
        assert coloured - set(lists["variables"]) <= written


@pytest.mark.parametrize("part", range(3))
def test_pygments_agrees_with_the_grammar(part):
    """Keywords, names, numbers and texts of every library file, token by token."""
    mistaken = []  # names that are keywords elsewhere: only a parser knows each of them
    for path in LIBRARY[part::3]:
        text = path.read_text("utf-8")
        _, tokens, _ = parse_with_tokens(Source(path.name, text))
        kinds = {}
        for at, kind, value in BgLexer().get_tokens_unprocessed(text):
            kinds.update(dict.fromkeys(range(at, at + len(value)), kind))
        assert Generic.Error not in kinds.values(), path
        for token in filter(str, tokens):
            kind, place = kinds[start_of(token)], (path.name, start_of(token), str(token))
            assert kind not in Comment, place
            if token.type == "NAME" and str(token) in TABLE and kind in Keyword:
                mistaken.append(place)
            elif token.type == "NAME":
                assert kind in Name, place
            elif token.type == "NUMBER":
                assert kind in Number, place
            elif token.type == "TEXT":
                assert kind in String, place
            elif str(token) in TABLE:
                assert kind in Keyword or kind in Operator.Word or kind in Name.Constant, place
    assert len(mistaken) <= 3, mistaken


def test_textmate_patterns_are_regular_expressions():
    for rule in json.loads(colours.TEXTMATE.read_text("utf-8"))["patterns"]:
        for key in {"match", "begin", "end"} & set(rule):
            re.compile(rule[key])


def test_the_lexer_is_installed():
    assert isinstance(get_lexer_by_name("bg"), BgLexer)


def test_the_extension_names_files_that_exist():
    package = json.loads((EXTENSION / "package.json").read_text("utf-8"))
    (language,), (grammar,) = (package["contributes"][k] for k in ("languages", "grammars"))
    assert language["extensions"] == [".bg"] and grammar["language"] == language["id"]
    named = [package["icon"], language["configuration"], grammar["path"], "src/extension.js"]
    assert all((EXTENSION / name).exists() for name in named)
    assert not list(EXTENSION.glob("package-lock.json"))


@pytest.mark.skipif(shutil.which("vim") is None, reason="needs vim")
def test_vim_colours_a_model(tmp_path):
    text = "/// Doc.\nmodel M {\n  param mass = 2 kg;  // note\n  body : I(mass);\n  a -> b;\n}\n"
    (tmp_path / "a.bg").write_text(text)
    asked = [(1, 1), (2, 1), (3, 3), (3, 16), (3, 23), (4, 10), (5, 5)]
    places = " + ".join(
        f"[synIDattr(synID({line}, {column}, 1), 'name')]" for line, column in asked
    )
    script = (
        f"set rtp^={colours.FOLDER / 'vim'}\nfiletype plugin on\nsyntax on\nedit a.bg\n"
        f"call writefile([&filetype, &commentstring] + {places}, 'found')\nqa!\n"
    )
    (tmp_path / "script.vim").write_text(script)
    command = ["vim", "-N", "-u", "NONE", "-i", "NONE", "-es", "-S", "script.vim"]
    subprocess.run(command, cwd=tmp_path, stdin=subprocess.DEVNULL, timeout=60, check=False)
    found = (tmp_path / "found").read_text().splitlines()
    assert found[:2] == ["bg", "// %s"]
    assert found[2:] == [
        "bgDoc", "bgKeyword", "bgKeyword", "bgNumber", "bgComment", "bgElement", "bgArrow",
    ]  # fmt: skip
