"""Colours of the language for editors: from the grammar's terminals and the tables of its words.

After a change of the grammar, the words, the elements or the functions, write the files again:
`python -m bgc.runtime.editor.colours`. A test compares them.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from bgc.grammar.language_words import RESERVED, TABLE
from bgc.grammar.lark_parser import lark_parser
from bgc.language.elements import ELEMENTS
from bgc.values.functions import BUILTINS

FOLDER = Path(__file__).parent
TEXTMATE = FOLDER / "vscode/syntaxes/bg.tmLanguage.json"
VIM = FOLDER / "vim/syntax/bg.vim"

_CONSTANTS = ("time", "pi")
_OPERATORS = ("and", "or", "not")
_DECLARES = ("model", "interface", "domain", "function", "scene")


def word_lists() -> Mapping[str, tuple[str, ...]]:
    """Return the words of the language by their colour, each list sorted.

    `reserved` are keywords everywhere, `begins` where a statement begins, `within` between other
    words of a statement; both may be names elsewhere.
    """
    shown = {*_CONSTANTS, *_OPERATORS}
    soft = [word for word in TABLE.values() if word.word not in RESERVED]
    return {
        "reserved": tuple(sorted(RESERVED - shown)),
        "begins": tuple(sorted(word.word for word in soft if word.begins)),
        "within": tuple(sorted(word.word for word in soft if not word.begins)),
        "operators": tuple(sorted(_OPERATORS)),
        "constants": tuple(sorted(_CONSTANTS)),
        "elements": tuple(sorted(ELEMENTS)),
        "functions": tuple(sorted(BUILTINS)),
        "variables": ("e", "e1", "e2", "f", "f1", "f2", "p", "power", "q"),
    }


def terminals() -> Mapping[str, str]:
    """Return the terminals of the grammar as regular expressions."""
    return {each.name: each.pattern.to_regexp() for each in lark_parser().terminals}


def alternatives(words: Iterable[str]) -> str:
    """Return an expression that matches one of some whole words."""
    return rf"\b(?:{'|'.join(sorted(words, key=lambda w: (-len(w), w)))})\b"


STATEMENT = r"(?:(?<=[;{}])|^)(\s*)"
"""Pattern before a place at which a statement may begin."""

NOT_A_NAME = r"(?!\s*(?:[:.=,)\[]|->))"
"""Pattern that may not follow a word that is a keyword only in its place."""

BETWEEN = r"(?<=[\s)\]])(?<!\bas\s)"
GOES_ON = r"(?=\s+(?!->)[\w\"\[(.-]|\s*[;{]|\s*$)"
"""Patterns before and behind a keyword within a statement."""

OF_PORTS = r"(?<=[\w\]]\s)(?:out|main)(?=\s+(?::|main))"
"""The keywords of a port before its domain."""

CALLED = r"\bnext(?=[ \t]*\()"
"""The keyword that stands before a bracket, as a function does."""


def textmate() -> dict[str, Any]:
    """Return the grammar for editors that read TextMate grammars."""
    words, signs = word_lists(), terminals()
    unit = {"match": r"(?<= )\S+\Z", "name": "keyword.other.unit.bg"}
    number = f"(?<![A-Za-z0-9_.]){signs['NUMBER']}"
    begins = f"{STATEMENT}({alternatives(words['begins'])}){NOT_A_NAME}"
    within = f"{BETWEEN}({alternatives(words['within'])}){GOES_ON}"
    named = rf"\b({'|'.join(_DECLARES)})\s+([A-Za-z_]\w*)"
    part = r"(?<=:)\s*([A-Za-z_]\w*)(?=\s*[\[({=;])"
    patterns = [
        _rule(r"///.*$", "comment.line.documentation.bg"),
        _rule(r"//.*$", "comment.line.double-slash.bg"),
        {"begin": r"/\*", "end": r"\*/", "name": "comment.block.bg"},
        _rule(signs["TEXT"], "string.quoted.double.bg"),
        {"match": number, "captures": {"0": {"name": "constant.numeric.bg", "patterns": [unit]}}},
        {
            "match": named,
            "captures": {
                "1": {"name": "storage.type.bg"},
                "2": {"name": "entity.name.type.bg"},
            },
        },
        _rule(alternatives(words["operators"]), "keyword.operator.logical.bg"),
        _rule(alternatives(words["constants"]), "constant.language.bg"),
        _rule(alternatives(words["reserved"]), "keyword.control.bg"),
        {"match": begins, "captures": {"2": {"name": "keyword.control.bg"}}},
        {"match": within, "captures": {"1": {"name": "keyword.other.bg"}}},
        _rule(OF_PORTS, "keyword.other.bg"),
        _rule(CALLED, "keyword.control.bg"),
        _rule(f"(?<=:)\\s*{alternatives(words['elements'])}", "support.class.bg"),
        {"match": part, "captures": {"1": {"name": "entity.name.type.bg"}}},
        _rule(f"{alternatives(words['functions'])}(?=\\s*\\()", "support.function.bg"),
        _rule(f"(?<=\\.){alternatives(words['variables'])}", "variable.other.property.bg"),
        _rule(r"->", "keyword.operator.bond.bg"),
        _rule(r"<=|>=|==|!=|\.\.|[-+*/^<>=]", "keyword.operator.bg"),
    ]
    return {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "bgc",
        "scopeName": "source.bg",
        "fileTypes": ["bg"],
        "patterns": patterns,
    }


def _rule(match: str, name: str) -> dict[str, str]:
    return {"match": match, "name": name}


def vim() -> str:
    """Return the syntax file for Vim."""
    words = word_lists()
    groups = {
        "bgKeyword": ("reserved", "Keyword"),
        "bgOperator": ("operators", "Operator"),
        "bgConstant": ("constants", "Constant"),
    }
    lines = [
        '" Vim syntax file of the bgc language. Written by python -m bgc.runtime.editor.colours.',
        'if exists("b:current_syntax")',
        "  finish",
        "endif",
        "",
        *(f"syn keyword {group} {' '.join(words[name])}" for group, (name, _) in groups.items()),
        _vim_match("bgStatement", rf"%(^|[;{{}}])@<=\s*<%({_either(words['begins'])})>", "words"),
        _vim_match("bgWord", rf"\s@<=<%({_either(words['within'])})>", "words"),
        _vim_match("bgElement", rf"%(:\s*)@<=<%({_either(words['elements'])})>", ""),
        _vim_match("bgFunction", rf"<%({_either(words['functions'])})>%(\s*\()@=", ""),
        _vim_match("bgArrow", "-\\>", ""),
        _vim_match(
            "bgNumber",
            r"<%(\d+%(\.\d+)?|\.\d+)%([eE][+-]?\d+)?%( [A-Za-z_][A-Za-z0-9_]*%([*/^-]+\w+)*)?",
            "",
        ),
        'syn region bgText start=/"/ end=/"/ oneline',
        r"syn match bgComment /\/\/.*$/ contains=@Spell",
        r"syn match bgDoc /\/\/\/.*$/ contains=@Spell",
        r"syn region bgComment start=/\/\*/ end=/\*\// contains=@Spell",
        "",
        *(f"hi def link {group} {link}" for group, (_, link) in groups.items()),
        "hi def link bgStatement Statement",
        "hi def link bgWord Keyword",
        "hi def link bgElement Type",
        "hi def link bgFunction Function",
        "hi def link bgArrow Operator",
        "hi def link bgNumber Number",
        "hi def link bgText String",
        "hi def link bgComment Comment",
        "hi def link bgDoc SpecialComment",
        "",
        'let b:current_syntax = "bg"',
    ]
    return "\n".join(lines) + "\n"


def _either(words: Iterable[str]) -> str:
    return "|".join(words)


def _vim_match(group: str, pattern: str, kind: str) -> str:
    behind = r"%(\s*%([:.=,)]|-\>))@!" if kind == "words" else ""
    return f"syn match {group} /\\v{(pattern + behind).replace('/', chr(92) + '/')}/"


def files() -> Mapping[Path, str]:
    """Return the generated files with their texts."""
    return {TEXTMATE: json.dumps(textmate(), indent=2) + "\n", VIM: vim()}


if __name__ == "__main__":
    for path, text in files().items():
        path.write_text(text, encoding="utf-8")
