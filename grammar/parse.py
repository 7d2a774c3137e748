"""Parse the text of a `.bg` file into its syntax tree, with recovery from syntax errors."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Any

from lark import Token, Tree, UnexpectedInput, UnexpectedToken

from bgc.diagnostics.catalogue import files
from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.collection import MAX_ERRORS
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.grammar.error_context import ErrorContext
from bgc.grammar.lark_parser import lark_parser
from bgc.grammar.mistaken_values import reciprocal_unit
from bgc.grammar.mistakes import block_kind, explain
from bgc.grammar.source_files import read_source
from bgc.grammar.tokens import END, ParseTree, span_of, start_of, token_at
from bgc.grammar.transform import transform, transform_filling, transform_setting
from bgc.record_class import dataclass

__all__ = [
    "parse",
    "parse_filling",
    "parse_setting",
    "parse_with_tokens",
    "read_so_far",
    "read_source",
]

_MAX_LINE = 100_000
_MAX_STACK = 200  # entries on the parser's stack: bounds the depth of the parse tree, too

_OPENING = ("LPAR", "LSQB", "LBRACE")
_CLOSING = ("RPAR", "RSQB", "RBRACE")
_ENDS_STATEMENT = ("SEMICOLON", "LBRACE", "RBRACE")

_BONDGRAPHTOOLS = re.compile(r"(?s)\A(?=.{0,4000}^models:)(?=.{0,4000}^root:)", re.MULTILINE)
_SKIPPED = re.compile(
    r"""//[^\n]*|/\*.*?\*/|/\*|"[^"\n]*"|[;{}]"""
    r"""|^(?:import|function|domain|pseudo|interface|model|scene)\b""",
    re.DOTALL | re.MULTILINE,
)
_RECIPROCAL = re.compile(r"=\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)? (1/\S+)\s*\Z")
_ELSE = re.compile(r"\s*else\b")
_CLOSED = re.compile(r"\s*;")


def parse(source: Source) -> tuple[syntax.File, tuple[Diagnostic, ...]]:
    """Parse a text. Syntax errors are returned, not raised.

    Returns
    -------
    tuple
        The syntax tree of the parts that could be read, and the diagnostics in the order of the
        text: at most `MAX_ERRORS`, then one that says that there are more. Without any, the tree
        is that of the whole text.
    """
    file, _, diagnostics = parse_with_tokens(source)
    return file, diagnostics


def parse_with_tokens(
    source: Source,
) -> tuple[syntax.File, tuple[Token, ...], tuple[Diagnostic, ...]]:
    """Parse a text as `parse` does, and return its tokens too."""
    refusal = _not_a_model(source)
    if refusal is not None:
        return syntax.File(source, (), ()), (), (refusal,)
    parsing = _Parsing(source)
    file, refused = transform(source, parsing.to_end())
    found = sorted((*parsing.diagnostics, *refused), key=lambda d: d.span.start if d.span else 0)
    if any(d.code == "BG110" for d in found):  # the unclosed comment holds the missing `}`
        found = [d for d in found if d.code != "BG105"]
    if len(found) > MAX_ERRORS:
        rest = found[MAX_ERRORS].span
        assert rest is not None
        found[MAX_ERRORS:] = [wrong.too_many_errors(rest, MAX_ERRORS)]
    return file, tuple(parsing.tokens), tuple(found)


@dataclass(frozen=True, slots=True)
class Reading:
    """The state of the parser at the end of a text that need not be complete.

    `accepted` are the types of the tokens that may follow, `tokens` those that were read, `block`
    is the kind of the innermost block, as in `words.WORDS`.
    """

    accepted: frozenset[str]
    tokens: tuple[Token, ...]
    block: str


def read_so_far(source: Source, following: str = "") -> Reading:
    """Read the beginning of a text, up to a cursor, and say how it may go on.

    `following` stands behind the text without being read: some words are keywords only before a
    name.
    """
    if _not_a_model(source) is not None:
        return Reading(frozenset(), (), "file")
    return _Parsing(Source(source.name, source.text + following)).so_far(len(source.text))


