"""From the text of a `.bg` file to its syntax tree."""

from __future__ import annotations

import re
from itertools import pairwise

from bgc.diagnostics.catalogue import files
from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.report import MAX_ERRORS
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.grammar.files import read_source
from bgc.grammar.lalr import (
    END,
    Reader,
    Token,
    Tree,
    UnexpectedCharactersError,
    UnexpectedTokenError,
)
from bgc.grammar.tables import tables
from bgc.grammar.transform import transform, transform_setting

__all__ = ["parse", "parse_setting", "parse_with_tokens", "read_source"]

_MAX_LINE = 100_000
_MAX_STACK = 200  # of the parser; bounds the depth of the parse tree too

_BONDGRAPHTOOLS = re.compile(r"(?s)\A(?=.{0,4000}^models:)(?=.{0,4000}^root:)", re.MULTILINE)
_SKIPPED = re.compile(
    r"""//[^\n]*|/\*.*?\*/|/\*|"[^"\n]*"|[;{}]"""
    r"""|^(?:import|function|domain|pseudo|interface|model|scene)\b""",
    re.DOTALL | re.MULTILINE,
)
_ELSE = re.compile(r"\s*else\b")


def parse(source: Source) -> tuple[syntax.File, tuple[Diagnostic, ...]]:
    """Read a text; whatever it is, this does not raise.

    Returns
    -------
    tuple
        The syntax tree of what could be read, and the diagnostics in the order of the text:
        at most `MAX_ERRORS`, and one that says so. Without any, the tree is the whole text.
    """
    file, _, diagnostics = parse_with_tokens(source)
    return file, diagnostics


def parse_with_tokens(
    source: Source,
) -> tuple[syntax.File, tuple[Token, ...], tuple[Diagnostic, ...]]:
    """Read a text as `parse` does, and give the tokens that were read too."""
    refusal = _refuse(source)
    if refusal is not None:
        return syntax.File(source, (), ()), (), (refusal,)
    reading = _Reading(source)
    file, refused = transform(source, reading.run())
    found = sorted((*reading.diagnostics, *refused), key=lambda d: d.span.start if d.span else 0)
    if any(d.code == "BG110" for d in found):  # what an open comment swallows is not missing
        found = [d for d in found if d.code != "BG105"]
    if len(found) > MAX_ERRORS:
        rest = found[MAX_ERRORS].span
        assert rest is not None
        found[MAX_ERRORS:] = [wrong.too_many_errors(rest, MAX_ERRORS)]
    return file, tuple(reading.tokens), tuple(found)


def parse_setting(source: Source) -> syntax.Set:
    """Read `a.b = value`, the setting of a parameter on the command line.

    Raises
    ------
    BgError
        Where it is none.
    """
    refusal = _refuse(source)
    if refusal is not None:
        raise BgError([refusal])
    reading = _Reading(source, "setting")
    tree = reading.run_once()
    if tree is None:
        raise BgError(reading.diagnostics)
    setting, refused = transform_setting(source, tree)
    if refused:
        raise BgError(refused)
    return setting


def _refuse(source: Source) -> Diagnostic | None:
    """Say why a text is none of ours from the look of it."""
    if _BONDGRAPHTOOLS.match(source.text):
        return files.saved_by_bondgraphtools(Span(source, 0, len(source.line(1))))
    starts = (*source.line_starts, len(source.text))
    for start, following in pairwise(starts):
        if following - start > _MAX_LINE:
            return wrong.long_line(
                Span(source, start + _MAX_LINE, start + _MAX_LINE + 1), _MAX_LINE
            )
    return None


class _TooDeep(Exception):
    """The parser's stack has grown beyond its bound at this token."""

    def __init__(self, token: Token) -> None:
        self.token = token
        super().__init__()


