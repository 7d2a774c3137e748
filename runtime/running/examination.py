"""Runs of an ensemble that rounding may decide: a few of them are repeated alone.

To see whether rounding decides a run takes three runs alone (`subtolerance.py`), which cost as much
as dozens in the lanes of vector registers. Of the instances with a state that fell below its
tolerance and grew again, those examined are spread evenly, the first among them; the first that
rounding decides is given a tolerance that cures it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bgc.runtime.running.batches import Work
from bgc.runtime.running.simulate import rounding_warnings
from bgc.runtime.running.subtolerance import is_repeatable

_ONE_IN = 32  # instances of the ensemble
_MOST_EXAMINED = 8


def examine(work: Work) -> None:
    """Add the warnings of instances that rounding decides (BG726) to those of their runs."""
    subtolerance = sorted(work.subtolerance & work.completed)
    if work.stopping or not subtolerance or work.method.fixed or not is_repeatable(work.model):
        return
    count = min(len(subtolerance), _MOST_EXAMINED, -(-len(work.cases) // _ONE_IN))
    places = np.linspace(0, len(subtolerance) - 1, count).round().astype(int).tolist()
    note = ""
    if count < len(subtolerance):
        note = (
            f"{count} of the {len(subtolerance)} instances in which a state fell so were examined"
        )
    cured = False
    for place in places:
        number = subtolerance[place]
        for warning in rounding_warnings(
            work.model, work.method, work.times, work.cases[number], cure=not cured
        ):
            noted = replace(warning, note=note)
            work.warned[number] = (*work.warned.get(number, ()), noted)
            cured = True
