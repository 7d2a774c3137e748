"""Mutations of `.bg` texts: of bytes, of tokens, of statements, and of two files spliced.

All functions take a random generator and a text, and return a text; nothing here knows the parser
of the language, so that a mutant can itself be mutated.
"""

from __future__ import annotations

import itertools
import random
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

Edit: TypeAlias = Callable[[random.Random, str], str]

_TOKEN = re.compile(
    r"""(?P<blank>\s+|//[^\n]*|/\*.*?\*/)|(?P<text>"[^"\n]*")"""
    r"""|(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)"""
    r"""|(?P<sign>\.\.|->|[<>=!]=|.)""",
    re.DOTALL,
)
KEYWORDS = (
    "import model interface domain function scene const param let signal input output state unknown"
    " equation project assert port for in if then else use set and or not der time is of out main"
    " pseudo effort flow device drive observe as plot against require within keep deadline solver"
    " step run every"
).split()
ELEMENTS = "Se Sf C I R TF GY J0 J1 Mux Demux Twist Wrench Frame".split()
FUNCTIONS = (
    "sqrt exp log sin cos tan asin acos atan atan2 abs sign min max tanh sum norm dot cross skew"
    " transpose inverse det diag eye zeros ones der floor mod length"
).split()
NUMBERS = (
    "0 1 2 3 -1 0.0 -0.0 1e308 1e-308 1e-320 1e400 1e-400 2147483648 99999999999999999999 0.1 1.5"
    " 1e5 1e16 1e-16 1000 7 12 100000 4.9e-324 00 1e+5 1.e3 .5 0x10 1_000 1e 3.14159265358979"
).split()
UNITS = (
    "m kg s N W J V A K rad deg mm m/s N*m kg^99 1/m m^-1 m^0.5 m/m/m furlong N*s/m s^-1 kN.m % "
    "psi bar degC m^2/s^3 Hz h ms 1 ohm mol kg*m^2 m**2 m^ /m * ° µm"
).split()
DIMENSIONS = (
    "[0] [1] [2] [3] [6] [-1] [1..3] [2..1] [1, 2] [2, 2] [3, 3] [2, 2, 2] [1e9] [time] [n] [] "
    "[1.5] [i] [100] [3000] [1..] [x] ['a'] [[1]] [1, 1, 1]"
).split(" [")
PIECES = (
    "{ } ( ) [ ] ; , . : = -> .. + - * / ^ < <= == != > \" ' // /* */ \\ # $ @ ! ? ~ | & ` "
    "\t \n \r \0 \x1b[31m \u202e \u2028 \xe9 \u20ac \U0001f600 \ufeff \ud800 0 1e9"
).split(" ")
STATEMENTS = (
    "x : R(1);",
    "state x = 1;",
    "der(x) = -x;",
    "unknown y = 0;",
    "equation y = x;",
    "equation y^3 + y = time;",
    "project x = max(x, 0);",
    'assert x > 0, "x";',
    "for i in 1..3 { a[i] : R(i); }",
    "for i in 1..0 { }",
    "if 1 > 2 { b : R(1); } else { b : C(1); }",
    "input u = 0;",
    "output w = x;",
    "signal s[3];",
    "const k = 3;",
    "param p = 1 in 0..2;",
    "port q in;",
    "let v = time;",
    "observe x;",
    "plot x;",
    "plot x against time;",
    "keep x;",
    "run 1 s;",
    "run 1 s every 1 ms;",
    "step 1 ms;",
    "solver rk4;",
    "solver rodas5p(rtol = 1e-3);",
    "deadline 1 ms;",
    "require x within 1;",
    "set p = 2;",
    "use slot = R(1);",
    "device h = omega;",
    'device h = trace(file = "x.csv");',
    "drive u = h.position;",
    "observe energy.residual;",
    "j : J1;",
    "j : J1[3];",
    "s1 : Se(e = 1);",
    "j -> x;",
    "s1 -> j -> x;",
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


def _joined(tokens: Sequence[Token]) -> str:
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


def _on_token(rng: random.Random, text: str, *kinds: str) -> tuple[list[Token], int] | None:
    tokens = tokens_of(text)
    places = [k for k, t in enumerate(tokens) if (t.kind in kinds if kinds else t.kind != "blank")]
    return (tokens, rng.choice(places)) if places else None


def _same_kind(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text)) is None:
        return text
    tokens, at = found
    tokens[at] = rng.choice([t for t in tokens if t.kind == tokens[at].kind])
    return _joined(tokens)


def _any_kind(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text)) is None:
        return text
    tokens, at = found
    tokens[at] = rng.choice(tokens)
    return _joined(tokens)


def _word(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text, "name", "word")) is None:
        return text
    tokens, at = found
    tokens[at] = Token("name", rng.choice((*KEYWORDS, *ELEMENTS, *FUNCTIONS)))
    return _joined(tokens)


def _number(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text, "number")) is None:
        return text
    tokens, at = found
    tokens[at] = Token("number", rng.choice(NUMBERS))
    return _joined(tokens)


def _unit(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text, "number")) is None:
        return text
    tokens, at = found
    blank = rng.choice((" ", " ", " ", "", "  "))
    if rng.random() < 0.5 and at + 2 < len(tokens) and tokens[at + 2].kind == "name":
        tokens[at + 2] = Token("name", rng.choice(UNITS))
    else:
        tokens[at] = Token("number", tokens[at].text + blank + rng.choice(UNITS))
    return _joined(tokens)


