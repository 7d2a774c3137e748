"""Reads a text by LALR(1) tables: tokens, the parse tree, and what could come next.

A terminal counts only where the parser can go on with it, so that a word of the language is a name
wherever it has no meaning. The reader can be looked into and set back, for recovery from errors.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

END = "$END"


class Token(str):
    """A piece of text with its type and its place."""

    __slots__ = ("end_pos", "start_pos", "type")

    type: str
    start_pos: int
    end_pos: int

    def __new__(cls, type: str, text: str, start_pos: int) -> Token:
        """A token that ends where its text does."""
        self = super().__new__(cls, text)
        self.type, self.start_pos, self.end_pos = type, start_pos, start_pos + len(text)
        return self


class Tree:
    """What a rule has read: its name, and its parts; None stands for one left out."""

    __slots__ = ("children", "data")

    def __init__(self, data: str, children: list[Any]) -> None:
        self.data = data
        self.children = children


Part: TypeAlias = tuple[int, bool, int]


@dataclass(frozen=True, slots=True)
class Rule:
    """How the tree of a rule is made.

    `parts` are the places that are kept of the `size` on the right-hand side (all, if None), each
    with whether its own parts are taken instead, and how many None come before it; `nones` come
    at the end. Where one part alone is left, it stands for the whole if the rule is `bare`.
    """

    origin: str
    name: str
    size: int
    parts: tuple[Part, ...] | None
    nones: int
    bare: bool

    def __post_init__(self) -> None:
        """Of one part that may stand for the whole, nothing is left out."""
        if self.bare and self.size == 1:
            assert self.parts is None and not self.nones, f"`{self.name}` leaves something out"

    def tree(self, read: list[Any]) -> Any:
        """The tree of what was read."""
        children = read if self.parts is None else self._kept(self.parts, read)
        return children[0] if self.bare and len(children) == 1 else Tree(self.name, children)

    def _kept(self, parts: tuple[Part, ...], read: list[Any]) -> list[Any]:
        children: list[Any] = []
        for place, opened, nones in parts:
            if nones:
                children += [None] * nones
            if not opened:
                children.append(read[place])
            elif children:
                children += read[place].children
            else:  # a list that grows stays the same list
                children = read[place].children
        if self.nones:
            children += [None] * self.nones
        return children


@dataclass(frozen=True)
class Tables:
    """A grammar as the reader needs it.

    `actions` of a state and a terminal: the state to go to, or `~k` to reduce by rule k. `gotos` of
    a state and a rule's origin. `terminals` are patterns by name, tried in this order.
    """

    actions: list[dict[str, int]]
    gotos: list[dict[str, int]]
    rules: list[Rule]
    starts: dict[str, int]
    ends: dict[str, int]
    terminals: dict[str, str]
    ignored: frozenset[str]

    @cached_property
    def any_terminal(self) -> re.Pattern[str]:
        """The first terminal that matches, named by the group."""
        named = (f"(?P<{name}>{pattern})" for name, pattern in self.terminals.items())
        return re.compile("|".join(named))

    def others(self, name: str, accepted: dict[str, int]) -> list[re.Pattern[str]]:
        """The terminals behind one among those that are accepted or ignored."""
        names = list(self.terminals)
        behind = names[names.index(name) + 1 :]
        wanted = [name for name in behind if name in accepted or name in self.ignored]
        return [re.compile(f"(?P<{name}>{self.terminals[name]})") for name in wanted]


class UnexpectedCharactersError(Exception):
    """No token begins here."""

    def __init__(self, at: int) -> None:
        self.at = at
        super().__init__()


class UnexpectedTokenError(Exception):
    """The parser cannot go on with this token."""

    def __init__(self, token: Token) -> None:
        self.token = token
        super().__init__()


class Reader:
    """One text on its way through the parser.

    Attributes
    ----------
    position
        Offset of what is read next.
    states, values
        The parser's stacks: states, the first of them the start's; trees and tokens.
    """

    def __init__(self, tables: Tables, text: str, start: str) -> None:
        self.position = 0
        self.states = [tables.starts[start]]
        self.values: list[Any] = []
        self._tables = tables
        self._text = text
        self._end = tables.ends[start]
        self._behind: dict[tuple[str, int], list[re.Pattern[str]]] = {}

    def next_token(self) -> Token | None:
        """The token that begins here, None at the end of the text.

        Raises UnexpectedTokenError where it is one that the parser cannot go on with, and
        UnexpectedCharactersError where it is none.
        """
        tables = self._tables
        match, ignored = tables.any_terminal.match, tables.ignored
        while self.position < len(self._text):
            found = match(self._text, self.position)
            if found is None:
                raise UnexpectedCharactersError(self.position)
            kind = found.lastgroup
            assert kind is not None
            if kind not in ignored and kind not in tables.actions[self.states[-1]]:
                another = self._another(kind)
                if another is None:
                    raise UnexpectedTokenError(Token(kind, found.group(), self.position))
                found, kind = another, another.lastgroup
                assert kind is not None
            start, self.position = found.span()
            if kind not in ignored:
                return Token(kind, found.group(), start)
        return None

    def _another(self, kind: str) -> re.Match[str] | None:
        """What else the text may be here, if not a token that the parser cannot go on with."""
        state = self.states[-1]
        if (kind, state) not in self._behind:
            accepted = self._tables.actions[state]
            self._behind[kind, state] = self._tables.others(kind, accepted)
        for pattern in self._behind[kind, state]:
            if (found := pattern.match(self._text, self.position)) is not None:
                return found
        return None

    def feed(self, token: Token) -> None:
        """Go on with a token; the end of the text has the type `END`.

        Raises UnexpectedTokenError where the parser cannot.
        """
        states, values, kind = self.states, self.values, token.type
        actions, gotos, rules = self._tables.actions, self._tables.gotos, self._tables.rules
        while not (kind == END and states[-1] == self._end):
            action = actions[states[-1]].get(kind)
            if action is None:
                raise UnexpectedTokenError(token)
            if action >= 0:
                states.append(action)
                values.append(token)
                return
            rule = rules[~action]
            if rule.size == 1 and rule.bare:  # most: the levels of an expression
                states[-1] = gotos[states[-2]][rule.origin]
                continue
            read: list[Any] = []
            if rule.size:
                read = values[-rule.size :]
                del states[-rule.size :], values[-rule.size :]
            states.append(gotos[states[-1]][rule.origin])
            values.append(rule.tree(read))

    def accepted(self) -> set[str]:
        """Types of the tokens that the parser can go on with."""
        return {kind for kind in self._tables.actions[self.states[-1]] if self._takes(kind)}

    def _takes(self, kind: str) -> bool:
        tables, states = self._tables, self.states.copy()
        while not (kind == END and states[-1] == self._end):
            action = tables.actions[states[-1]].get(kind)
            if action is None or action >= 0:
                return action is not None
            rule = tables.rules[~action]
            del states[len(states) - rule.size :]
            states.append(tables.gotos[states[-1]][rule.origin])
        return True
