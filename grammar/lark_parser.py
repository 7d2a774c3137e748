"""Lark's LALR(1) parser for `bgc.lark`, loaded from tables that are kept beside the grammar.

Building the tables takes some tenths of a second (five times that where `interegular` is
installed: Lark then searches for terminals that overlap); loading them takes a hundredth.
After a change of `bgc.lark` write them again: `python -m bgc.grammar.lark_parser`.
"""

from __future__ import annotations

import json
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from lark import Lark, __version__
from lark.grammar import Rule
from lark.lexer import TerminalDef

_GRAMMAR = Path(__file__).with_name("bgc.lark")
_TABLES = Path(__file__).with_name("bgc.lark.json")
_SHIFT = 0  # in Lark's tables: go to a state, after a terminal or a rule; else reduce by a rule


@cache
def lark_parser() -> Lark:
    """Return the parser of the grammar, with the start symbols `file`, `setting` and `filling`.

    The layout of the tables is Lark's own and may change with any release, so they are used only
    with the version of Lark that wrote them. With another one the parser is built from the
    grammar.
    """
    kept = json.loads(_TABLES.read_text(encoding="utf-8"), object_hook=_with_numbers_as_keys)
    if kept["written_for"] != _fingerprint():
        return build_parser()
    return Lark.load({"data": kept["data"], "memo": kept["memo"]})


def build_parser(*, strict: bool = False) -> Lark:
    """Build the parser from the text of the grammar.

    With `strict`, any conflict between rules or between terminals is an error; this needs
    `interegular`.
    """
    return Lark(
        _GRAMMAR.read_text(encoding="utf-8"),
        start=["file", "setting", "filling"],
        parser="lalr",
        lexer="contextual",
        maybe_placeholders=True,
        strict=strict,
    )


def write_tables(path: Path = _TABLES) -> None:
    """Build the parser and write its tables as JSON: the same bytes for the same grammar."""
    data, memo = build_parser().memo_serialize([TerminalDef, Rule])
    data["parser"]["parser"] = _renumbered(data["parser"]["parser"])
    tables = {"written_for": _fingerprint(), "data": data, "memo": memo}
    path.write_text(json.dumps(tables, separators=(",", ":")) + "\n", encoding="utf-8")


def _renumbered(tables: dict[str, Any]) -> dict[str, Any]:
    """Number tokens by name, and states in the order in which these lead to them.

    Lark numbers both in the order of sets of objects, which differs from run to run.
    """
    names: dict[int, str] = tables["tokens"]
    numbers = {name: number for number, name in enumerate(sorted(names.values()))}
    starts = tables["start_states"]
    order = {starts[name]: place for place, name in enumerate(sorted(starts))}
    queue = list(order)
    rows: dict[int, dict[int, Any]] = {}
    for state in queue:  # grows
        actions = {numbers[names[k]]: action for k, action in tables["states"][state].items()}
        rows[order[state]] = row = {}
        for token in sorted(actions):
            kind, argument = actions[token]
            if kind == _SHIFT:
                if argument not in order:
                    order[argument] = len(order)
                    queue.append(argument)
                argument = order[argument]
            row[token] = (kind, argument)
    return {
        **tables,
        "tokens": {number: name for name, number in numbers.items()},
        "states": rows,
        "start_states": {name: order[starts[name]] for name in sorted(starts)},
        "end_states": {name: order[end] for name, end in sorted(tables["end_states"].items())},
    }


def _fingerprint() -> str:
    """Name the version of Lark and the text of the grammar, which together decide the tables."""
    grammar = _GRAMMAR.read_text(encoding="utf-8")  # the same with any kind of line end
    return f"lark {__version__}, grammar {sha256(grammar.encode()).hexdigest()}"


def _with_numbers_as_keys(table: dict[str, Any]) -> dict[Any, Any]:
    """Restore the keys of Lark's tables that are numbers: JSON has them as text."""
    if next(iter(table), "").isdigit():
        return {int(key): value for key, value in table.items()}
    return table


if __name__ == "__main__":
    write_tables()
