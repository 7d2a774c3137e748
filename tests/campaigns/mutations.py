"""Mutations of `.bg` texts: of bytes, of tokens, of statements, and of two files spliced.

All functions take a random generator and a text, and return a text; nothing here knows the parser
of the language, so that a mutant can itself be mutated.
"""

from __future__ import annotations

import random

from mutation_statements import TREES, statements_of
from mutation_tokens import BYTES, TOKENS, Edit, joined, tokens_of


def spliced(rng: random.Random, text: str, other: str) -> str:
    """A text with a part of another: its head, one of its statements, or one of its lines."""
    match rng.randrange(4):
        case 0:
            a, b = tokens_of(text), tokens_of(other)
            return joined(a[: rng.randrange(len(a) + 1)]) + joined(b[rng.randrange(len(b) + 1) :])
        case 1:
            return text + "\n" + other if rng.random() < 0.5 else other + "\n" + text
        case 2:
            ours, theirs = text.splitlines(keepends=True), other.splitlines(keepends=True)
            if not ours or not theirs:
                return text + other
            ours.insert(rng.randrange(len(ours)), rng.choice(theirs))
            return "".join(ours)
        case _:
            a, b = tokens_of(text), tokens_of(other)
            first, second = statements_of(a), statements_of(b)
            if not first or not second:
                return text
            place, chosen = rng.choice(first), rng.choice(second)
            at = rng.choice((place.start, place.end))
            taken = b[chosen.start : chosen.end]
            keep = a[at:] if rng.random() < 0.7 else a[place.end :]
            return joined([*a[:at], *taken, *keep])


LEVELS: tuple[tuple[Edit, ...], ...] = (BYTES, TOKENS, TREES)
_SHARES = (12, 40, 48)
_ENCODINGS = ("utf-16", "latin-1", "utf-8-sig", "utf-32", "cp037")


def mutant(rng: random.Random, text: str, other: str) -> bytes:
    """Mutate a text in one to four places, mostly on one level; `other` is spliced into some."""
    if rng.random() < 0.1:
        text = spliced(rng, text, other)
    level = rng.choices(LEVELS, _SHARES)[0]
    for _ in range(rng.choice((1, 1, 1, 1, 2, 2, 3, 4))):
        edits = level if rng.random() < 0.9 else rng.choice(LEVELS)
        text = rng.choice(edits)(rng, text)
    made = (
        text.encode("utf-8", errors="surrogateescape" if rng.random() < 0.5 else "replace")
        if (_encodable(text))
        else text.encode("utf-8", errors="replace")
    )
    chance = rng.random()
    if chance < 0.01:
        return text.encode(rng.choice(_ENCODINGS), errors="replace")
    if chance < 0.03 and made:
        at = rng.randrange(len(made))
        return made[:at] + bytes([rng.randrange(256)]) + made[at + 1 :]
    if chance < 0.04:
        return made.replace(b"\n", rng.choice((b"\r\n", b"\r", b"\n\n", b" ")))
    return made


def _encodable(text: str) -> bool:
    """Return whether bytes that were not UTF-8 can be written as they were."""
    try:
        text.encode("utf-8", errors="surrogateescape")
    except UnicodeEncodeError:
        return False
    return True
