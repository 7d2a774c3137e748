"""Mutations of bytes and of tokens."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from mutation_words import DIMENSIONS, ELEMENTS, FUNCTIONS, KEYWORDS, NUMBERS, PIECES, UNITS

Edit: TypeAlias = Callable[[random.Random, str], str]

_TOKEN = re.compile(
    r"""(?P<blank>\s+|//[^\n]*|/\*.*?\*/)|(?P<text>"[^"\n]*")"""
    r"""|(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)"""
    r"""|(?P<sign>\.\.|->|[<>=!]=|.)""",
    re.DOTALL,
)


@dataclass(frozen=True, slots=True)
class Token:
    """A token with its kind: `blank`, `text`, `number`, `name`, `word` (a keyword) or `sign`."""

    kind: str
    text: str


def tokens_of(text: str) -> list[Token]:
    """Split a text into tokens that join to it."""
    found = []
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or "sign"
        if kind == "name" and match.group() in KEYWORDS:
            kind = "word"
        found.append(Token(kind, match.group()))
    return found


def joined(tokens: Sequence[Token]) -> str:
    return "".join(token.text for token in tokens)


# --- bytes ------------------------------------------------------------------------------


def _delete(rng: random.Random, text: str) -> str:
    at, length = rng.randrange(len(text) + 1), rng.choice((1, 1, 1, 2, 5, 20, 200))
    return text[:at] + text[at + length :]


def _insert(rng: random.Random, text: str) -> str:
    at = rng.randrange(len(text) + 1)
    return text[:at] + rng.choice(PIECES) * rng.choice((1, 1, 1, 2, 3, 300)) + text[at:]


def _swap(rng: random.Random, text: str) -> str:
    a, b = sorted((rng.randrange(len(text) + 1), rng.randrange(len(text) + 1)))
    length = min(rng.choice((1, 1, 3, 10, 60)), b - a)
    return (
        text[:a]
        + text[b : b + length]
        + text[a + length : b]
        + text[a : a + length]
        + (text[b + length :])
    )


def _truncate(rng: random.Random, text: str) -> str:
    at = rng.randrange(len(text) + 1)
    return text[:at] if rng.random() < 0.7 else text[at:]


def _repeat(rng: random.Random, text: str) -> str:
    at, length = rng.randrange(len(text) + 1), rng.choice((1, 3, 10, 50, 300))
    piece = text[at : at + length]
    return text[:at] + piece * rng.choice((2, 2, 3, 40)) + text[at + length :]


# --- tokens -----------------------------------------------------------------------------


def on_token(rng: random.Random, text: str, *kinds: str) -> tuple[list[Token], int] | None:
    tokens = tokens_of(text)
    places = [k for k, t in enumerate(tokens) if (t.kind in kinds if kinds else t.kind != "blank")]
    return (tokens, rng.choice(places)) if places else None


def _same_kind(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text)) is None:
        return text
    tokens, at = found
    tokens[at] = rng.choice([t for t in tokens if t.kind == tokens[at].kind])
    return joined(tokens)


def _any_kind(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text)) is None:
        return text
    tokens, at = found
    tokens[at] = rng.choice(tokens)
    return joined(tokens)


def _word(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text, "name", "word")) is None:
        return text
    tokens, at = found
    tokens[at] = Token("name", rng.choice((*KEYWORDS, *ELEMENTS, *FUNCTIONS)))
    return joined(tokens)


def change_number(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text, "number")) is None:
        return text
    tokens, at = found
    tokens[at] = Token("number", rng.choice(NUMBERS))
    return joined(tokens)


def _unit(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text, "number")) is None:
        return text
    tokens, at = found
    blank = rng.choice((" ", " ", " ", "", "  "))
    if rng.random() < 0.5 and at + 2 < len(tokens) and tokens[at + 2].kind == "name":
        tokens[at + 2] = Token("name", rng.choice(UNITS))
    else:
        tokens[at] = Token("number", tokens[at].text + blank + rng.choice(UNITS))
    return joined(tokens)


def dimension(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text, "name")) is None:
        return text
    tokens, at = found
    dims = rng.choice(DIMENSIONS)
    tokens[at] = Token("name", tokens[at].text + (dims if dims.startswith("[") else f"[{dims}"))
    return joined(tokens)


def _call(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text, "number", "name")) is None:
        return text
    tokens, at = found
    inner = tokens[at].text
    name = rng.choice(FUNCTIONS)
    made = rng.choice(
        (
            f"{name}({inner})",
            f"{name}({inner}, {inner})",
            f"({inner})^{rng.choice(('2', '-1', '0.5', inner))}",
            f"(if {inner} > 0 then {inner} else 0)",
            f"[{inner}, {inner}]",
            f"-{inner}",
            f"({inner}/0)",
            f"{inner}.{rng.choice(('x', 'e', 'f', 'q', 'p', 'power', 'z', 'energy'))}",
        )
    )
    tokens[at] = Token("name", made)
    return joined(tokens)


def _drop_token(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text)) is None:
        return text
    tokens, at = found
    del tokens[at]
    return joined(tokens)


def _double_token(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text)) is None:
        return text
    tokens, at = found
    tokens[at:at] = [tokens[at], Token("blank", rng.choice((" ", "", " ")))]
    return joined(tokens)


def _swap_tokens(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text)) is None:
        return text
    tokens, a = found
    b = min(len(tokens) - 1, a + rng.choice((1, 2, 2, 3, 4, 10)))
    tokens[a], tokens[b] = tokens[b], tokens[a]
    return joined(tokens)


BYTES: tuple[Edit, ...] = (_delete, _delete, _insert, _insert, _swap, _truncate, _repeat)
TOKENS: tuple[Edit, ...] = (
    _same_kind,
    _same_kind,
    _same_kind,
    _any_kind,
    _word,
    change_number,
    change_number,
    _unit,
    _unit,
    dimension,
    _call,
    _call,
    _drop_token,
    _double_token,
    _swap_tokens,
)
