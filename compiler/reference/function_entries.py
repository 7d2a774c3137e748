"""The functions of the language as entries of the reference."""

from __future__ import annotations

from bgc.printing.text_tables import Table
from bgc.reference.entry import Block, Code, Entry, Group, Text
from bgc.values.functions import BUILTINS


def _entry(name: str) -> Entry:
    function = BUILTINS[name]
    rows = (
        ("shape", *_halves(function.shapes)),
        ("unit", *_halves(function.units)),
    )
    body: list[Block] = [
        Code(f"{name}({function.arguments})"),
        Text(function.doc),
        Table("", ("", "argument", "result"), rows),
    ]
    if function.jumps:
        body.append(Text("The result is held over a step, which ends where the result changes."))
    return Entry("function", name, function.doc.rstrip("."), tuple(body), ("functions",))


def _halves(text: str) -> tuple[str, str]:
    """Split `of the argument; of the result`."""
    argument, _, result = text.rpartition("; ")
    return argument, result


GROUP = Group(
    "functions",
    "the functions of the language",
    lambda: {name: function.doc.rstrip(".") for name, function in BUILTINS.items()},
    _entry,
    (
        Text(
            "Angles are in rad: `sin(30 deg)` is 0.5. The power is `^`, as in `x^2`. The library "
            "has functions too, and so may any file (`bgc doc function`)."
        ),
    ),
)
"""All built-in functions."""
