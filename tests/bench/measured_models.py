"""Models that benchmarks of methods run: which, for how long, and the errors of their runs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.model import Model
from bgc.runtime.results.result import Result

ROOT = Path(__file__).parents[2]
LONGEST = 10.0  # s of a scene outside the published problems
Source = tuple[str, Path, str | None]  # a name, a file, and a scene of it


def scenes(folders: Sequence[str]) -> Iterator[Source]:
    """All scenes of the files in folders of the repository."""
    for folder in folders:
        for file in sorted((ROOT / folder).glob("*.bg")):
            for scene in re.findall(r"^scene (\w+)", file.read_text("utf-8"), re.MULTILINE):
                yield f"{file.stem}: {scene}", file, scene


def models(sources: Iterable[Source], chosen: Sequence[str]) -> Iterator[tuple[str, Model, float]]:
    """Name, compiled model and duration, s, of those whose names contain one of the texts."""
    for name, file, scene in sources:
        if chosen and not any(text in name for text in chosen):
            continue
        try:
            model = bgc.compile(file, scene=scene)
        except BgError:
            continue  # a test's model that needs a choice
        duration = model.facts.duration
        if duration is not None:
            published = file.parent.name == "ivp"
            yield name, model, duration if published else min(duration, LONGEST)


def error_of(result: Result, reference: Result) -> float:
    """The largest error over the observed quantities, relative to their ranges."""
    worst = 0.0
    for name in reference:
        spread = float(np.ptp(reference[name]))
        if name not in reference.accounts.values() and spread > 0:
            worst = max(worst, float(np.abs(result[name] - reference[name]).max()) / spread)
    return worst
