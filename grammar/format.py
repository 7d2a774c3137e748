"""Print a `.bg` text in its canonical form, for `bgc fmt`.

The form: two blanks of indentation, one statement a line, at most one blank line, `+` and `-`
with blanks around them, `*`, `/` and `^` without (behind a unit they need blanks), and the
colons of neighbouring parts one below the other. The author's choice is kept for blank lines,
line breaks within a statement, and short blocks on one line.

The printer works on the tokens and the comments between them, so no part of the text is lost.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from lark import Token

from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source
from bgc.grammar.parse import parse_with_tokens
from bgc.grammar.tokens import end_of, start_of
from bgc.record_class import dataclass, field, replace

_WIDTH = 100
_INDENT = 2

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_OPENERS = ("LPAR", "LSQB")
_CLOSERS = ("RPAR", "RSQB")
_TIGHT_BEFORE = ("COMMA", "SEMICOLON", "DOT", *_CLOSERS)
_TIGHT_AFTER = ("DOT", *_OPENERS)
_TIGHT_OPERATORS = ("TIMES", "OVER", "POWER")
_CONTINUE = ("PLUS", "MINUS", "COMPARE", "AND", "OR", "THEN", "ELSE", *_TIGHT_OPERATORS)
_ENDS_OPERAND = ("NAME", "NUMBER", "TIME", "TEXT", "DER", "NEXT", *_CLOSERS)


def format_source(source: Source) -> str:
    """Print a text in canonical form, with its meaning unchanged.

    Raises
    ------
    BgError
        With the syntax errors of the text.
    """
    _, tokens, wrong = parse_with_tokens(source)
    if wrong:
        raise BgError(wrong)
    return _Printer(list(_pieces(source.text, tokens))).print()


@dataclass(frozen=True, slots=True)
class _Piece:
    """A token or a comment, and the number of line ends before it."""

    kind: str  # the type of the token, or "COMMENT"
    text: str
    newlines: int

    @property
    def is_line_comment(self) -> bool:
        """Return whether the line must end behind this piece."""
        return self.kind == "COMMENT" and self.text.startswith("//")

    @property
    def has_unit(self) -> bool:
        """Return whether an operator directly behind it would be read as part of its unit."""
        return self.kind == "NUMBER" and " " in self.text


def _pieces(text: str, tokens: tuple[Token, ...]) -> Iterator[_Piece]:
    """Return the tokens of a text and the comments between them, less any `;` behind a `}`."""
    at = 0
    previous = ""
    for token in (*tokens, None):
        start = len(text) if token is None else start_of(token)
        for comment in _COMMENT.finditer(text, at, start):
            yield _Piece("COMMENT", comment.group().rstrip(), text.count("\n", at, comment.start()))
            at = comment.end()
        if token is None:
            return
        if not (token.type == "SEMICOLON" and previous == "RBRACE"):
            yield _Piece(token.type, str(token), text.count("\n", at, start))
        at, previous = end_of(token), token.type


@dataclass(slots=True)
class _Line:
    """One line of the result, and the column of the colon where it declares a part."""

    text: str
    colon: int | None = None


@dataclass(slots=True)
class _Printer:
    """The printing of a text: pieces are appended in turn, with blanks and line ends between."""

    pieces: list[_Piece]
    lines: list[_Line] = field(default_factory=lambda: [_Line("")])
    inline: list[bool] = field(default_factory=list)  # for each open block: is it on one line
    brackets: list[int] = field(default_factory=list)  # for each open bracket: its line
    statement: str = ""  # kind of the first token of the statement, "" between statements
    token: _Piece = _Piece("", "", 0)  # the last token, comments skipped
    is_sign: bool = False  # the last token is a sign before an operand
    is_spaced: bool = False  # the last token is an operator with blanks around it
    leads: bool = False  # the last comment began its line

    def print(self) -> str:
        """Print the whole text."""
        for at, piece in enumerate(self.pieces):
            if at > 0:
                self._separate(self.pieces[at - 1], piece)
            if piece.kind == "COMMENT":
                self._set_comment(piece)
            else:
                self._set_token(at, piece)
        text = "\n".join(line.text for line in _aligned(self.lines))
        return f"{text}\n" if text else ""

    # --- blanks and line ends before a piece ---------------------------------------------------

    def _separate(self, before: _Piece, piece: _Piece) -> None:
        """Append the line end or the blank that belongs before a piece."""
        between = not self.statement
        if before.is_line_comment or (piece.kind == "COMMENT" and piece.newlines):
            self._new_line(before, piece, blank=between and piece.newlines > 1)
        elif piece.kind == "COMMENT":
            self.lines[-1].text += "  " if piece.is_line_comment else " "
        elif between:
            is_else = piece.kind == "ELSE" and before.kind == "RBRACE"
            beside_comment = before.kind == "COMMENT" and self.leads and not piece.newlines
            if is_else or beside_comment or (self.inline and self.inline[-1]):
                self.lines[-1].text += " "
            else:
                self._new_line(before, piece, blank=piece.newlines > 1)
        elif piece.newlines and piece.kind not in ("LBRACE", "SEMICOLON", "COMMA"):
            self._new_line(before, piece, blank=False)
        elif self._needs_blank(before, piece):
            self.lines[-1].text += " "

    def _new_line(self, before: _Piece, piece: _Piece, *, blank: bool) -> None:
        """Begin an indented line, after an empty one if `blank` and not at the ends of a block."""
        indent = len(self.inline) - (piece.kind == "RBRACE")
        if self.brackets:
            opened = set(self.brackets)
            if piece.kind in _CLOSERS:
                opened.remove(self.brackets[-1])
            indent += len(opened) + (piece.kind in _CONTINUE)
        elif self.statement:
            indent += 1
        if blank and before.kind != "LBRACE" and piece.kind != "RBRACE":
            self.lines.append(_Line(""))
        self.lines.append(_Line(" " * (_INDENT * indent)))

    def _needs_blank(self, before: _Piece, piece: _Piece) -> bool:
        """Return whether a blank stands between two pieces of a statement."""
        if piece.kind in _TIGHT_BEFORE or before.kind in _TIGHT_AFTER:
            return False
        if before.kind == "COMMENT":
            return True
        if piece.kind in _TIGHT_OPERATORS:
            return before.has_unit
        if before.kind in _TIGHT_OPERATORS:
            return self.is_spaced
        if piece.kind in _OPENERS:
            return before.kind not in _ENDS_OPERAND and not self.is_sign
        if "DOTS" in (piece.kind, before.kind):
            in_declaration = self.statement != "FOR" and not self.brackets
            return in_declaration or (before.kind == "DOTS" and piece.text.startswith("."))
        return not self.is_sign

    # --- the piece itself -------------------------------------------------------------------

    def _set_comment(self, piece: _Piece) -> None:
        self.leads = not self.lines[-1].text.strip()
        first, *more = piece.text.split("\n")
        self.lines[-1].text += first
        self.lines += [_Line(text.rstrip()) for text in more]

    def _set_token(self, at: int, piece: _Piece) -> None:
        """Append a token, and update the state that later pieces depend on."""
        line, before = self.lines[-1], self.token
        if piece.kind == "COLON" and self.statement == "NAME" and not any(self.inline):
            line.colon = len(line.text)
        line.text += piece.text
        self.token = piece
        self.is_sign = piece.kind in ("PLUS", "MINUS") and before.kind not in _ENDS_OPERAND
        self.is_spaced = piece.kind in _TIGHT_OPERATORS and before.has_unit
        self.statement = self.statement or piece.kind
        match piece.kind:
            case "LPAR" | "LSQB":
                self.brackets.append(len(self.lines))
            case "RPAR" | "RSQB":
                self.brackets.pop()
            case "LBRACE":
                self.inline.append(self._is_inline(at))
                self.statement = ""
            case "RBRACE":
                self.inline.pop()
                self.statement = ""
            case "SEMICOLON":
                self.statement = ""

    def _is_inline(self, at: int) -> bool:
        """Return whether the block that begins here was written on one line and fits on one."""
        if self.inline and self.inline[-1]:
            return True
        block: list[_Piece] = []
        level = 0
        for piece in self.pieces[at:]:
            if block and piece.newlines and not (piece.kind == "RBRACE" and len(block) == 1):
                return False
            if piece.kind == "COMMENT" or len(block) > _WIDTH:
                return False
            block.append(replace(piece, newlines=0))
            level += (piece.kind == "LBRACE") - (piece.kind == "RBRACE")
            if level == 0:
                break
        alone = _Printer(block, inline=[True]).print().strip()
        return len(block) == 2 or len(self.lines[-1].text) + len(alone) <= _WIDTH


def _aligned(lines: list[_Line]) -> list[_Line]:
    """Align the colons of parts on neighbouring lines."""
    start = 0
    while start < len(lines):
        end = start + 1
        while end < len(lines) and _are_neighbours(lines[end - 1], lines[end]):
            end += 1
        furthest = max(line.colon or 0 for line in lines[start:end])
        for line in lines[start:end]:
            if line.colon is not None:
                before, after = line.text[: line.colon], line.text[line.colon :]
                line.text = before.ljust(furthest) + after
        start = end
    return lines


def _are_neighbours(line: _Line, following: _Line) -> bool:
    if line.colon is None or following.colon is None:
        return False
    return _indent(line.text) == _indent(following.text)


def _indent(text: str) -> int:
    return len(text) - len(text.lstrip(" "))
