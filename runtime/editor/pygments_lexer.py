"""The Pygments lexer `bg`: colours in documents, notebooks and terminals."""

from __future__ import annotations

from typing import ClassVar

from pygments.lexer import RegexLexer, bygroups
from pygments.token import (
    Comment,
    Generic,
    Keyword,
    Literal,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Text,
)

from bgc.runtime.editor.colours import (
    BETWEEN,
    CALLED,
    GOES_ON,
    NOT_A_NAME,
    OF_PORTS,
    STATEMENT,
    alternatives,
    word_lists,
)

_WORDS = word_lists()
_UNIT = r"[A-Za-z_]\w*(?:\^-?[0-9.]+)?(?:[*/][A-Za-z_]\w*(?:\^-?[0-9.]+)?)*"
_NO_UNIT = alternatives(("in", "then", "else", "and", "or", "as", "every", "within", "offset"))


class BgLexer(RegexLexer):  # type: ignore[misc]
    """Colours `.bg` text as the editors do, from the same words."""

    name = "bgc"
    url = ""
    aliases: ClassVar[list[str]] = ["bg", "bgc"]
    filenames: ClassVar[list[str]] = ["*.bg"]
    mimetypes: ClassVar[list[str]] = ["text/x-bg"]

    tokens: ClassVar[dict[str, list[object]]] = {
        "root": [
            (r"///.*", String.Doc),
            (r"//.*", Comment.Single),
            (r"/\*(?s:.*?)(?:\*/|\Z)", Comment.Multiline),
            (r'"[^"\n]*"', String),
            (
                rf"((?:\d+(?:\.\d+)?|\.\d+)(?:[eE][+-]?\d+)?)( )(?!{_NO_UNIT})({_UNIT})",
                bygroups(Number, Text, Literal),
            ),
            (r"(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][+-]?\d+)?", Number),
            (
                r"\b(model|interface|domain|function|scene)(\s+)([A-Za-z_]\w*)",
                bygroups(Keyword.Declaration, Text, Name.Class),
            ),
            (alternatives(_WORDS["operators"]), Operator.Word),
            (alternatives(_WORDS["constants"]), Name.Constant),
            (alternatives(_WORDS["reserved"]), Keyword),
            (CALLED, Keyword),
            (OF_PORTS, Keyword.Pseudo),
            (
                rf"{STATEMENT}({alternatives(_WORDS['begins'])}){NOT_A_NAME}",
                bygroups(Text, Keyword),
            ),
            (r"\b(at)(\s+)(at)\b", bygroups(Keyword.Pseudo, Text, Name)),
            (
                rf"{BETWEEN}({alternatives(_WORDS['within'])}){GOES_ON}",
                Keyword.Pseudo,
            ),
            (rf"(:)(\s*)({alternatives(_WORDS['elements'])})",
             bygroups(Punctuation, Text, Name.Builtin)),
            (r"(:)(\s*)([A-Za-z_]\w*)(?=\s*[\[({=;])", bygroups(Punctuation, Text, Name.Class)),
            (rf"{alternatives(_WORDS['functions'])}(?=\s*\()", Name.Function),
            (r"->|<=|>=|==|!=|\.\.|[-+*/^<>=]", Operator),
            (r"[A-Za-z_]\w*", Name),
            (r"[{}()\[\];:,.]", Punctuation),
            (r"\n|[^\S\n]+", Text.Whitespace),
            (r".", Generic.Error),
        ]
    }  # fmt: skip
