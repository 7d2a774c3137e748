"""The parser that Lark makes of `bgc.lark`, made once and kept in the user's cache.

Making the tables takes some tenths of a second, loading them a hundredth.
"""

from __future__ import annotations

import io
import sys
import tempfile
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path

import lark
from lark import lexer

from bgc.grammar.places import cache_directory


@cache
def parser() -> lark.Lark:
    """Return the parser, from the cache if it is there."""
    grammar = Path(__file__).with_name("bgc.lark").read_text(encoding="utf-8")
    key = sha256(f"{lark.__version__}\n{sys.version}\n{grammar}".encode()).hexdigest()[:32]
    try:
        kept = cache_directory() / f"grammar-{key}.pickle"
    except RuntimeError:  # no home directory
        return make_parser(grammar)
    with suppress(Exception):  # absent or damaged: it is made again
        return lark.Lark.load(io.BytesIO(kept.read_bytes()))
    made = make_parser(grammar)
    with suppress(OSError):
        _keep(made, kept)
    return made


def make_parser(grammar: str, *, strict: bool = False) -> lark.Lark:
    """Make the parser from the text of the grammar.

    With `strict` any conflict of rules or of terminals is an error (needs `interegular`).
    """
    # Where `interegular` is installed, Lark searches for terminals that overlap, for 0.7 s. A test
    # does that once and for all.
    searches = lexer.has_interegular
    lexer.has_interegular = searches and strict
    try:
        return lark.Lark(
            grammar,
            start=["start", "setting"],
            parser="lalr",
            lexer="contextual",
            maybe_placeholders=True,
            strict=strict,
        )
    finally:
        lexer.has_interegular = searches


def _keep(made: lark.Lark, path: Path) -> None:
    """Write the tables aside and move them into place, so that two runs at once are safe."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as aside:
        try:
            made.save(aside)
            aside.close()
            Path(aside.name).replace(path)
        except BaseException:
            Path(aside.name).unlink(missing_ok=True)
            raise