def _dimension(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text, "name")) is None:
        return text
    tokens, at = found
    dims = rng.choice(DIMENSIONS)
    tokens[at] = Token("name", tokens[at].text + (dims if dims.startswith("[") else f"[{dims}"))
    return _joined(tokens)


def _call(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text, "number", "name")) is None:
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
    return _joined(tokens)


def _drop_token(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text)) is None:
        return text
    tokens, at = found
    del tokens[at]
    return _joined(tokens)


def _double_token(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text)) is None:
        return text
    tokens, at = found
    tokens[at:at] = [tokens[at], Token("blank", rng.choice((" ", "", " ")))]
    return _joined(tokens)


def _swap_tokens(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text)) is None:
        return text
    tokens, a = found
    b = min(len(tokens) - 1, a + rng.choice((1, 2, 2, 3, 4, 10)))
    tokens[a], tokens[b] = tokens[b], tokens[a]
    return _joined(tokens)


# --- statements -------------------------------------------------------------------------


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
    return _joined(
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
    return _joined([*tokens[: chosen.start], *tokens[chosen.end :]])


def _copy_statement(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    chosen, place = rng.choice(statements), rng.choice(statements)
    at = rng.choice((place.start, place.end))
    return _joined([*tokens[:at], *tokens[chosen.start : chosen.end], *tokens[at:]])


def _new_statement(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    at = rng.choice(statements).end
    made = rng.choice(STATEMENTS)
    names = sorted({t.text for t in tokens if t.kind == "name"})
    if names and rng.random() < 0.7:
        made = re.sub(r"\b[a-z]\d?\b(?!\()", lambda _: rng.choice(names), made)
    return _joined([*tokens[:at], Token("blank", f"\n{made}"), *tokens[at:]])


def _wrap_statement(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    chosen = rng.choice(statements)
    head = rng.choice(
        ("for i in 1..3 {", "for k in 0..1 {", "if 1 > 0 {", "if time > 1 {", "{", "model W {")
    )
    inner = tokens[chosen.start : chosen.end]
    return _joined(
        [
            *tokens[: chosen.start],
            Token("sign", head),
            *inner,
            Token("sign", "}"),
            *tokens[chosen.end :],
        ]
    )


def _rename(rng: random.Random, text: str) -> str:
    if (found := _on_token(rng, text, "name")) is None:
        return text
    tokens, at = found
    other = rng.choice([t.text for t in tokens if t.kind == "name"])
    old = tokens[at].text
    new = rng.choice((other, other, other, rng.choice(ELEMENTS), rng.choice(KEYWORDS), "x" * 300))
    everywhere = rng.random() < 0.6
    return _joined(
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
    tokens[rng.choice(places)] = Token("name", rng.choice(ELEMENTS[:9]))
    return _joined(tokens)


def _reverse_chain(rng: random.Random, text: str) -> str:
    if (found := _two_statements(rng, text)) is None:
        return text
    tokens, statements = found
    chains = [s for s in statements if any(t.text == "->" for t in tokens[s.start : s.end])]
    chains = [s for s in chains if not any(t.text == "{" for t in tokens[s.start : s.end])]
    if not chains:
        return text
    chosen = rng.choice(chains)
    ends = _joined(tokens[chosen.start : chosen.end - 1]).split("->")
    if rng.random() < 0.5:
        ends.reverse()
    else:
        rng.shuffle(ends)
    return _joined([*tokens[: chosen.start], Token("name", "->".join(ends) + ";")]) + _joined(
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
    return _joined(made)


def _width(rng: random.Random, text: str) -> str:
    tokens = tokens_of(text)
    places = [
        k
        for k, token in enumerate(tokens)
        if token.kind == "number" and k > 0 and tokens[k - 1].text in ("[", ", ", "..", "^")
    ]
    if not places:
        return _dimension(rng, text)
    at = rng.choice(places)
    tokens[at] = Token("number", rng.choice(("0", "1", "2", "3", "4", "6", "7", "50", "-1", "n")))
    return _joined(tokens)


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
    given = [_joined(tokens[a + 1 : b]).strip() for a, b in itertools.pairwise(bounds)]
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
            given.append(_joined(tokens[a + 1 : b]))
    return _joined(tokens[: start + 1]) + ", ".join(given) + _joined(tokens[end:])


# --- two files --------------------------------------------------------------------------


def spliced(rng: random.Random, text: str, other: str) -> str:
    """A text with a part of another: its head, one of its statements, or one of its lines."""
    match rng.randrange(4):
        case 0:
            a, b = tokens_of(text), tokens_of(other)
            return _joined(a[: rng.randrange(len(a) + 1)]) + _joined(b[rng.randrange(len(b) + 1) :])
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
            return _joined([*a[:at], *taken, *keep])


BYTES: tuple[Edit, ...] = (_delete, _delete, _insert, _insert, _swap, _truncate, _repeat)
TOKENS: tuple[Edit, ...] = (
    _same_kind,
    _same_kind,
    _same_kind,
    _any_kind,
    _word,
    _number,
    _number,
    _unit,
    _unit,
    _dimension,
    _call,
    _call,
    _drop_token,
    _double_token,
    _swap_tokens,
)
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
    _number,
)
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
