"""A transfer function on a terminal: the formula, then gain, poles, zeros and values as tables."""

from __future__ import annotations

from bgc.printing.text_tables import Table
from bgc.symbolic.notation import (
    LONG_FACTOR,
    Spelled,
    Values,
    described,
    pair_texts,
    short,
    static_number,
)
from bgc.symbolic.polynomial_text import Writer, broken
from bgc.symbolic.transfer import TransferFunction

_LONG_FORMULA = 72  # characters of a formula in a table, without --full


def transfer_lines(function: TransferFunction, width: int, full: bool) -> list[str]:
    """The formula in lines of at most `width` characters, where its terms permit it.

    As a fraction where it fits, else with names for its factors, which follow. Very long factors
    are only counted unless `full`.
    """
    written = Spelled(function, latex=False)
    left = f"G({function.laplace.name}) = "
    above, below = written.sides(named=False)
    lines = [f"{function.output} by {function.input}", ""]
    if below == "1" and len(left) + len(above) <= width - 2:
        lines.append(f"  {left}{above}")
    elif len(left) + max(len(above), len(below)) <= width - 2:
        lines += _fraction(left, above, below)
    else:
        above, below = written.sides(named=True)
        lines += [f"  {left}{written.writer.fraction(above, below)}", ""]
        for name, text in written.definitions():
            lines += _definition(name, text, width, full)
    if written.defined:
        lines += ["", *(f"  {name} = {text}" for name, text in written.defined)]
    return lines


def _fraction(left: str, above: str, below: str) -> list[str]:
    size = max(len(above), len(below))
    indent = " " * (len(left) + 2)
    return [
        f"{indent}{above:^{size}}".rstrip(),
        f"  {left}{'-' * size}",
        f"{indent}{below:^{size}}".rstrip(),
    ]


def _definition(name: str, text: str, width: int, full: bool) -> list[str]:
    left = f"  {name} = "
    if len(text) > LONG_FACTOR and not full:
        return [f"{left}{len(text):,} characters; --full prints them"]
    first, *rest = broken(text, width - len(left))
    return [left + first, *(" " * len(left) + line for line in rest)]


def transfer_tables(function: TransferFunction, values: Values, full: bool) -> list[Table]:
    """Static gain, poles and zeros as formulas and numbers; then the letters' values."""
    written = Spelled(function, latex=False)
    gain = written.static_gain()
    number = static_number(function, values)
    formula = _shown(gain, full) if gain else "it integrates"
    rows = [("static gain", formula, number, function.unit)]
    for name, factors in (("pole", function.pole_factors), ("zero", function.zero_factors)):
        for roots in factors:
            label = name if roots.count == 1 else f"{name}, {roots.count} times"
            for formula, found in described(function, written.writer, roots, values):
                text = _shown(formula, full) if formula else ""
                if roots.pairs is None and label:
                    text = f"no formula: degree {roots.factor.degrees()[0]}"
                rows.append((label, text, ", ".join(pair_texts(found)), "1/s"))
                label = ""
    header = ("", "formula", "value", "unit")
    return [
        Table("gain, poles and zeros", header, tuple(rows)),
        Table("values", ("letter", "value", "unit", "follows from"), _letters(function, values)),
    ]


def _shown(text: str, full: bool) -> str:
    if full or len(text) <= _LONG_FORMULA:
        return text
    return f"{len(text)} characters; --full prints them"


def _letters(function: TransferFunction, values: Values) -> tuple[tuple[str, ...], ...]:
    free = function.ratio.symbols
    writer = Writer({}, latex=False)
    rows = []
    for letter, value in function.symbol_numbers(values).items():
        if letter in free:
            follows = function.dependent.get(letter)
            rows.append(
                (
                    letter.name,
                    short(float(value)),
                    function.units.get(letter, ""),
                    "" if follows is None else writer.expression(follows),
                )
            )
    return tuple(rows)