def parse_setting(source: Source) -> syntax.Set:
    """Parse `a.b = value`, the setting of a parameter on the command line.

    A unit that begins with `1/`, as columns and tables show it, is read too: `40 1/m` as
    `40 m^-1`.

    Raises
    ------
    BgError
        With the first syntax error.
    """
    refusal = _not_a_model(source)
    if refusal is not None:
        raise BgError([refusal])
    if (found := _RECIPROCAL.search(source.text)) and (unit := reciprocal_unit(found[1])):
        source = Source(source.name, source.text[: found.start(1)] + unit)
    parsing = _Parsing(source, "setting")
    tree = parsing.to_first_error()
    if tree is None:
        raise BgError(parsing.diagnostics)
    setting, refused = transform_setting(source, tree)
    if refused:
        raise BgError(refused)
    return setting


def parse_filling(source: Source) -> syntax.Use | None:
    """Parse `a.b = Type(..)`, the filling of a slot on the command line; None if it is not one."""
    tree = None if _not_a_model(source) else _Parsing(source, "filling").to_first_error()
    if tree is None:
        return None
    use, refused = transform_filling(source, tree)
    return None if refused else use


def _not_a_model(source: Source) -> Diagnostic | None:
    """Recognise a text that is not worth parsing: another tool's format, or data in one line."""
    if _BONDGRAPHTOOLS.match(source.text):
        return files.saved_by_bondgraphtools(Span(source, 0, len(source.line(1))))
    starts = (*source.line_starts, len(source.text))
    for start, following in pairwise(starts):
        if following - start > _MAX_LINE:
            return wrong.long_line(
                Span(source, start + _MAX_LINE, start + _MAX_LINE + 1), _MAX_LINE
            )
    return None


class _TooDeepError(Exception):
    """The parser's stack has reached its bound at this token."""

    def __init__(self, token: Token) -> None:
        self.token = token
        super().__init__()


