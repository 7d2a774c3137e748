"""The tables that Lark makes of `bgc.lark`, made once and kept in the user's cache.

Making them takes some tenths of a second, loading them some thousandths, without Lark.
"""

from __future__ import annotations

import pickle
import sys
import tempfile
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bgc.grammar.lalr import Rule, Tables
from bgc.grammar.places import cache_directory

if TYPE_CHECKING:
    import lark


@cache
def tables() -> Tables:
    """Return the tables, from the cache if they are there."""
    grammar = Path(__file__).with_name("bgc.lark").read_text(encoding="utf-8")
    code = (Path(__file__), Path(__file__).with_name("lalr.py"))
    made_by = "".join(path.read_text("utf-8") for path in code)
    key = sha256(f"{sys.version}\n{made_by}\n{grammar}".encode()).hexdigest()[:32]
    try:
        kept = cache_directory() / f"grammar-{key}.pickle"
    except RuntimeError:  # no home directory
        return tables_of(make_parser(grammar))
    with suppress(Exception):  # absent or damaged: they are made again
        found = pickle.loads(kept.read_bytes())
        assert isinstance(found, Tables)
        return found
    made = tables_of(make_parser(grammar))
    with suppress(OSError):
        _keep(made, kept)
    return made


def make_parser(grammar: str, *, strict: bool = False) -> lark.Lark:
    """Make Lark's parser from the text of the grammar.

    With `strict` any conflict of rules or of terminals is an error (needs `interegular`).
    """
    import lark
    from lark import lexer

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


def tables_of(made: lark.Lark) -> Tables:
    """The tables of a parser, and the trees it makes, in our own terms."""
    frontend: Any = made.parser  # partly untyped
    parse_table = frontend.parser.parser.parse_table
    numbers = {rule: k for k, rule in enumerate(made.rules)}
    lexer = frontend.lexer.root_lexer
    scanner = lexer.scanner
    assert scanner is not None and not lexer.callback, "a text is a name and a sign"
    actions: list[dict[str, int]] = []
    gotos: list[dict[str, int]] = []
    for state in range(len(parse_table.states)):
        row = parse_table.states[state]
        numbered = {s: to if isinstance(to, int) else ~numbers[to] for s, (_, to) in row.items()}
        actions.append({s: to for s, to in numbered.items() if s.isupper()})
        gotos.append({s: to for s, to in numbered.items() if not s.isupper()})
    return Tables(
        actions=actions,
        gotos=gotos,
        rules=[_rule(rule) for rule in made.rules],
        starts=dict(parse_table.start_states),
        ends=dict(parse_table.end_states),
        terminals={t.name: t.pattern.to_regexp() for t in lexer.terminals},
        ignored=frozenset(lexer.ignore_types),
    )


def _rule(rule: Any) -> Rule:
    """How Lark makes the tree of a rule: signs without a name are left out, `_rules` opened."""
    options, right = rule.options, rule.expansion
    # What `[...]` left out stands among what is there: how many are missing before each, and last.
    left_out = options.empty_indices or (False,) * len(right)
    missing = [0]
    for is_missing in left_out:
        if is_missing:
            missing[-1] += 1
        else:
            missing.append(0)
    parts: list[tuple[int, bool, int]] = []
    nones = 0
    for place, symbol in enumerate(right):
        nones += missing[place]
        if options.keep_all_tokens or not (symbol.is_term and symbol.filter_out):
            parts.append((place, not symbol.is_term and symbol.name.startswith("_"), nones))
            nones = 0
    nones += missing[len(right)]
    as_it_is = parts == [(place, False, 0) for place in range(len(right))] and not nones
    return Rule(
        origin=str(rule.origin.name),
        name=str(rule.alias or options.template_source or rule.origin.name),
        size=len(right),
        parts=None if as_it_is else tuple(parts),
        nones=nones,
        bare=bool(options.expand1 and not rule.alias),
    )


def _keep(made: Tables, path: Path) -> None:
    """Write the tables aside and move them into place, so that two runs at once are safe."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as aside:
        try:
            aside.write(pickle.dumps(made))
            aside.close()
            Path(aside.name).replace(path)
        except BaseException:
            Path(aside.name).unlink(missing_ok=True)
            raise
