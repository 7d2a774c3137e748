"""Eigenvalues and their directions as text for messages."""

from __future__ import annotations

from bgc.diagnostics.catalogue.physics import listed_direction
from bgc.passivity.definite import Indefinite


def spectrum_of(bad: Indefinite, variable: str) -> str:
    """`the eigenvalue -3 along f[1] = 1, f[3] = 0.5`, or how many there are."""
    along = listed_direction(variable, bad.direction)
    if bad.count == 1:
        return f"the eigenvalue {bad.eigenvalue:.6g} along {along}"
    return f"{bad.count} negative eigenvalues, the least {bad.eigenvalue:.6g} along {along}"


def pair_of(bad: Indefinite) -> str:
    """The single entry at fault as text; empty where there is none."""
    pair = bad.pair
    if pair is None:
        return ""
    i, j = pair.row, pair.column
    return (
        f"its entry [{i}, {j}] is {pair.entry:.6g}, where [{i}, {i}] and [{j}, {j}] allow "
        f"{pair.limit:.6g} at most"
    )