class _Parsing:
    """The parsing of one text, with its tokens and syntax errors so far.

    After an error the parser returns to its state behind the last complete statement and reads
    on behind the next `;` or `}` of that block. Where a single sign is missing, it is inserted.
    """

    def __init__(self, source: Source, start: str = "file") -> None:
        self.source = source
        self.tokens: list[Token] = []
        self.diagnostics: list[Diagnostic] = []
        self._start = start
        self._parser = lark_parser().parse_interactive(source.text, start)
        self._open: list[Token] = []  # brackets and braces that are not closed yet
        self._blocks = 0  # how many of them are braces
        self._between_statements = self._parser.parser_state.copy(deepcopy_values=False)
        self._last_error = -1
        self._resumed = -1

    def to_end(self) -> ParseTree:
        """Read to the end of the text, or to the last error that is reported."""
        while True:
            try:
                self._read_on()
                return self._end()
            except UnexpectedInput as error:
                self._recover(*_place(error))
            except _TooDeepError as error:
                self._skip(self._report_too_deep(error.token))
            if len(self.diagnostics) > MAX_ERRORS:
                self._close_blocks()
                return self._end()

    def so_far(self, end: int) -> Reading:
        """Read to an offset, past errors, without closing what is open."""
        while len(self.diagnostics) <= MAX_ERRORS:
            try:
                self._read_on(end)
                break
            except UnexpectedInput as error:
                at, found = _place(error)
                if at >= end:
                    break
                self._recover(at, found)
            except _TooDeepError as error:
                self._skip(self._report_too_deep(error.token))
        accepted = frozenset(self._parser.accepts())
        tokens = tuple(token for token in self.tokens if str(token))
        return Reading(accepted, tokens, block_kind(self.tokens, self._open, "file"))

    def to_first_error(self) -> ParseTree | None:
        """Read to the end of the text, or to the first error."""
        try:
            self._read_on()
            return self._end()
        except UnexpectedInput as error:
            self._report(*_place(error))
        except _TooDeepError as error:
            self._report_too_deep(error.token)
        return None

    def _read_on(self, end: int | None = None) -> None:
        """Feed tokens from the current offset to the end of the text, or another, or an error."""
        state = self._parser.parser_state
        for token in self._parser.lexer_thread.lex(state):
            if end is not None and start_of(token) >= end:
                return
            if len(state.state_stack) > _MAX_STACK:
                raise _TooDeepError(token)
            self._feed(token)

    def _feed(self, token: Token) -> None:
        """Feed one token; note what it opens, closes or completes."""
        self._parser.feed_token(token)
        self.tokens.append(token)
        if token.type in _OPENING:
            self._open.append(token)
        elif token.type in _CLOSING:
            self._open.pop()
        if token.type in _ENDS_STATEMENT:
            # A shallow copy: no rule of the grammar changes a tree that it takes from the stack.
            self._between_statements = self._parser.parser_state.copy(deepcopy_values=False)
            self._blocks = len(self._open)

    def _end(self) -> ParseTree:
        """Feed the end of the text."""
        tree = self._parser.feed_token(token_at(END, len(self.source.text)))
        assert isinstance(tree, Tree)
        return tree

    # --- recovery -------------------------------------------------------------------------

    def _recover(self, at: int, found: Token | None) -> None:
        """Report an error, and take the parser to where it can read on."""
        missing = self._report(at, found)
        if missing is not None:
            self._feed(token_at(missing, at))
            self._resume(at)
        elif found is not None and found.type == END:
            self._close_blocks()
        else:
            self._skip(at)

    def _report(self, at: int, found: Token | None) -> str | None:
        """Report an error; return the type of the missing sign if that is all that is wrong."""
        context = ErrorContext(
            self.source,
            at,
            found,
            self.tokens,
            self._open,
            frozenset(self._parser.accepts()),
            self._start,
        )
        explanation = explain(context)
        if at != self._last_error:  # otherwise it follows from the one before
            self.diagnostics.append(explanation.diagnostic)
            self._last_error = at
        return explanation.missing

    def _report_too_deep(self, token: Token) -> int:
        """Report where the nesting becomes too deep; return the offset."""
        self.diagnostics.append(wrong.too_deep(span_of(self.source, token)))
        return start_of(token)

    def _return_to_block(self) -> None:
        """Drop the statement that was begun: return to the state before it."""
        self._parser.parser_state = self._between_statements.copy(deepcopy_values=False)
        del self._open[self._blocks :]
        if "SEMICOLON" in self._parser.accepts():  # may follow the block of a law
            self._parser.feed_token(token_at("SEMICOLON", self._resumed))

    def _skip(self, at: int) -> None:
        """Read on behind the next `;` or block, or before the `}` of the current block."""
        self._return_to_block()
        resume = _end_of_statement(self.source.text, at, self._resumed, in_block=bool(self._open))
        self.tokens.append(token_at("SEMICOLON", resume))
        self._resume(resume)

    def _resume(self, at: int) -> None:
        """Read on from an offset: in a text with blanks before it, which keeps all places."""
        text = " " * at + self.source.text[at:]
        state = self._parser.parser_state
        self._parser = lark_parser().parse_interactive(text, self._start)
        self._parser.parser_state = state
        self._resumed = at

    def _close_blocks(self) -> None:
        """Close every open block, and skip the rest of the text."""
        end = len(self.source.text)
        self._return_to_block()
        for _ in self._open:
            self._parser.feed_token(token_at("RBRACE", end))
        self._open.clear()
        self._resume(end)


def _place(error: UnexpectedInput) -> tuple[int, Token | None]:
    """Return the offset of a syntax error and the token there; None if no token begins there."""
    offset: Any = error.pos_in_stream
    return offset, error.token if isinstance(error, UnexpectedToken) else None


def _end_of_statement(text: str, at: int, resumed: int, *, in_block: bool) -> int:
    """Find the offset of the next statement, or of the `}` that closes the current block.

    A line that begins like a declaration ends every open block, unless reading resumed there
    after the error before.
    """
    depth = 0
    for found in _SKIPPED.finditer(text, at):
        match found.group():
            case "{":
                depth += 1
            case "}" if depth == 0:
                return found.start() if in_block else found.end()
            case "}":
                depth -= 1
                if depth == 0 and not _ELSE.match(text, found.end()):
                    closed = _CLOSED.match(text, found.end())
                    return closed.end() if closed else found.end()
            case ";" if depth == 0:
                return found.end()
            case "/*":  # an unclosed comment
                return len(text)
            case word if word.isalpha() and found.start() > resumed:
                return found.start()
    return len(text)
