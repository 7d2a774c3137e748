"""Planar linkages on mounts at random (`../physics/mounted_linkages.py`): do they stay closed?

A linkage has to compile; run for 0.5 s, its loop and the rates in it have to stay closed to the
digits of its mounts by the lengths of its bars alone, and the account of energy has to be closed. A
run may also end with the status of a singular position (BG735).
"""

from __future__ import annotations

import sys
from itertools import product
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "physics"))

from judging import Verdict
from mounted_linkages import (
    BASES,
    KINDS,
    MOUNTS,
    MountedLinkage,
    mounted_linkage,
)

import bgc

PORTION = 12
CPU_SECONDS = 120.0  # most of it the C compiler
OPEN = 1e-8  # m, rad and their rates
RESIDUAL = 1e-7  # of the energy that is exchanged, and J
DIGITS = (0, 7)  # decimals of all mounts, 0 for all that a double has
GROUPS = tuple(product(MOUNTS, KINDS, BASES))


def _case(seed: int, number: int) -> tuple[str, MountedLinkage, int]:
    """The kinds follow each other in turn, in each round with other lengths and digits."""
    rounds, kind = divmod(number, len(GROUPS))
    mounts, name, base = GROUPS[kind]
    digits = DIGITS[rounds // 4 % len(DIGITS)]
    drawn = 100 * seed + rounds
    linkage = mounted_linkage(drawn, name, mounts, base, 1 + drawn % 4, digits)
    return f"{name} {mounts} {base} {drawn}, {digits or 'all'} digits", linkage, digits


def text_of(seed: int, number: int) -> tuple[str, bytes]:
    """The kind of a case, and its text."""
    name, linkage, _ = _case(seed, number)
    return name, linkage.source.encode()


def judge(seed: int, number: int, folder: Path) -> list[Verdict]:
    """`ran`, `singular`, or the fault: not compiled, not closed, energy lost or gained."""
    name, linkage, digits = _case(seed, number)
    path = folder / "linkage.bg"
    path.write_text(linkage.source, "utf-8")
    try:
        result = bgc.compile(path, scene="linkage", preview=True).simulate(error=False)
    except bgc.BgError as error:
        codes = tuple(diagnostic.code for diagnostic in error.diagnostics)
        kind = "singular" if codes == ("BG735",) else "unjust"
        return [Verdict(kind, codes, f"{name}\n{error}")]
    except Exception as error:
        return [Verdict("traceback", (), f"{name}\n{type(error).__name__}: {error}")]
    q, v = (np.column_stack([result[f"{column}{k}"] for k in range(4)]) for column in "qv")
    misfit = linkage.misfit(q, v)
    if not misfit < max(OPEN, 1e3 * 10.0**-digits if digits else 0.0):
        return [Verdict("differs", (), f"{name}\nopen by {misfit:.2e}")]
    exchanged = np.ptp(result["energy.stored"])
    residual = np.abs(result["energy.residual"]).max()
    if not residual < RESIDUAL * (1 + exchanged):
        return [Verdict("differs", (), f"{name}\nenergy by {residual:.2e} of {exchanged:.2e}")]
    return [Verdict("ran")]
