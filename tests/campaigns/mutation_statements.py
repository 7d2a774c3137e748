"""Mutations of statements: their order, parts, names, widths and arguments."""

from __future__ import annotations

import itertools
import random
import re
from collections.abc import Sequence
from dataclasses import dataclass

from mutation_tokens import Edit, Token, change_number, dimension, joined, on_token, tokens_of
from mutation_words import ELEMENTS, KEYWORDS, STATEMENTS


@dataclass(frozen=True, slots=True)
class Statement:
    """A statement or block: its range in the list of tokens, and its depth in braces."""

    start: int
    end: int
    depth: int


def statements_of(tokens: Sequence[Token]) -> list[Statement]:
    """All statements and blocks of a text; of one that is not balanced, some of them."""
    found: list[Statement] = []
    open_blocks: list[int] = []
    start, round_depth = 0, 0
    for k, token in enumerate(tokens):
        if token.kind != "sign":
            continue
        if token.text in "([":
            round_depth += 1
        elif token.text in ")]":
            round_depth = max(0, round_depth - 1)
        elif token.text == "{":
            open_blocks.append(start)
            start, round_depth = k + 1, 0
        elif token.text == "}" and open_blocks:
            found.append(Statement(open_blocks.pop(), k + 1, len(open_blocks)))
            start, round_depth = k + 1, 0
        elif token.text == ";" and round_depth == 0:
            found.append(Statement(start, k + 1, len(open_blocks)))
            start = k + 1
    return found


def _two_statements(rng: random.Random, text: str) -> tuple[list[Token], list[Statement]] | None:
    tokens = tokens_of(text)
    found = statements_of(tokens)
    return (tokens, found) if found else None


