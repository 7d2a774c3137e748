"""Observe every variable of a program that has a name, so that its equations can be checked."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction

from program_tree import Expr, Num, Observed, Program, Step, read
from raw_equations import Elaboration, Element, Instance

_LETTERS = {
    "C": ("q", "e", "f"),
    "I": ("p", "e", "f"),
    "IC": ("q", "p", "e", "f"),
    "J0": ("e",),
    "J1": ("f",),
}


def with_all_observed(program: Program) -> Program:
    """The program with all its named variables as columns `v0`, `v1`, .."""
    found = list(dict.fromkeys(_named(Elaboration(program).main)))
    observed = tuple(Observed(f"v{k}", e, 1.0) for k, e in enumerate(found))
    return program.with_scene(observed=observed, accounts=True)


def _named(inst: Instance) -> Iterator[Expr]:
    path = _steps(inst.path)
    for value in inst.values.values():
        if value.word in ("state", "unknown", "signal", "output", "held"):
            for k in range(value.shape or 1):
                component = k + 1 if value.shape else None
                yield read(*path, Step(value.name), component=component)
    for part in inst.parts.values():
        if isinstance(part, Instance):
            yield from _named(part)
        else:
            yield from _of_element(part)


def _of_element(element: Element) -> Iterator[Expr]:
    kind, widths = element.part.type, element.part.width
    if kind in ("Mux", "Demux") or not element.ends:
        return
    sides = [("", widths[0])]
    if kind in ("TF", "GY") and len(widths) == 2:
        sides = [("1", widths[0]), ("2", widths[1])]
    path = _steps(element.path)
    for letter in _LETTERS.get(kind, ("e", "f")):
        for side, width in sides:
            for k in range(width):
                component = k + 1 if width > 1 else None
                yield read(*path, Step(letter + side), component=component)


def _steps(path: str) -> list[Step]:
    steps = []
    for name, index in re.findall(r"(\w+)(?:\[(\d+)\])?", path):
        steps.append(Step(name, Num(Fraction(index)) if index else None))
    return steps
