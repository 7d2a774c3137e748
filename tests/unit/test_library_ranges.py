"""Every part of the library: a description, and a range of what cannot be negative."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import bgc.library
from bgc.grammar.parse import parse, read_source
from bgc.grammar.syntax import Assert, Model, Port, Value

LIBRARY = Path(bgc.library.__path__[0])
FILES = [p for p in sorted(LIBRARY.rglob("*.bg")) if p.parent.name not in ("scenes", "examples")]
# Units of masses, areas, stiffnesses and such, which no part has with a negative sign.
POSITIVE = frozenset(
    "kg m^2 m^3 m^4 kg*m^2 kg/m^3 N/m N*s/m N*m*s N*m/rad Hz s m^2/s ohm H F J W L rpm".split()
)
# Times of the world; inertias of bodies, which BG707 refuses, and resistances (BG460 warns).
FREE = {"start", "inertia", "along", "across", "brake", "damping"}
# Figures of a force that the hand feels, of either sign, and the debt of guards that have none.
HAPTIC = {"ElevationForce.stiffness", "NoGuard.debt", "Observer.debt"}


def models(file: Path) -> Iterator[Model]:
    parsed, _ = parse(read_source(file))
    yield from (found for found in parsed.declarations if isinstance(found, Model))


@pytest.mark.parametrize("file", FILES, ids=lambda p: f"{p.parent.name}.{p.stem}")
def test_every_part_is_described_and_has_ranges(file):
    text = read_source(file).text
    for model in models(file):
        assert model.doc, model.name
        asserted = " ".join(
            text[i.span.start : i.span.end] for i in model.items if isinstance(i, Assert)
        )
        for item in model.items:
            shown = isinstance(item, Port) or (
                isinstance(item, Value) and item.kind in ("param", "input", "output")
            )
            if shown and model.base is None:
                assert item.doc, f"{model.name}.{item.name} needs a `///`"
            if not isinstance(item, Value) or item.kind != "param" or model.interface:
                continue
            free = item.name in FREE or f"{model.name}.{item.name}" in HAPTIC
            if item.unit in POSITIVE and not free and not item.name.endswith("0"):
                ranged = item.range is not None or item.name in asserted
                assert ranged, f"{model.name}.{item.name} needs a range: in 0 {item.unit} .. ..;"