def _swap_statements(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    a, b = sorted((rng.choice(statements), rng.choice(statements)), key=lambda s: s.start)
    if a.end > b.start:  # one lies in the other
        return text
    return joined(
        [
            *tokens[: a.start],
            *tokens[b.start : b.end],
            *tokens[a.end : b.start],
            *tokens[a.start : a.end],
            *tokens[b.end :],
        ]
    )


def _drop_statement(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    chosen = rng.choice(statements)
    return joined([*tokens[: chosen.start], *tokens[chosen.end :]])


def _copy_statement(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    chosen, place = rng.choice(statements), rng.choice(statements)
    at = rng.choice((place.start, place.end))
    return joined([*tokens[:at], *tokens[chosen.start : chosen.end], *tokens[at:]])


def _new_statement(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    at = rng.choice(statements).end
    made = rng.choice(STATEMENTS)
    names = sorted({t.text for t in tokens if t.kind == "name"})
    if names and rng.random() < 0.7:
        made = re.sub(r"\b[a-z]\d?\b(?!\()", lambda _: rng.choice(names), made)
    return joined([*tokens[:at], Token("blank", f"\n{made}"), *tokens[at:]])


def _wrap_statement(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    chosen = rng.choice(statements)
    head = rng.choice(
        ("for i in 1..3 {", "for k in 0..1 {", "if 1 > 0 {", "if time > 1 {", "{", "model W {")
    )
    inner = tokens[chosen.start : chosen.end]
    return joined(
        [
            *tokens[: chosen.start],
            Token("sign", head),
            *inner,
            Token("sign", "}"),
            *tokens[chosen.end :],
        ]
    )


def _rename(rng: random.Random, text: str) -> str:
    if (found := on_token(rng, text, "name")) is None:
        return text
    tokens, at = found
    other = rng.choice([t.text for t in tokens if t.kind == "name"])
    old = tokens[at].text
    new = rng.choice((other, other, other, rng.choice(ELEMENTS), rng.choice(KEYWORDS), "x" * 300))
    everywhere = rng.random() < 0.6
    return joined(
        [
            Token(t.kind, new) if t.text == old and (everywhere or k == at) else t
            for k, t in enumerate(tokens)
        ]
    )


def _other_element(rng: random.Random, text: str) -> str:
    tokens = tokens_of(text)
    places = [k for k, token in enumerate(tokens) if token.text in ELEMENTS]
    if not places:
        return text
    tokens[rng.choice(places)] = Token("name", rng.choice(ELEMENTS))
    return joined(tokens)


def _reverse_chain(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    chains = [s for s in statements if any(t.text == "->" for t in tokens[s.start : s.end])]
    chains = [s for s in chains if not any(t.text == "{" for t in tokens[s.start : s.end])]
    if not chains:
        return text
    chosen = rng.choice(chains)
    ends = joined(tokens[chosen.start : chosen.end - 1]).split("->")
    if rng.random() < 0.5:
        ends.reverse()
    else:
        rng.shuffle(ends)
    return joined([*tokens[: chosen.start], Token("name", "->".join(ends) + ";")]) + joined(
        tokens[chosen.end :]
    )


def _double_part(rng: random.Random, text: str) -> str:
    """Add a part of the same type under another name, bonded as the first is."""
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    parts = [
        s
        for s in statements
        if (words := [t for t in tokens[s.start : s.end] if t.kind != "blank"])[0].kind == "name"
        and len(words) > 2
        and words[1].text == ":"
    ]
    if not parts:
        return text
    chosen = rng.choice(parts)
    name = next(t.text for t in tokens[chosen.start : chosen.end] if t.kind != "blank")
    new = f"{name}_{rng.randrange(3)}"

    def again(statement: Statement) -> list[Token]:
        return [
            Token(t.kind, new) if t.text == name else t
            for t in tokens[statement.start : statement.end]
        ]

    bonds = [
        s
        for s in statements
        if s.depth == chosen.depth
        and any(t.text == "->" for t in tokens[s.start : s.end])
        and any(t.text == name for t in tokens[s.start : s.end])
    ]
    made = list(tokens)
    for statement in sorted([chosen, *bonds], key=lambda s: -s.start):
        made[statement.end : statement.end] = again(statement)
    return joined(made)


def _width(rng: random.Random, text: str) -> str:
    tokens = tokens_of(text)
    places = [
        k
        for k, token in enumerate(tokens)
        if token.kind == "number" and k > 0 and tokens[k - 1].text in ("[", ", ", "..", "^")
    ]
    if not places:
        return dimension(rng, text)
    at = rng.choice(places)
    tokens[at] = Token("number", rng.choice(("0", "1", "2", "3", "4", "6", "7", "50", "-1", "n")))
    return joined(tokens)


def _arguments(rng: random.Random, text: str) -> str:
    """Shuffle, drop, double or name the arguments of a call or of a type."""
    tokens = tokens_of(text)
    calls: list[tuple[int, int, list[int]]] = []
    for k, token in enumerate(tokens):
        if token.text != "(":
            continue
        depth, commas = 0, []
        for j in range(k, len(tokens)):
            if tokens[j].text in "([" and tokens[j].kind == "sign":
                depth += 1
            elif tokens[j].text in ")]" and tokens[j].kind == "sign":
                depth -= 1
                if depth == 0:
                    calls.append((k, j, commas))
                    break
            elif tokens[j].text == "," and depth == 1:
                commas.append(j)
    if not calls:
        return text
    start, end, commas = rng.choice(calls)
    bounds = [start, *commas, end]
    given = [joined(tokens[a + 1 : b]).strip() for a, b in itertools.pairwise(bounds)]
    match rng.randrange(6):
        case 0:
            rng.shuffle(given)
        case 1:
            del given[rng.randrange(len(given))]
        case 2:
            given.insert(rng.randrange(len(given) + 1), rng.choice(given))
        case 3:
            k = rng.randrange(len(given))
            given[k] = (
                f"{rng.choice(('e', 'f', 'q0', 'p0', 'f0', 'e0', 'conductance'))} = {given[k]}"
            )
        case 4:
            given = [g.partition("=")[2].strip() or g for g in given]
        case _:
            a, b, _ = rng.choice(calls)
            given.append(joined(tokens[a + 1 : b]))
    return joined(tokens[: start + 1]) + ", ".join(given) + joined(tokens[end:])


TREES: tuple[Edit, ...] = (
    _swap_statements,
    _drop_statement,
    _drop_statement,
    _copy_statement,
    _new_statement,
    _new_statement,
    _wrap_statement,
    _rename,
    _rename,
    _other_element,
    _other_element,
    _reverse_chain,
    _double_part,
    _double_part,
    _width,
    _width,
    _arguments,
    _arguments,
    change_number,
)
