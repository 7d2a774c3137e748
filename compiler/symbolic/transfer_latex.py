"""A transfer function in LaTeX, for the package amsmath."""

from __future__ import annotations

from bgc.printing.align import LINE, aligned, broken_sum, signed, visible_width
from bgc.symbolic.notation import (
    LONG_FACTOR,
    Spelled,
    Values,
    described,
    pair_texts,
    static_number,
)
from bgc.symbolic.transfer import TransferFunction


def transfer_latex(function: TransferFunction, values: Values, full: bool) -> str:
    """The formula, its gain, poles and zeros as an `align*` environment of amsmath.

    Numbers stand beside the formulas, behind an approximate equals sign. Very long factors are
    only counted, in a comment, unless `full`.
    """
    written = Spelled(function, latex=True)
    writer = written.writer
    s = function.laplace.name
    above, below = written.sides(named=False)
    inline = max(visible_width(above), visible_width(below)) <= LINE
    lines: list[tuple[str, str]] = []
    left_out: list[str] = []
    if not inline:
        above, below = written.sides(named=True)
    lines.append((f"G({s})", writer.fraction(above, below)))
    if not inline:
        for name, terms in written.long_definitions():
            length = sum(len(text) for _, text in terms)
            if length <= LONG_FACTOR or full:
                lines.append((name, broken_sum(signed(terms))))
            else:
                left_out.append(f"% {name}: {length:,} characters; --full prints them")
    lines += written.defined
    gain = written.static_gain()
    static = _approximately(gain, static_number(function, values)) if gain else r"\infty"
    lines.append(("G(0)", static))
    for letter, factors in (("p", function.pole_factors), ("z", function.zero_factors)):
        count = 0
        for roots in factors:
            for formula, found in described(function, writer, roots, values):
                size = 2 if r"\pm" in formula else max(1, len(found))
                names = ",".join(str(count + k + 1) for k in range(size))
                count += size
                number = r",\;".join(pair_texts(found, r"\pm"))
                shown = formula if visible_width(formula) <= 2 * LINE or full else ""
                if shown or number:
                    lines.append((f"{letter}_{{{names}}}", _approximately(shown, number)))
    title = "\n".join([f"transfer function of {function.output} by {function.input}", *left_out])
    return aligned(title, lines).replace(r"&= \approx", r"&\approx")


def _approximately(formula: str, number: str) -> str:
    """A formula with its number, which is left out where it says the same."""
    if not formula:
        return rf"\approx {number}"
    if formula == number or not number or number.isalpha():
        return formula
    return rf"{formula} \approx {number}"
