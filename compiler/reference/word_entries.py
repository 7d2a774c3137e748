"""The words of the language, and what scenes may name, as entries of the reference."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from math import prod

from bgc.grammar.language_words import PLACES, TABLE
from bgc.grammar.word import Reserved, Word
from bgc.language.scene_tables import (
    ACCOUNTS,
    DEVICE_COMMANDS,
    DEVICE_INPUTS,
    Channel,
)
from bgc.language.shape_table import COLOURS, SHAPES
from bgc.language.solver import SOLVER_OPTIONS
from bgc.printing.text_tables import Table
from bgc.reference.entry import Block, Code, Entry, Group, Text
from bgc.values.units import si_symbol

_QUOTED = re.compile(r"`([^`]+)`")
_RESERVED = {
    Reserved.EVERYWHERE: "It cannot be a name.",
    Reserved.IN_SCENES: "It cannot be a name in a scene.",
    Reserved.NOWHERE: "It may be a name too.",
}


def _word(name: str) -> Entry:
    word = TABLE[name]
    return Entry("word", name, word.summary.rstrip("."), tuple(_body(word)), word.related)


def _body(word: Word) -> Iterator[Block]:
    forms = _QUOTED.findall(word.form.partition(", with ")[0])
    if forms:
        yield Code("\n".join(forms))
    if word.begins:
        yield Text(f"It stands {' or '.join(PLACES[block] for block in word.begins)}.")
    yield from map(Text, word.doc)
    if word.example:
        yield Text("Example:")
        yield Code(word.example)
    if word.word == "solver":
        yield solver_options()
    yield Text(_RESERVED[word.reserved])


WORDS = Group(
    "words",
    "the statements and words of the language",
    lambda: {name: word.summary.rstrip(".") for name, word in TABLE.items()},
    _word,
    aliases=("statements", "statement", "keywords", "word", "keyword"),
)
"""All words of the language."""


# --- what scenes name -----------------------------------------------------------------------


def solver_options(names: Collection[str] = tuple(SOLVER_OPTIONS)) -> Table:
    """Return the options of solvers, or those of some names, as a table."""
    rows = tuple(
        (
            name,
            option.unit or "",
            option.default,
            option.flag,
            option.doc,
        )
        for name, option in SOLVER_OPTIONS.items()
        if name in names
    )
    return Table("options of a solver", ("name", "unit", "default", "option", "meaning"), rows)


def _channels(title: str, table: Mapping[str, Channel]) -> Table:
    rows = tuple(
        (
            name,
            str(prod(channel.shape)),
            "" if channel.dimension is None else si_symbol(channel.dimension),
            channel.doc,
        )
        for name, channel in table.items()
    )
    return Table(title, ("name", "components", "unit", "meaning"), rows)


_TOPICS: Mapping[str, Entry] = {
    entry.name: entry
    for entry in (
        Entry(
            "name in scenes",
            "energy",
            "the energy accounts of a run",
            (
                Code("observe energy.stored, energy.residual;"),
                Table("accounts, in J", ("name", "meaning"), tuple(ACCOUNTS.items())),
                Text(
                    "The residual measures the accuracy of the run. Bonds of pseudo domains do "
                    "not count."
                ),
            ),
            ("observe", "BG716"),
        ),
        Entry(
            "name in scenes",
            "devices",
            "the channels of a haptic device",
            (
                Code(
                    'device hand = trace(file = "motion.csv");\n'
                    "drive handle.x = hand.position;\n"
                    "drive hand.force = handle.force;"
                ),
                _channels("channels that a device gives", DEVICE_INPUTS),
                _channels("commands that a device takes", DEVICE_COMMANDS),
                Text(
                    "The driver `trace` plays a CSV file with the columns time, x, y, z (s and m) "
                    "and, where they are wanted, qw, qx, qy, qz, gripper, button1 to button8. Its "
                    "options: `file`, from the folder of the scene's file; `scale`, a factor of "
                    "the positions (1); `loop`, 1 to start again after the last row (0)."
                ),
            ),
            ("device", "drive", "step"),
        ),
        Entry(
            "name in shapes",
            "shapes",
            "the shapes with which parts are drawn, and their colours",
            (
                Code('shape cylinder(0.3 m, 1 m) at [0, 0, 1 m], rot_x(pi/2) colour "steel";'),
                Table(
                    "shapes",
                    ("shape", "meaning"),
                    tuple((kind.form(name), kind.doc) for name, kind in SHAPES.items()),
                ),
                Table("colours, beside `#rrggbb`", ("name", "is"), tuple(COLOURS.items())),
                Text(
                    "Lengths are in m. A rope stands `from a to b`; a cylinder or a capsule may, "
                    "without its length. The rows of the waves of a sea are [amplitude in m, "
                    "angular frequency in rad/s, direction in rad, phase in rad]."
                ),
            ),
            ("shape", "BG492", "BG493"),
        ),
        Entry(
            "constant",
            "pi",
            "3.141592653589793, the ratio of a circle's circumference to its diameter",
        ),
    )
}

SCENE_NAMES = Group(
    "names",
    "names that need no declaration",
    lambda: {name: entry.summary for name, entry in _TOPICS.items()},
    _TOPICS.__getitem__,
)
"""Names that mean something without being declared."""
