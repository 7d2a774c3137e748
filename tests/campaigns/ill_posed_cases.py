"""The cases of a campaign of ill-posed models: each is refused, or its run ends with a code."""

from __future__ import annotations

import random
from pathlib import Path

import ill_posed_equations as equations
import ill_posed_graphs as graphs
import ill_posed_runs as runs
import ill_posed_values as values
from ill_posed import drafted
from judging import Verdict, judged, run_briefly

RUN_SECONDS = 20.0  # of processor time

GENERATORS = {
    generator.__name__: generator
    for module in (graphs, values, equations, runs)
    for generator in module.GENERATORS
}
"""The generators by name, in the order of the numbers of their cases."""


def text_of(seed: int, number: int) -> tuple[str, bytes]:
    """The name of a case's generator, and its text; the generators follow each other in turn."""
    name, text, _ = _drafted(seed, number)
    return name, text.encode()


def _drafted(seed: int, number: int) -> tuple[str, str, bool]:
    name = list(GENERATORS)[number % len(GENERATORS)]
    rng = random.Random(f"{seed}:{number}")
    core = GENERATORS[name](rng)
    return name, drafted(rng, core), core.warns


def judge(seed: int, number: int, folder: Path) -> list[Verdict]:
    """`refused` by the compiler, `stopped` in its run, `warned` where that will do, or a fault."""
    name, text, warns = _drafted(seed, number)
    path = folder / "ill_posed.bg"
    path.write_text(text, "utf-8")
    verdict = judged(path, verify=True)
    if verdict.outcome in ("accepted", "parts only"):
        verdict = run_briefly(path, RUN_SECONDS)
    if verdict.outcome in ("ran", "slow", "accepted", "parts only"):
        if warns and verdict.codes:
            return [Verdict("warned", verdict.codes)]
        return [Verdict("silent", verdict.codes, f"{name}: {verdict.outcome}")]
    return [verdict]