class _Reading:
    """One text on its way through the parser, with what went wrong so far.

    After a mistake the parser is taken back to the block it stands in, and goes on behind the
    next `;` or `}` of that block. Where only one sign is missing, that is put in.
    """

    def __init__(self, source: Source, start: str = "start") -> None:
        self.source = source
        self.tokens: list[Token] = []
        self.diagnostics: list[Diagnostic] = []
        self._reader = Reader(tables(), source.text, start)
        self._outermost = "file" if start == "start" else start
        self._last_trouble = -1
        self._resumed = -1

    def run(self) -> Tree:
        """Read to the end of the text, or to the last error that is reported."""
        while True:
            try:
                self._read_on()
                return self._end()
            except UnexpectedCharactersError as problem:
                self._recover(problem.at, None)
            except UnexpectedTokenError as problem:
                self._recover(problem.token.start_pos, problem.token)
            except _TooDeep as problem:
                self._skip(self._report_too_deep(problem.token))
            if len(self.diagnostics) > MAX_ERRORS:
                self._close_blocks()
                return self._end()

    def run_once(self) -> Tree | None:
        """Read to the end of the text, or to the first error."""
        try:
            self._read_on()
            return self._end()
        except UnexpectedCharactersError as problem:
            self._report(problem.at, None)
        except UnexpectedTokenError as problem:
            self._report(problem.token.start_pos, problem.token)
        except _TooDeep as problem:
            self._report_too_deep(problem.token)
        return None

    def _span(self, start: int, length: int = 0) -> Span:
        return Span(self.source, start, start + length)

    def _read_on(self) -> None:
        """Feed tokens from where the reader stands, to the end of the text or a mistake."""
        reader, stack, tokens = self._reader, self._reader.states, self.tokens
        while (token := reader.next_token()) is not None:
            if len(stack) > _MAX_STACK:
                raise _TooDeep(token)
            reader.feed(token)
            tokens.append(token)

    def _end(self) -> Tree:
        """Feed the end of the text."""
        self._reader.feed(self._token(END, len(self.source.text)))
        tree = self._reader.values[-1]
        assert isinstance(tree, Tree)
        return tree

    def _token(self, kind: str, at: int) -> Token:
        """Make a token that is not in the text."""
        return Token(kind, "", at)

    # --- recovery -------------------------------------------------------------------------

    def _recover(self, at: int, found: Token | None) -> None:
        """Report a mistake, and take the reader to where it can go on."""
        missing = self._report(at, found)
        if missing is not None:
            token = self._token(missing, at)
            self._reader.feed(token)
            self.tokens.append(token)
            self._resume(at)
        elif found is not None and found.type == END:
            self._close_blocks()
        else:
            self._skip(at)

    def _report(self, at: int, found: Token | None) -> str | None:
        """Report a mistake; return the type of the sign that is missing, if it is only that."""
        from bgc.grammar.mistakes import Trouble, diagnose  # most texts are right

        trouble = Trouble(
            self.source,
            at,
            found,
            self.tokens,
            [token for _, token in self._open()],
            frozenset(self._reader.accepted()),
            self._outermost,
        )
        mistake = diagnose(trouble)
        if at != self._last_trouble:  # else it follows from the one before
            self.diagnostics.append(mistake.diagnostic)
            self._last_trouble = at
        return mistake.missing

    def _report_too_deep(self, token: Token) -> int:
        """Report where the nesting becomes too deep; return the offset."""
        self.diagnostics.append(wrong.too_deep(self._span(token.start_pos, len(token))))
        return token.start_pos

    def _open(self) -> list[tuple[int, Token]]:
        """Find the brackets and braces that are open, and where they are on the value stack."""
        opened: list[tuple[int, Token]] = []
        for at, value in enumerate(self._reader.values):
            if not isinstance(value, Token):
                continue
            if value.type in ("LPAR", "LSQB", "LBRACE"):
                opened.append((at, value))
            elif value.type in ("RPAR", "RSQB", "RBRACE"):
                opened.pop()
        return opened

    def _back_to_block(self) -> bool:
        """Drop what was begun in the innermost block; False where that is the file."""
        values, states = self._reader.values, self._reader.states
        opened = [at for at, token in self._open() if token.type == "LBRACE"]
        between = self._reader.accepted() & {"RBRACE", "MODEL"}
        if between:  # items or declarations: what was read is complete, and is kept
            self._reader.feed(self._token(between.pop(), self._reader.position))
            del values[-1], states[-1]
            return bool(opened)
        keep = opened[-1] + 1 if opened else 0
        if keep < len(values) and _is_list_of_items(values[keep]):
            keep += 1
        del values[keep:], states[keep + 1 :]
        return bool(opened)

    def _skip(self, at: int) -> None:
        """Go on behind the next `;` or block, or before the `}` of the block one is in."""
        in_block = self._back_to_block()
        resume = _end_of_statement(self.source.text, at, self._resumed, in_block=in_block)
        self.tokens.append(self._token("SEMICOLON", resume))
        self._resume(resume)

    def _resume(self, at: int) -> None:
        """Let the reader go on from here."""
        self._reader.position = at
        self._resumed = at

    def _close_blocks(self) -> None:
        """Close every block that is open, and let the reader stand at the end of the text."""
        end = len(self.source.text)
        blocks = sum(token.type == "LBRACE" for _, token in self._open())
        self._back_to_block()
        for _ in range(blocks):
            self._reader.feed(self._token("RBRACE", end))
        self._resume(end)


def _is_list_of_items(value: object) -> bool:
    """Whether a parser's value is what Lark makes of `item*`: a tree named `__block_star_1`."""
    return isinstance(value, Tree) and value.data.startswith("__")


def _end_of_statement(text: str, at: int, resumed: int, *, in_block: bool) -> int:
    """Find where the next statement begins, or the `}` of the block one is in.

    A line that begins as a declaration ends whatever was open, unless reading was resumed
    there before.
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
                    return found.end()
            case ";" if depth == 0:
                return found.end()
            case "/*":  # not closed
                return len(text)
            case word if word.isalpha() and found.start() > resumed:
                return found.start()
    return len(text)
